"""Dry friction at joints in the kernel's loop: where it sticks and slides, and that it never gives energy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mbproj
from mbproj.base.registry import PROJECTIONS
from tests.crossed import FULL, cover, crossed
from tests.friction import closed_forms as exact
from tests.friction.mechanisms import incline, on_a_belt, pendulum, rotor, screw
from tests.friction.slider_crank import linkage
from tests.kernel.scenes import needs_kernel
from tests.stops.runs import goes_on, run, same, simulated

BELT = exact.Belt(m=2.0, k=300.0, v=0.1, sliding=6.0, static=9.0)
MECHANISMS = Path(mbproj.__file__).parents[1] / "mechanisms"
PLANES = ("planar", "reduced")
#: Steps of dop853 below which methods of the two ways have the same motion to 1e-9, and fixed ones.
STEPS = {
    "dop853": "integrator: dop853, tolerance: 1.0e-12, output_step: 0.047",
    "rk4": "integrator: rk4, step: 5.0e-4, output_step: 0.047",
}

#: Three blocks in a row on one rail, each with friction on the one before, so that what one bears loads the others;
#: the last is pushed to and fro, and one after the other breaks away and sticks again.
TRAIN = """
mbproj: 1
gravity: [0, -9.81, 0]
simulation: {{duration: 6, {steps}, formulation: {formulation}}}
bodies:
  low: {{mass: 3, inertia: [1, 1, 1], position: [0, 0, 0]}}
  middle: {{mass: 2, inertia: [1, 1, 1], position: [0, 0.1, 0]}}
  high: {{mass: 1, inertia: [1, 1, 1], position: [0, 0.2, 0]}}
joints:
  A: {{type: prismatic, bodies: [ground, low], location: [0, 0, 0], axis: [1, 0, 0]}}
  B: {{type: prismatic, bodies: [low, middle], location: [0, 0.1, 0], axis: [1, 0, 0]}}
  C: {{type: prismatic, bodies: [middle, high], location: [0, 0.2, 0], axis: [1, 0, 0]}}
forces:
  first: {{type: friction, joint: A, coulomb: {{coefficient: 0.05, static: 0.06}}}}
  second: {{type: friction, joint: B, coulomb: {{coefficient: 0.12, static: 0.15, stribeck_speed: 0.2}}}}
  third: {{type: friction, joint: C, coulomb: {{force: 7.5, static: 9}}}}
  push: {{type: force, body: high, location: [0, 0.2, 0], force: ["4 * t * sin(3 * t)", "-5 * t", 0]}}
