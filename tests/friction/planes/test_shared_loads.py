"""Feet, brakes and joints that share a load at will: what does not depend on the share, what is marked, and
certificates."""

from __future__ import annotations

import itertools
import json
from math import inf

import numpy as np
import pytest

from mbproj import Mechanism, read_scene_text, settings_to_run, simulate_certified
from mbproj.commands.report.summary import lines_on
from mbproj.motion.marks import START
from tests.cli.commands import mbproj
from tests.crossed import full
from tests.friction.closed_forms import Belt
from tests.friction.planes.scenes import CORNERS, IN_PLANE, box
from tests.kernel.scenes import needs_kernel
from tests.laws import FrictionBalance
from tests.stops.runs import run, simulated
from tests.support import Recorder

# Bodies on more feet than rigid bodies can say the loads of: what does not depend on how they share is as it must be,
# whatever the order of the feet, and what does is told.


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_beam_on_three_points_slides_as_on_one(formulation):
    """It is slowed down by μ g, whatever each foot bears."""
    places = {"a": (-0.4, 0.0), "b": (0.1, 0.0), "c": (0.35, 0.0)}
    _, recorded = run(box(places, 0.25, velocity=(1, 0, 0), joint=IN_PLANE, formulation=formulation))
    assert recorded["bodies/position"][-1, 0, 0] == pytest.approx(0.5 / 2.5, abs=1e-9)
    assert [event.time for event in recorded.of("stick")] == pytest.approx([0.4] * 3, abs=1e-5)
    assert recorded["stops/force"].sum(axis=1) == pytest.approx(30.0)
    assert recorded.unbalanced < 1e-9


def test_a_box_that_is_thrown_straight_slides_straight_on():
    report, recorded = run(box(CORNERS, 0.25, velocity=(1, 0, 0), steps="rk4"))
    assert recorded["bodies/position"][-1, 0] == pytest.approx([0.2, 0.0, 0.25], abs=1e-9)
    assert recorded["stops/force"].min() > 0.0
    assert {f"stop '{name}'" for name in "abcd"} <= {event.name for event in recorded.of("shared")}
    assert not report.decided_by_shares


def test_the_order_of_the_feet_changes_nothing_where_the_motion_depends_on_their_shares():
    """And it is said that it does."""
    ends = []
    for names in itertools.islice(itertools.permutations("abcd"), 0, None, 7):
        places = {name: CORNERS[name] for name in names}
        report, recorded = run(box(places, 0.25, velocity=(1, 0.4, 0), spin=(0, 0, 5), duration=0.3))
        assert "'a'" in report.decided_by_shares and "first at t = 0 s" in report.decided_by_shares
        ends.append(recorded["bodies/position"][-1, 0])
    assert np.ptp(ends, axis=0).max() < 1e-9


@pytest.mark.parametrize(("height", "formulation"), [(0.25, "planar"), (0.02, "planar"), (0.02, "reduced")])
def test_what_is_pushed_slips_where_all_feet_together_hold_no_more(height, formulation):
    """At static m g, however the feet share it."""
    places = {"a": (-0.45, 0.0), "b": (0.4, 0.0)}
    friction = "{coefficient: 0.3, static: 0.5}"
    text = box(places, friction, push=20, height=height, joint=IN_PLANE, formulation=formulation)
    _, recorded = run(text)
    assert [event.time for event in recorded.of("slip")] == pytest.approx([15.0 / 20.0] * 2, abs=1e-7)


def test_a_box_on_four_feet_slips_there_too():
    _, recorded = run(box(CORNERS, "{coefficient: 0.3, static: 0.5}", push=20, duration=0.8))
    assert [event.time for event in recorded.of("slip")] == pytest.approx([15.0 / 20.0] * 4, abs=1e-6)


JAWS = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {{duration: 0.1, tolerance: 1.0e-8, integrator: dop853, output_step: 0.01}}
bodies:
  jaw: {{mass: 0.3, inertia: [1.0e-4, 1.0e-4, 1.0e-4], position: [-0.03, 0, 0]}}
  part: {{mass: 0.8, inertia: [1.0e-3, 1.0e-3, 1.0e-3], position: [0, 0, 0]}}
joints:
  guide: {{type: prismatic, bodies: [ground, jaw], location: [-0.03, 0, 0], axis: [1, 0, 0]}}
