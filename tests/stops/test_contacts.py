"""Contacts in the kernel: what happens at stops, and contacts as a border on the joints' factor."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import read_scene_text, settings_to_run
from mbproj.base.settings import Settings
from mbproj.equations.assembly.assemble import coordinate_values
from mbproj.equations.constraints import set_bias, set_jacobian
from mbproj.equations.contacts import Freedom
from mbproj.equations.derivatives import MotionAtTime, tangent_force
from mbproj.equations.motions import drive_at
from mbproj.equations.rank.row_space import tangent_gamma
from mbproj.equations.tangent_space import tangent_velocities
from mbproj.kernel import core
from mbproj.model.contacts import Contacts, in_contact
from mbproj.motion.formulations.choice import choose
from mbproj.motion.formulations.reduced import Reduced
from tests.crossed import FULL, cover, crossed, some
from tests.kernel.scenes import needs_kernel
from tests.stops.runs import DOP853, FIXED, goes_on, run, same
from tests.stops.scenes import (
    BALL,
    BEAM,
    BETWEEN_WALLS,
    BUFFERS,
    CRADLE,
    DRIVEN,
    PRESSED,
    PRESSED_LOOP,
    ROD,
    SCENE,
    SOFT_BALL,
    THREE_BALLS,
)
from tests.support import assembled

pytestmark = needs_kernel


# What happens at stops: what each law of contact says, in the plane and in space alike.

STEPS = (
    DOP853,
    FIXED,
    "integrator: esdirk4, tolerance: 1.0e-8, output_step: 0.1",
    "integrator: radau5, step: 2.0e-3, output_step: 0.1",
)
IN_THE_PLANE, IN_SPACE = ("planar", "reduced"), ("reduced",)
SCENES = {
    "a ball that bounces and rests": (BALL, IN_SPACE, {"e": 0.6, "duration": 2.5}),
    "a rod": (ROD, IN_THE_PLANE, {}),
    "a cradle": (CRADLE, IN_SPACE, {"e": 0.5, "third": 0.4}),
    "a block that is lifted": (PRESSED, IN_THE_PLANE, {}),
    "between walls": (BETWEEN_WALLS, IN_THE_PLANE, {"e": 0.9}),
    "a pusher that a motion drives": (
        DRIVEN.replace("duration: 1", "duration: 0.7"),
        IN_SPACE,
        {"wall": "rigid: true"},
    ),
    "three balls": (THREE_BALLS, IN_SPACE, {}),
    "a beam on three points": (BEAM, IN_THE_PLANE, {}),
    "pressed through a loop": (PRESSED_LOOP, IN_THE_PLANE, {}),
    "a rod without mass": (
        PRESSED_LOOP.replace("rod: {{mass: 1, inertia: [7.0e-3, 7.0e-3, 7.0e-3]", "rod: {{mass: 0, inertia: [0, 0, 0]"),
        IN_SPACE,
        {},
    ),
    "three balls by Poisson's law": (
        THREE_BALLS.replace("{{duration: 3", "{{impact_law: poisson, duration: 1").replace("0.5}}", "0.8}}"),
        IN_SPACE,
        {},
    ),
    "a rod by the energetic law": (ROD.replace("{{duration", "{{impact_law: energetic, duration"), IN_THE_PLANE, {}),
    "buffers": (BUFFERS, IN_THE_PLANE, {}),
    "a ball on a soft floor": (SOFT_BALL, IN_SPACE, {}),
}
CASES = [(name, formulation) for name, (_, formulations, _) in SCENES.items() for formulation in formulations]
#: All with explicit steps; every other one with either kind of implicit steps.
PAIRS = [(*case, steps) for number, case in enumerate(CASES) for steps in (*STEPS[:2], STEPS[2 + number % 2])]
NEEDED = cover(PAIRS)
RECORDED = (
    "bodies/position",
    "bodies/velocity",
    "stops/gap",
    "stops/force",
    "joints/reaction_force",
    "diagnostics/dissipation",
    "diagnostics/work",
)


#: How far the energy of a run may be off, J: what steps of these kinds leave.
UNBALANCED = dict(zip(STEPS, (1e-8, 1e-4, 1e-5, 1e-5), strict=True))


def text_of(name, formulation, steps):
    text, _, more = SCENES[name]
    return text.format(steps=steps, formulation=formulation, **more)


@pytest.mark.parametrize(
    ("name", "formulation", "steps"),
    [pytest.param(*case, marks=() if case in NEEDED else FULL) for case in PAIRS],
)
def test_stops_push_what_touches_and_nothing_passes(name, formulation, steps):
    """No stop pulls; what pushes is closed, or pressed in; and all energy is where it went."""
    text = text_of(name, formulation, steps)
    report, recorded = run(text)
    gap, force = recorded["stops/gap"], recorded["stops/force"]
    near = 1e-9 if steps in (DOP853, FIXED) else 2e-7  # implicit stages are solved to their tolerance
    assert len(recorded.happened) > 0
    assert force.min() >= 0.0
    if "stiffness" not in text:
        assert gap.min() > -near
        assert (gap * force).max() < near * max(1.0, force.max())
    assert recorded.unbalanced < UNBALANCED[steps] * max(1.0, np.abs(recorded["diagnostics/work"]).max())
    assert report.position_violation.value < 2e-13


@pytest.mark.parametrize(("name", "steps"), some([(name, steps) for name, own, steps in PAIRS if own == "planar"], 2))
def test_it_is_the_same_in_the_plane_and_in_space(name, steps):
    _, plane = run(text_of(name, "planar", steps))
    _, space = run(text_of(name, "reduced", steps))
    if "stiffness" in SCENES[name][0]:  # forces beside a length
        for block in (*plane.blocks, *space.blocks):
            block["stops/force"] *= 1e-3
    same(plane, space, RECORDED, 1e-8 if steps in (DOP853, FIXED) else 2e-6)


@pytest.mark.parametrize("steps", STEPS)
def test_a_rod_without_mass_bears_the_push_of_stops_in_the_plane_as_in_space(steps):
    """Rows of contacts are a border, which lends no mass. A rod without mass pushes along itself alone."""
    _, space = run(text_of("a rod without mass", "reduced", steps))
    _, plane = run(text_of("a rod without mass", "planar", steps))
    told = [[(event.name, event.kind) for event in each.happened] for each in (plane, space)]
    assert told[0] == told[1]
    for path in ("bodies/position", "bodies/velocity"):
        np.testing.assert_allclose(plane[path], space[path], rtol=0, atol=1e-6, err_msg=path)
    force, moving = plane["joints/reaction_force"][:, 1], plane["bodies/position"]
    along = moving[:, 2] - 2.0 * moving[:, 0]  # from the crank's pin to the slider's
    across = force[:, 0] * along[:, 1] - force[:, 1] * along[:, 0]
    np.testing.assert_allclose(across, 0.0, atol=1e-6 * np.abs(force).max())


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["reduced", "planar", "full"])
@pytest.mark.parametrize("inertia", [0.0, 1.5])
def test_a_motion_pays_for_what_flywheels_take_in_no_time(formulation, inertia):
    """A block of 2 kg, with a reflected mass, is pushed to 1 m/s at once: the impulse is m v, its work m v²; half of
    it is lost. The pusher's own reflected mass has no say."""
    text = DRIVEN.format(steps=f"{DOP853}, formulation: {formulation}", wall="rigid: true")
    for joint, reflected in (("    axis: [1, 0, 0]\n", inertia), ("location: [0, 0, 0], axis: [1, 0, 0]}", 0.7)):
        assert joint in text
        own = f"reflected_inertia: {reflected}"
        with_own = f"{joint}    {own}\n" if joint.endswith("\n") else f"{joint[:-1]}, {own}}}"
        text = text.replace(joint, with_own if reflected else joint)
    _, recorded = run(text.replace("duration: 1", "duration: 0.7"))
    assert [event.time for event in recorded.of("impact")] == pytest.approx([0.5], abs=1e-12)
    assert recorded.of("impact")[0].impulse == pytest.approx(2.0 + inertia, rel=1e-12)
    assert recorded["diagnostics/work"][-1] == pytest.approx(2.0 + inertia, rel=1e-10)
    assert recorded["diagnostics/dissipation"][-1] == pytest.approx(0.5 * (2.0 + inertia), rel=1e-10)