"""


def mechanism(name, steps, formulation):
    """One of the mechanisms of the project, with other steps."""
    text = (MECHANISMS / f"{name}.yaml").read_text(encoding="utf-8").partition("expect:")[0]
    kept = [
        line for line in text.splitlines() if not line.startswith(("  tolerance:", "  integrator:", "  output_step:"))
    ]
    own = [f"  {part}" for part in (*STEPS[steps].split(", "), f"formulation: {formulation}")]
    at = kept.index("simulation:") + 1
    return "\n".join([*kept[:at], *own, *kept[at:]])


def scenes(steps, formulation):
    """Texts by name."""
    given = {"steps": STEPS[steps], "formulation": formulation}
    coefficient = "{coefficient: 0.3, static: 0.4}"
    found = {
        "a belt": on_a_belt(BELT, "{force: 6, static: 9}", duration=4.0, **given),
        "a belt with Stribeck's law": on_a_belt(
            BELT, "{force: 6, static: 9, stribeck_speed: 0.1}", duration=4.0, **given
        ),
        "a rotor that is turned to and fro": rotor(
            "{torque: 4, static: 5}", speed=0.5, load="7*sin(4*t)", duration=4.0, **given
        ),
        "a pendulum": pendulum("{torque: 0.8, static: 1.0}", duration=8.0, **given),
        "a drum brake": mechanism("drum_brake", steps, formulation),
    }
    if formulation == "reduced":
        found |= {
            "a train": TRAIN.format(**given),
            "an incline": incline("0.6*sin(2*t)", coefficient, duration=4.0, **given),
            "a screw": screw(
                "{coefficient: 0.1, radius: 0.01}", m=20.0, J=0.3, h=0.002, torque="2*sin(5*t)", duration=3.0, **given
            ),
            "a slider-crank": linkage(12.0, 0.3, 0.4, 1.5, "reduced", steps),
            "a door that closes": mechanism("door_closer", steps, formulation),
        }
    return found


CASES = [
    (name, formulation, steps) for formulation in PLANES for name in scenes("dop853", formulation) for steps in STEPS
]
NEEDED = cover(CASES)
RECORDED = (
    "bodies/position",
    "bodies/velocity",
    "friction/force",
    "friction/state",
    "friction/dissipation",
    "joints/reaction_force",
    "diagnostics/work",
)


@needs_kernel
@pytest.mark.parametrize(
    ("name", "formulation", "steps"),
    [pytest.param(*case, marks=() if case in NEEDED else FULL) for case in CASES],
)
def test_friction_changes_its_state_and_no_energy_is_lost_elsewhere(name, formulation, steps):
    """What it takes is never negative, and grows while it slides alone."""
    report, recorded = run(scenes(steps, formulation)[name])
    assert len(recorded.of("slip", "stick", "turn")) > 0
    lost, slides = recorded["friction/dissipation"], recorded["friction/state"]
    taken = np.diff(lost, axis=0)
    scale = max(1.0, np.abs(lost).max())
    assert taken.min() > -1e-9 * scale
    stays = (slides[1:] == 0) & (slides[:-1] == 0) & (np.abs(taken) > 1e-9 * scale)
    times = np.array([event.time for event in recorded.of("slip", "stick", "turn")])
    for at in np.flatnonzero(stays.any(axis=1)):  # it has slid between the samples
        assert ((recorded["time"][at] <= times) & (times <= recorded["time"][at + 1])).any()
    assert recorded.unbalanced < 1e-6 * scale
    assert report.position_violation.value < 2e-13


@needs_kernel
@crossed("name, steps", scenes("dop853", "planar"), STEPS, together=1)
def test_it_is_the_same_in_the_plane_and_in_space(name, steps):
    same(run(scenes(steps, "planar")[name])[1], run(scenes(steps, "reduced")[name])[1], RECORDED, 1e-7)


PROJECTED = {
    **{method: f"{{method: {method}}}" for method, entry in PROJECTIONS.items() if entry.compiled},
    "every five steps": "{every: 5}",
    "from a threshold on": "{threshold: 1.0e-7}",
    "positions alone": "{velocity: false}",
}


@needs_kernel
@pytest.mark.parametrize("projection", PROJECTED)
def test_events_do_not_ask_for_steps_that_end_on_the_constraints(projection):
    """A slider-crank by any projection method, or none, sticks and slides when it does by the usual one."""
    text = linkage(12.0, 0.3, 0.4, 1.5, "reduced", "rk4")
    _, usual = run(text)
    text = text.replace("simulation: {", f"simulation: {{projection: {PROJECTED[projection]}, ", 1)
    assert "projection:" in text
    same(run(text)[1], usual, ("bodies/velocity",), 1e-5)
    assert len(usual.happened) > 2


@needs_kernel
@crossed("until, steps", [0.45, 2.6, 3.2, 5.1], STEPS, together=1)
def test_a_run_with_blocks_that_stick_goes_on_with_the_bits_of_a_longer_one(steps, until):
    """With some blocks that stick and others that slide."""
    text = TRAIN.format(steps=STEPS[steps], formulation="reduced")
    whole, _, _ = goes_on(text, 6, until, ("friction/force", "friction/dissipation"))
    assert len({event.name for event in whole.happened}) == 3


@needs_kernel
def test_samples_have_no_say_in_the_motion():
    """Ten times as many: the same events."""
    text = TRAIN.format(steps=STEPS["dop853"], formulation="reduced")
    _, few = run(text)
    _, many = run(text.replace("output_step: 0.047", "output_step: 0.0047"))
    assert [event.name + event.kind for event in many.happened] == [event.name + event.kind for event in few.happened]
    assert [event.time for event in many.happened] == pytest.approx([event.time for event in few.happened], abs=1e-9)
    assert len(few.happened) > 10


#: A ball between two ends, and beside it a block with friction that is pushed to and fro.
BALL_AND_BLOCK = """
mbproj: 1
gravity: [0, 0, 0]
simulation:
  {{duration: {duration}, integrator: dop853, tolerance: 1.0e-10, output_step: 0.5, formulation: {formulation}}}