forces:
  spring: {{type: linear_spring_damper, joint: guide, force: {force}}}
{points}
"""
POINT = """  {side}{z}:
    type: stop
    plane: {{body: {body}, location: [{x}, 0, 0], normal: [{normal}, 0, 0]}}
    point: {{body: part, location: [{x}, 0, {z}e-3]}}
    rigid: true
    friction: 0.3
"""


def jaws(force):
    sides = {"l": ("jaw", -0.02, 1), "r": ("ground", 0.02, -1)}
    points = (
        POINT.format(side=side, body=body, x=x, normal=normal, z=z)
        for side, (body, x, normal) in sides.items()
        for z in (7, -7)
    )
    return JAWS.format(force=force, points="".join(points))


def test_a_part_is_held_by_two_points_and_two():
    """Each pushes by half of what the jaw is pressed with, and bears a quarter of the weight."""
    _, recorded = run(jaws(50.0))
    assert np.abs(recorded["bodies/velocity"]).max() < 1e-9
    assert recorded["stops/force"] == pytest.approx(np.full((11, 4), 25.0))
    assert {"stop 'l7'", "stop 'r-7'"} <= {event.name for event in recorded.of("shared")}


def test_and_it_falls_where_they_press_too_little():
    """Four points, each with μ F/2, hold 0.6 F, less than the weight: the rest makes it fall."""
    _, recorded = run(jaws(10.0))
    assert recorded["bodies/velocity"][-1, 1, 2] == pytest.approx(-0.1 * (8.0 - 6.0) / 0.8, rel=1e-6)


def test_a_run_with_shared_loads_goes_on_as_one_run():
    text = box(CORNERS, 0.25, velocity=(1, 0.4, 0), spin=(0, 0, 5), duration=0.3)
    _, marks = simulated(text.replace("duration: 0.3", "duration: 0.2"))
    whole, _ = simulated(text, START)
    rest, _ = simulated(text, marks[-1])
    assert np.array_equal(rest["bodies/position"][-1], whole["bodies/position"][-1])


def test_the_least_share_of_what_holds_is_reported():
    """Two feet of one block bear the same part of the push, until one is at its edge."""
    places = {"a": (-0.45, 0.0), "b": (0.4, 0.0)}
    text = box(places, "{coefficient: 0.3, static: 0.5}", push=20, joint=IN_PLANE, duration=0.3)
    _, recorded = run(text)
    force = recorded["friction/force"][:, ::2]
    assert force == pytest.approx(np.repeat(-10.0 * recorded["time"][:, None], 2, axis=1), abs=1e-8)


def test_feet_that_want_what_no_forces_give_are_soon_found_out():
    """Two rows of friction are one, but for round-off: no forces hold both, and rounds would go on and on."""
    row, rounds = np.array([1.0, 0.5]), []

    def loads(y):
        rounds.append(1)
        return np.full(2, y[0])

    problem = FrictionBalance(
        A=np.array([[0.0, 1.0], row, row]),
        b=np.array([-1e-15, 1e-16, -3e-16]),
        static=np.full(2, 0.4),
        sliding=np.full(2, 0.4),
        direction=np.zeros(2),
        partner=np.full(2, -1),
        stop=np.zeros(2, dtype=int),
        loads=loads,
    )
    y = problem.forces()
    assert (np.abs(y[1:]) <= 0.4 * y[0] * (1.0 + 1e-12)).all()
    assert (problem.accelerations(y)[:1] >= -1e-25).all()
    assert len(rounds) < 5000


# A certificate of feet that share a load: its error covers the slack with which they slip, and the shares.

GRAVITY = 10.0
ON_A_BELT = """
mbproj: 1
gravity: [0, 0, -10]
simulation: {{duration: {duration}, integrator: dop853, tolerance: 1e-11, output_step: 0.02}}
bodies:
  belt: {{mass: 1, inertia: [1, 1, 1], position: [0, 0, 0]}}
  block: {{mass: {m}, inertia: [0.02, 0.04, 0.03], position: [0, 0, 0.1], velocity: [{v}, 0, 0]}}
joints:
  drive: {{type: prismatic, bodies: [ground, belt], location: [0, 0, 0], axis: x}}
  {joint}
motions:
  running: {{joint: drive, displacement: {v}*t}}
forces:
{feet}
  spring: {{type: spring_damper, points: {{ground: [-2, 0, 0.1], block: [0, 0, 0.1]}}, stiffness: {k}, free_length: 2}}
"""
ON_THE_BELT = """  {name}:
    type: stop
    plane: {{body: belt, location: [0, 0, 0], normal: [0, 0, 1]}}
    point: {{body: block, location: [{x}, {y}, 0]}}
    rigid: true
    friction: {{coefficient: {sliding}, static: {static}}}