@crossed("until, steps", [0.35, 1.1, 1.9], STEPS, together=1)
def test_a_run_goes_on_with_the_bits_of_a_longer_one(steps, until):
    """Before and after impacts, with contacts that hold, on a loop with a spring that becomes slack."""
    text = text_of("pressed through a loop", "planar", steps)
    goes_on(text, 3, until, ("stops/force", "diagnostics/dissipation"))


@pytest.mark.parametrize("integrator", ["dop853", "esdirk4", "radau5"])
@pytest.mark.parametrize("at", np.linspace(0.0, 1.0, 9))
def test_what_flies_through_another_body_within_one_step_is_met(integrator, at):
    """Nothing accelerates, so that a step is as long as the run: the first ball meets the second when it is there."""
    text = text_of("a cradle", "reduced", f"integrator: {integrator}, tolerance: 1.0e-8, output_step: 0.1")
    text = text.replace("[0.1, 0, 0]", f"[{0.1 + at}, 0, 0]").replace("[0.4, 0, 0]", "[9, 0, 0]")
    _, found = run(text)
    assert [(event.name, event.kind) for event in found.happened] == [("stop 'left'", "impact")]
    assert found.happened[0].time == pytest.approx(0.25 + 0.5 * at, abs=1e-9)


def test_contacts_that_depend_on_each_other_are_decided_anew():
    """Both ends of one range cannot hold: at the bob's height neither touches, and it swings on."""
    scene = read_scene_text(text_of("between walls", "planar", DOP853))
    (system, state), settings = assembled(scene), settings_to_run(scene)
    compiled = choose(system, state, settings).compiled
    run = compiled.run(state, settings)
    known = {"held": [0, 1], "push": 1.0, "fastest": 1.0, "met_at": 0.0, "met_often": 1}
    laws = [(float(side), 0.5, 1e-12, 1.0, -1, 0.0, 0.0) for side in system.stops.side]
    run.begin_contacts(laws, [], {**known, "lost": 0.0, "work": 0.0, "events": 0}, 0.1, 0, None)
    run.advance(1, 1.0)
    block = run.advance(10, 1.0)
    assert run.outcome.status == compiled.core.Status.running
    assert run.contacts["held"] == []
    assert block["t"][0] == 0.0