bodies:
  ball: {{mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}
  block: {{mass: 1, inertia: [1, 1, 1], position: [0, 1, 0]}}
joints:
  way:
    type: prismatic
    bodies: [ground, ball]
    location: [0, 0, 0]
    axis: [1, 0, 0]
    speed: 1
    limits: {{displacement: {{range: [-0.1, 0.1], rigid: true, restitution: 0.9}}}}
  rail: {{type: prismatic, bodies: [ground, block], location: [0, 1, 0], axis: [1, 0, 0]}}
forces:
  rub: {{type: friction, joint: rail, coulomb: {{force: 2, static: 3}}}}
  push: {{type: force, body: block, location: [0, 1, 0], force: ["8 * sin(9 * t)", 0, 0]}}
"""


@needs_kernel
@pytest.mark.parametrize("formulation", PLANES)
def test_a_run_that_goes_on_records_each_event_once(formulation):
    """From before the last impact of a shorter run, after impacts and slips."""
    ball = 0.1 + 0.2 * np.cumsum(0.9 ** -np.arange(1.0, 40.0))  # when it is at an end, after the first time
    whole, _ = simulated(BALL_AND_BLOCK.format(duration=3, formulation=formulation))
    impacts = [0.1, *ball[ball < 3.0]]
    assert [event.time for event in whole.of("impact")] == pytest.approx(impacts, abs=1e-8)
    assert len(whole.of("slip", "stick", "turn")) > 2
    earlier = 0
    for until in np.array(impacts[3:]) + 0.01:
        part, kept = simulated(BALL_AND_BLOCK.format(duration=until, formulation=formulation))
        mark = kept[-1]
        earlier += any(event.time > mark["t"] for event in part.of("impact"))
        rest, _ = simulated(BALL_AND_BLOCK.format(duration=3, formulation=formulation), mark)
        assert rest.happened == whole.happened
    assert earlier > 0


@needs_kernel
def test_what_sticks_slips_as_soon_as_it_may():
    """Steps grow long while nothing moves: a load that pulls to one side and then to the other within one of them."""
    _, recorded = run(rotor("{torque: 4, static: 5}", speed=0.0, load="7*sin(4*t)", duration=3.9))
    changes = [(event.time, event.kind) for event in recorded.of("slip", "stick", "turn")]
    assert [kind for _, kind in changes] == [*["slip", "stick"] * 4, "slip"]
    begins, ends = (np.array([t for t, kind in changes if kind == which]) for which in ("slip", "stick"))
    first = (np.arcsin(5.0 / 7.0) + np.pi * np.arange(5)) / 4.0  # once each half period of the load
    assert begins == pytest.approx(first, abs=1e-9)
    assert (ends < first[:4] + np.pi / 4.0).all()


# Dry friction takes energy and never gives any: chains at random in space, with frictions of every kind.

KINDS = ("revolute", "prismatic", "cylindrical", "screw")


def law(rng, unit):
    """The keys of a friction on a coordinate in this unit: constant or by the force, with and without Stribeck."""
    keys = {}
    if rng.random() < 0.5:
        keys["torque" if unit == "rad" else "force"] = size = rng.uniform(0.2, 1.0)
    else:
        keys["coefficient"] = size = rng.uniform(0.05, 0.2)
        keys["preload"] = rng.uniform(0.0, 1.0)
        if unit == "rad":
            keys["radius"] = rng.uniform(0.02, 0.1)
    if rng.random() < 0.7:
        keys["static"] = size * rng.uniform(1.1, 1.5)
        if rng.random() < 0.7:
            keys["stribeck_speed"] = rng.uniform(0.05, 0.5)
    return "{" + ", ".join(f"{key}: {value}" for key, value in keys.items()) + "}"


def chain(seed, steps):
    """Three bodies that hang on each other by joints of three types, moving, each with friction on its coordinates."""
    rng = np.random.default_rng(seed)
    bodies, joints, forces, before = [], [], [], "ground"
    place = np.zeros(3)
    for number, kind in enumerate(rng.permutation(KINDS)[:3]):
        axis, here = rng.normal(size=3), place.copy()
        place = place + rng.uniform(-0.3, 0.3, size=3)
        at = ", ".join(map(repr, map(float, place)))
        turn = ", ".join(map(repr, map(float, Rotation.random(random_state=int(rng.integers(1000))).as_rotvec())))
        bodies.append(f"  b{number}: {{mass: 1, inertia: [0.1, 0.12, 0.15], position: [{at}],")
        bodies.append(f"    orientation: {{axis: [{turn}], angle: 1}}}}")
        units = {"revolute": {"angle": "rad"}, "prismatic": {"displacement": "m"}}.get(
            kind, {"angle": "rad", "displacement": "m"}
        )
        speeds = {name: rng.uniform(-1.0, 1.0) for name in units}
        if kind == "screw":
            speeds = {"angle": rng.uniform(-1.0, 1.0)}
        speed = f"{{{', '.join(f'{k}: {v}' for k, v in speeds.items())}}}" if len(units) > 1 else speeds.popitem()[1]
        pitch = ", pitch: 0.3" if kind == "screw" else ""
        where = ", ".join(map(repr, map(float, here)))
        along = ", ".join(map(repr, map(float, axis)))
        joints.append(
            f"  j{number}: {{type: {kind}, bodies: [{before}, b{number}], location: [{where}], axis: [{along}],"
        )
        joints.append(f"    speed: {speed}{pitch}}}")
        laws = {name: law(rng, unit) for name, unit in units.items()}
        coulomb = f"{{{', '.join(f'{k}: {v}' for k, v in laws.items())}}}" if len(units) > 1 else laws.popitem()[1]
        forces.append(f"  f{number}: {{type: friction, joint: j{number}, coulomb: {coulomb}}}")
        before = f"b{number}"
    return "\n".join(
        [
            "mbproj: 1",
            "gravity: [0, 0, -9.81]",
            f"simulation: {{duration: 0.6, {steps}}}",
            "bodies:",
            *bodies,
            "joints:",
            *joints,
            "forces:",
            *forces,
        ]
    )


@pytest.mark.parametrize("seed", range(4))
def test_energy_never_grows_and_the_balance_closes(seed):
    steps = "integrator: dop853, tolerance: 1.0e-10, output_step: 0.01, formulation: reduced"
    _, recorded = run(chain(seed, steps))
    size = max(1.0, np.ptp(recorded["diagnostics/kinetic_energy"]))
    assert np.diff(recorded["diagnostics/total_energy"]).max() < 1e-8 * size
    assert np.diff(recorded["friction/dissipation"], axis=0).min() > -1e-10
    assert recorded["friction/dissipation"][-1].sum() > 0.01
    assert recorded.unbalanced < 1e-7 * size
    force, state = recorded["friction/force"], recorded["friction/state"]
    assert set(np.unique(state)) <= {-1, 0, 1}
    assert (force[state == 1] <= 1e-9).all()
    assert (force[state == -1] >= -1e-9).all()
    assert recorded["joints/violation"].max() < 2e-13


def test_full_and_reduced_find_the_same_motion():
    steps = "integrator: dop853, tolerance: 1.0e-10, output_step: 0.05, formulation: "
    texts = [
        chain(1, steps + formulation).replace("duration: 0.6", "duration: 0.05") for formulation in ("full", "reduced")
    ]
    ends = [run(text)[1] for text in texts]
    times = [[(event.kind, event.name, event.time) for event in end.of("stick", "slip")] for end in ends]
    assert [each[:2] for each in times[0]] == [each[:2] for each in times[1]]
    assert [each[2] for each in times[0]] == pytest.approx([each[2] for each in times[1]], abs=1e-7)
    assert ends[0]["bodies/position"][-1] == pytest.approx(ends[1]["bodies/position"][-1], abs=1e-7)