"""
BESIDE = "P: {type: planar, bodies: [ground, block], location: [0, 0, 0], axis: y}"
IN_LINE = {"a": (0.25, 0.0), "b": (-0.3, 0.0)}
#: Places of feet, a joint, and the numbers of the belt with its coefficients of friction.
BELTS = (
    (IN_LINE, BESIDE, Belt(m=2.0, k=30.0, v=0.25, sliding=4.0, static=6.0)),
    ({**IN_LINE, "c": (0.1, 0.0)}, BESIDE, Belt(m=1.0, k=10.0, v=0.2, sliding=2.0, static=3.0)),
    ({"a": (0.3, 0.2), "b": (-0.3, 0.2), "c": (-0.3, -0.2), "d": (0.3, -0.2)}, "", Belt(1.5, 20.0, 0.3, 2.0, 4.0)),
)


class Kept(Recorder):
    """A recorder of blocks and of the certificate."""

    def trust(self, trust):
        self.certificate = trust


def certified(text, limits=(1e-12, 1e-9, 1e-6, 1e-3)):
    """The paths of the bodies, and the certificate."""
    scene, recorder = read_scene_text(text), Kept()
    _, trust = simulate_certified(Mechanism.of(scene), settings_to_run(scene), recorder, limits=limits)
    return recorder, trust


@needs_kernel
@pytest.mark.parametrize(("places", "joint", "belt"), [BELTS[0], *(full(*each) for each in BELTS[1:])])
def test_the_slack_with_which_feet_slip_is_part_of_the_error(places, joint, belt):
    """They slip some 2e-9 of their time early, for the slack of shared friction. The certificate said 1e-12 m."""
    load = belt.m * GRAVITY
    friction = {"sliding": belt.sliding / load, "static": belt.static / load}
    feet = "".join(ON_THE_BELT.format(name=name, x=x, y=y, **friction) for name, (x, y) in places.items())
    duration = 0.02 * round(50.0 * (belt.first_slip + 1.7 * belt.period))
    recorded, trust = certified(
        ON_A_BELT.format(feet=feet, joint=joint, m=belt.m, k=belt.k, v=belt.v, duration=duration)
    )
    times, path = recorded["time"], recorded["bodies/position"][:, 1, 0]
    exact = np.where(times < belt.first_slip, belt.v * times, belt(times))
    off, block = np.abs(path - exact), trust.names.index("block")
    assert 1e-10 < off.max() < 1e-7
    assert np.all(off <= trust.error[:, block] + trust.uncertainty[:, block] + 1e-15)
    assert trust.uncertainty[:, block].max() < 30.0 * off.max()
    assert trust.horizon_low[block, 1] < inf


@needs_kernel
@pytest.mark.parametrize(("places", "joint"), [({"a": (0.3, 0.0), "b": (-0.35, 0.0)}, IN_PLANE), (CORNERS, "")])
def test_feet_that_a_growing_force_tears_loose_have_their_slack_in_the_error(places, joint):
    """They hold up to 0.3 m g, and slide with 0.2 m g: from then on m x'' = p t - 0.2 m g."""
    push, mass, duration = 25.0, 3.0, 0.7
    recorded, trust = certified(
        box(places, "{coefficient: 0.2, static: 0.3}", push=push, height=0.05, joint=joint, duration=duration)
    )
    t, slips = recorded["time"], 0.3 * mass * GRAVITY / push
    after = np.maximum(t - slips, 0.0)
    path = (
        push * (t**3 - slips**3) / 6.0 / mass
        - push * slips**2 / 2.0 / mass * after
        - 0.1 * GRAVITY * 2.0 * after**2 / 2.0
    )
    off = np.abs(recorded["bodies/position"][:, 0, 0] - np.where(t < slips, 0.0, path))
    assert off.max() > 1e-11
    assert np.all(off <= trust.error[:, 0] + trust.uncertainty[:, 0] + 1e-15)
    assert trust.uncertainty.max() < 100.0 * off.max()


def path_of_the_box(places, share, velocity, spin, friction, duration, steps=400):
    """Where a box that slides and turns on feet comes, (2,), by RK4. Of the loads that balance it, its feet have one at
    the part `share` of the way from the one to the other edge of those in which no foot pulls."""
    own, mass, moment, height = np.array(list(places.values())), 3.0, 0.12, 0.25

    def loads(direction, arms):
        balance = np.stack(
            [np.ones(len(arms)), arms[:, 1] + height * direction[:, 1], arms[:, 0] + height * direction[:, 0]]
        )
        least = np.linalg.lstsq(balance, [mass * GRAVITY, 0.0, 0.0], rcond=None)[0]
        open_ = np.linalg.svd(balance)[2][-1]
        open_ *= np.sign(open_[0])
        low, high = (-least[open_ > 0.0] / open_[open_ > 0.0]).max(), (-least[open_ < 0.0] / open_[open_ < 0.0]).min()
        return least + (low + share * (high - low)) * open_

    def rate(y):
        c, s = np.cos(y[2]), np.sin(y[2])
        arms = own @ np.array([[c, s], [-s, c]])
        slides = y[3:5] + y[5] * np.stack([-arms[:, 1], arms[:, 0]], axis=1)
        direction = -friction * slides / np.linalg.norm(slides, axis=1)[:, None]
        force = loads(direction, arms)[:, None] * direction
        turning = np.sum(arms[:, 0] * force[:, 1] - arms[:, 1] * force[:, 0]) / moment
        return np.concatenate([y[3:], force.sum(axis=0) / mass, [turning]])

    y, h = np.array([0.0, 0.0, 0.0, *velocity, spin]), duration / steps
    for _ in range(steps):
        k1 = rate(y)
        k2 = rate(y + 0.5 * h * k1)
        k3 = rate(y + 0.5 * h * k2)
        y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(y + h * k3))
    return y[:2]


@needs_kernel
@pytest.mark.parametrize(
    ("places", "velocity", "spin", "friction"),
    [
        (CORNERS, (1.0, 0.0), 5.0, 0.25),
        full({"a": (0.3, 0.2), "b": (-0.2, 0.3), "c": (-0.4, -0.2), "d": (0.35, -0.25)}, (0.5, 0.7), 3.0, 0.4),
    ],
)
def test_where_the_motion_depends_on_shares_the_error_is_that_of_any_share(places, velocity, spin, friction):
    """It gave no figure. The largest distance is that to one of the two shares that relieve a foot of all its load."""
    duration = 0.2
    recorded, trust = certified(
        box(places, friction, velocity=(*velocity, 0.0), spin=(0.0, 0.0, spin), duration=duration)
    )
    here = recorded["bodies/position"][-1, 0, :2]
    apart = [
        np.linalg.norm(path_of_the_box(places, share, velocity, spin, friction, duration) - here)
        for share in (0.0, 0.3, 0.7, 1.0)
    ]
    assert trust.uncertainty[-1, 0] == pytest.approx(max(apart), rel=1e-3)
    assert max(apart) > 1e-3
    assert "how these share their load, stop 'a'" in trust.remark
    assert trust.untrusted_from(1e-3) is not None
    assert any("lower under one of them" in line for line in lines_on(trust))


@needs_kernel
def test_shares_have_no_say_where_a_box_slides_straight_on():
    _, trust = certified(box(CORNERS, 0.25, velocity=(1, 0, 0), duration=0.1))
    assert trust.solution and trust.untrusted_from(1e-9) is None
    assert "share" not in trust.remark


# Loads that contacts share at will are marked: of feet on a floor, brakes on one shaft, joints between brakes.

BRAKES = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {{duration: 2 s, integrator: dop853, tolerance: 1e-9, output_step: 0.1}}
bodies: {{wheel: {{mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0]}}}}
joints: {{axle: {{type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: [0, 1, 0]}}}}
forces:
  pull: {{type: torsion_spring_damper, joint: axle, torque: "2*t"}}
  {brakes}
expect:
  holds: {{friction: first, quantity: force, at: 0.4 s, above: -10, source: statics}}
"""
BRAKE = "{name}: {{type: friction, joint: axle, coulomb: {{torque: {size}}}}}"
TWO = BRAKES.format(brakes="\n  ".join(BRAKE.format(name=name, size=1) for name in ("first", "second")))
ONE = BRAKES.format(brakes=BRAKE.format(name="first", size=2))
#: A rod between two hinged arms, whose hinges are braked: the rod holds one against the other.
LINKED = """
mbproj: 1
gravity: [0, 0, 0]
simulation: {duration: 0.2 s, integrator: dop853, tolerance: 1e-9, output_step: 0.1, formulation: reduced}
bodies:
  left: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0.5]}
  rod: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [0.5, 0, 1]}
  right: {mass: 1, inertia: [0.1, 0.1, 0.1], position: [1, 0, 0.5]}
joints:
  A: {type: revolute, bodies: [ground, left], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: spherical, bodies: [left, rod], location: [0, 0, 1]}
  C: {type: universal, bodies: [rod, right], location: [1, 0, 1], axes: [[0, 1, 0], [0, 0, 1]]}
  D: {type: revolute, bodies: [ground, right], location: [1, 0, 0], axis: [0, 1, 0]}
forces:
  push: {type: force, body: left, force: [1, 0, 0]}
  first: {type: friction, joint: A, coulomb: {torque: 3}}
  second: {type: friction, joint: D, coulomb: {torque: 3}}
"""
BOX = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: 0.1, integrator: dop853, tolerance: 1e-9, output_step: 0.05}}
bodies: {{box: {{mass: 3, inertia: [0.1, 0.1, 0.1], position: [0.4, 0.3, 0], velocity: {velocity}}}}}
forces:
{feet}
"""
FOOT = (
    "  {name}: {{type: stop, plane: {{body: ground, location: [0, 0, 0], normal: [0, 0, 1]}}, rigid: true, "
    "restitution: 0, point: {{body: box, location: [{x}, {y}, 0]}}{more}}}"
)
FEET = {"a": (0, 0), "b": (0, 1), "c": (1, 0), "d": (1, 1)}


def box_on_feet(names: str, velocity: str = "[0, 0, 0]", more: str = "") -> str:
    feet = "\n".join(FOOT.format(name=name, x=FEET[name][0], y=FEET[name][1], more=more) for name in names)
    return BOX.format(feet=feet, velocity=velocity)


def marked(recorded):
    return {(event.name, event.direction) for event in recorded.of("shared")}


def test_two_brakes_on_a_shaft_share_until_they_slip():
    report, recorded = run(TWO)
    shared = recorded.of("shared")
    assert marked(recorded) == {(f"friction '{name}'", way) for name in ("first", "second") for way in (1, -1)}
    assert {event.time for event in shared if event.direction == 1} == {0.0}
    assert all(event.time == pytest.approx(1.0, abs=1e-6) for event in shared if event.direction == -1)
    assert report.shared == "friction 'first', friction 'second', first at t = 0 s"


def test_one_brake_knows_its_load():
    report, recorded = run(ONE)
    assert not marked(recorded) and report.shared == ""


def test_joints_between_brakes_carry_what_these_share():
    """What the rod carries goes by which brake holds the push."""
    _, recorded = run(LINKED)
    friction = {f"friction '{name}'" for name in ("first", "second")}
    assert {name for name, _ in marked(recorded)} == friction | {f"joint '{name}'" for name in "ABCD"}


def test_four_feet_share_and_three_do_not():
    _, recorded = run(box_on_feet("abcd"))
    assert marked(recorded) == {(f"stop '{name}'", 1) for name in "abcd"}
    _, recorded = run(
        box_on_feet("abd").replace("[0.4, 0.3, 0]", "[0.3, 0.6, 0]").replace("location: [1", "location: [1.2")
    )
    assert not marked(recorded)


def test_feet_that_slide_share_their_friction():
    _, recorded = run(box_on_feet("abcd", "[1, 0, 0]", ", friction: 0.2"))
    rubs = {f"friction '{name}.{tangent}'" for name in "abcd" for tangent in (1, 2)}
    assert {name for name, _ in marked(recorded)} == rubs | {f"stop '{name}'" for name in "abcd"}


def test_what_tells_these_forces_says_so(tmp_path):
    (tmp_path / "brakes.yaml").write_text(TWO, encoding="utf-8")
    done = mbproj("run", "brakes.yaml", "-o", "brakes.h5", folder=tmp_path)
    assert (
        "note: contacts share a load arbitrarily (friction 'first', friction 'second', first at t = 0 s)" in done.stderr
    )
    assert "not unique, joints or contacts can share it in any proportion" in done.stdout
    told = json.loads(mbproj("info", "brakes.h5", "--json", folder=tmp_path).stdout)
    assert told["shared_at_contacts"] == {"friction 'first'": 0.0, "friction 'second'": 0.0}
    assert mbproj("export", "brakes.h5", "-o", "tables", folder=tmp_path).returncode == 0
    heading = (tmp_path / "tables" / "brakes-friction-first.csv").read_text(encoding="utf-8").splitlines()[0]
    assert "force (N m; not unique)" in heading