def test_samples_have_no_say_in_the_motion():
    """Ten times as many: the same impacts and contacts, bit for bit."""
    text = text_of("between walls", "planar", DOP853)
    _, few = run(text)
    _, many = run(text.replace("output_step: 0.1", "output_step: 0.01"))
    assert many.happened == few.happened
    assert len(few.happened) > 5


# Contacts as a border on the joints' factor: their operator is that of the whole equations, and what they hold does not
# accelerate.

#: A slider-crank that turns, in the plane, with a stop at its slider, one at its rocker's angle, and a rope.
LOOP = """
mbproj: 1
gravity: [0, -9.81, 0]
simulation: {duration: 1, step: 1 ms}
bodies:
  crank: {mass: 1, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0.05, 0, 0]}
  rod: {mass: 2, inertia: [7.0e-3, 7.0e-3, 7.0e-3], position: [0.25, 0, 0]}
  slider: {mass: 3, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0.4, 0, 0]}
  weight: {mass: 0.5, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0.4, -0.2, 0]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 0, 1], angle: 50 deg, speed: 4}
  B: {type: revolute, bodies: [crank, rod], location: [0.1, 0, 0], axis: [0, 0, 1]}
  C: {type: revolute, bodies: [rod, slider], location: [0.4, 0, 0], axis: [0, 0, 1]}
  D:
    type: prismatic
    bodies: [ground, slider]
    location: [0.4, 0, 0]
    axis: [1, 0, 0]
    limits: {displacement: {range: [null, 1], rigid: true}}
  P:
    type: revolute
    bodies: [slider, weight]
    location: [0.4, 0, 0]
    axis: [0, 0, 1]
    speed: 3
    limits: {angle: {range: [-3, 3], rigid: true}}
forces:
  rope: {type: stop, points: {ground: [0, -1, 0], weight: [0.4, -0.2, 0]}, longest: 5 m, rigid: true}
"""

#: A door, a block and a ball on its way, with stops between them.
THROWN = SCENE.replace("position: [2, 0, 1.3],", "position: [2, 0, 1.3], velocity: [1, -2, 0.5],")


def opened(text, formulation):
    """The mechanism, a state of it, and what runs it in the kernel."""
    system, state = assembled(read_scene_text(text))
    return system, state, choose(system, state, Settings(duration=1.0, step=1e-3, formulation=formulation)).compiled


def gap_accelerations(freedom):
    """g'' of the gaps (S,) where no stop acts, by minimal coordinates."""
    system, state, pose, twist = freedom.system, freedom.state, freedom.pose, freedom.twist
    along, counted = system.stops.coordinates, coordinate_values(system, pose) + 2.0 * np.pi * state.turns
    change = freedom.smallest @ tangent_gamma(system, pose, twist, drive_at(system, state.t))
    moving = MotionAtTime(state.t, state.q, tangent_velocities(pose, state.v), change, counted, state.x)
    change = change + freedom.basis @ (freedom.basis.T @ tangent_force(system, moving))
    kept = np.zeros((system.bodies, 7))  # the part of Λ'' that keeps |Λ| is -|Λ'|² Λ
    kept[:, 3:] = -np.sum(twist.rate[:-1] ** 2, axis=1, keepdims=True) * pose.orientation[:-1]
    bias = set_bias(along, pose, twist) + set_jacobian(along, pose) @ kept.ravel()
    return system.stops.side * (freedom.gradients_of(along) @ change + bias)


BORDERS = [(LOOP, "planar", [0, 3]), (LOOP, "reduced", [0, 3]), (THROWN, "reduced", [1, 2, 5])]


@pytest.mark.parametrize(("text", "formulation", "which"), BORDERS)
def test_the_operator_is_that_of_the_whole_equations(text, formulation, which):
    """B = N (W⁻¹ - W⁻¹GᵀS⁻¹GW⁻¹) Nᵀ, and the gaps' accelerations without contact."""
    system, state, compiled = opened(text, formulation)
    freedom = Freedom.at(system, state)
    N = freedom.rows(system.stops)[which]
    b = gap_accelerations(freedom)[which]
    rows = [(k, float(system.stops.side[k])) for k in which]
    found, free = compiled.equations().border(compiled.state(state.q, state.v), rows)
    size = np.sqrt(np.diagonal(N @ N.T))
    np.testing.assert_allclose(found / np.outer(size, size), N @ N.T / np.outer(size, size), atol=1e-12)
    np.testing.assert_allclose(found, found.T, rtol=0, atol=1e-13 * size.max() ** 2)
    np.testing.assert_allclose(free, b, rtol=0, atol=1e-11 * np.abs(b).max())


@pytest.mark.parametrize(("text", "formulation", "which"), BORDERS)
def test_what_contacts_hold_does_not_accelerate(text, formulation, which):
    """The accelerations are those of a mechanism whose joints have these rows."""
    system, state, compiled = opened(text, formulation)
    equations, y = compiled.equations(), compiled.state(state.q, state.v)
    rows = [(k, float(system.stops.side[k])) for k in which]
    equations.border(y, rows)
    acceleration, multipliers = equations.accelerations(y)
    held = Reduced(core(), in_contact(system, Contacts(tuple(which))))
    expected, expected_multipliers = held.equations().accelerations(held.state(state.q, state.v))
    at = system.joints.size
    if formulation == "planar":
        found = compiled.acceleration(y[None], acceleration[None])
        expected = held.acceleration(held.state(state.q, state.v)[None], expected[None])
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10 * np.abs(expected).max())
        return
    np.testing.assert_allclose(acceleration, expected, rtol=0, atol=1e-10 * np.abs(expected).max())
    assert len(expected_multipliers) == len(multipliers) + len(which)
    joints = np.delete(expected_multipliers, np.arange(at, at + len(which)))
    np.testing.assert_allclose(multipliers, joints, rtol=0, atol=1e-10 * np.abs(joints).max())


def test_rows_that_depend_on_each_other_are_seen():
    """Both ends of one range: the second row is the first with the other sign, and no push is unique."""
    _, state, compiled = opened(LOOP, "planar")
    equations, y = compiled.equations(), compiled.state(state.q, state.v)
    assert equations.border(y, [(1, 1.0), (0, -1.0)]) is not None
    assert equations.border(y, [(1, 1.0), (0, -1.0), (2, -1.0)]) is None
