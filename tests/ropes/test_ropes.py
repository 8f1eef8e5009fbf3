"""Ropes over sheaves: hoists, tackles and Atwood's machines against their closed forms, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import InputError, SimulationError, modes, read_scene_text
from mbproj.joints.primitives.rope import Rope
from tests.kernel.scenes import needs_kernel
from tests.ropes.scenes import ATWOOD, LOAD, G, R, scene, swinging
from tests.stops.runs import run

pytestmark = needs_kernel
#: A drum that winds a rope under a moving block, which carries a load, to a point of the ceiling.
HOIST = """
bodies:
  drum: {mass: 5, inertia: [0.03, 0.03, 0.03], position: [0, 0, 0]}
  block: {mass: 40, inertia: [1, 1, 1], position: [0.1, 0, -2]}
joints:
  axle: {type: revolute, bodies: [ground, drum], location: [0, 0, 0], axis: [0, -1, 0]}
  guide: {type: prismatic, bodies: [ground, block], location: [0.1, 0, -2], axis: [0, 0, 1]}
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {drum: drum, radius: 0.1, bends: right}
      - {sheave: block, radius: 0.1, bends: left, at: [0.2, 0, -2]}
      - {point: ground, at: [0.3, 0, 0]}
"""


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(
    ("formulation", "integrator", "duration", "off"),
    [
        ("planar", "dop853", 1, 3e-12),
        ("reduced", "dop853", 1, 3e-12),
        ("full", "dop853", 0.1, 1e-12),
        ("planar", "radau5", 0.1, 1e-10),
    ],
)
def test_a_swinging_atwood_machine_with_a_wheel(formulation, integrator, duration, off):
    _, recorded = run(
        scene(ATWOOD, formulation, duration, integrator, "1.0e-12" if integrator == "dop853" else "1.0e-11")
    )
    height, bob, _, pull = swinging(recorded["time"])
    position = recorded["bodies/position"]
    np.testing.assert_allclose(position[:, 0, 2], height, atol=off)
    np.testing.assert_allclose(position[:, 2, [0, 2]].T, bob, atol=off)
    tension = np.linalg.norm(recorded["joints/reaction_force"][:, -1], axis=-1)
    np.testing.assert_allclose(tension, pull, atol=1e-9 + 100.0 * off)
    np.testing.assert_allclose(recorded["joints/coordinate"][:, 1], -(height + 1.0) / -R, atol=20.0 * off)


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_a_hoist_with_a_moving_block(formulation):
    """It unwinds a turn and more: m a = m g - 2 T, and the drum turns by 2 a / r."""
    _, recorded = run(scene(HOIST, formulation, 0.5))
    fall = 40.0 * G / (40.0 + 4.0 * 0.03 / R**2)
    t = recorded["time"]
    np.testing.assert_allclose(recorded["bodies/position"][:, 1, 2], -2.0 - 0.5 * fall * t**2, rtol=1e-13, atol=1e-13)
    turned = recorded["joints/coordinate"][:, 0]
    np.testing.assert_allclose(np.abs(turned), fall * t**2 / R, atol=1e-12)
    assert np.abs(turned).max() > 3.0 * np.pi
    tension = np.linalg.norm(recorded["joints/reaction_force"][:, -1], axis=-1)
    np.testing.assert_allclose(tension, 0.5 * 40.0 * (G - fall), rtol=1e-13)


def tackle(n):
    """A load on n strands and a weight on the free end; all strands are upright."""
    fixed, places, x = n % 2 == 0, [], 0.0
    places.append("{point: ground, at: [0, 0, 0]}" if fixed else "{point: load, at: [0, 0, -2]}")
    below = fixed
    for _ in range(n):
        body, z, bends = ("load", -2, "left") if below else ("ground", 0, "right")
        places.append(f"{{sheave: {body}, at: [{x + 0.1:.1f}, 0, {z}], radius: 0.1, bends: {bends}}}")
        below, x = not below, x + 0.2
    places.append(f"{{point: weight, at: [{x:.1f}, 0, -1]}}")
    return f"""
bodies:
  load: {{mass: 30, inertia: [1, 1, 1], position: [0, 0, -2]}}
  weight: {{mass: 7, inertia: [1, 1, 1], position: [{x:.1f}, 0, -1]}}
joints:
  a: {{type: prismatic, bodies: [ground, load], location: [0, 0, -2], axis: [0, 0, 1]}}
  b: {{type: prismatic, bodies: [ground, weight], location: [{x:.1f}, 0, -1], axis: [0, 0, 1]}}
  rope: {{type: rope, normal: [0, -1, 0], path: [{", ".join(places)}]}}
"""


@pytest.mark.parametrize("n", range(2, 9))
def test_a_tackle_of_n_strands(n):
    """n T and T: the load falls by g (M - n m)/(M + n² m), the weight rises n times as far."""
    _, recorded = run(scene(tackle(n), "planar", 0.1))
    fall = G * (30.0 - n * 7.0) / (30.0 + n**2 * 7.0)
    acceleration = recorded["bodies/acceleration"][:, :, 2]
    np.testing.assert_allclose(
        acceleration, np.broadcast_to([-fall, n * fall], acceleration.shape), rtol=1e-13, atol=1e-13
    )


@pytest.mark.parametrize(("restitution", "formulation"), [(0.0, "reduced"), (0.4, "auto")])
def test_a_slack_rope_becomes_taut(restitution, formulation):
    """The load falls by 0.5 m, and rises again by e times its speed, or hangs by its weight."""
    slack = f"    slack: true\n    length: 2.0 m + 0.1*pi\n    restitution: {restitution}\n"
    _, recorded = run(scene(LOAD + slack, formulation, 0.6))
    (taut, *_) = recorded.of("impact", "touch", "contact") or recorded.happened
    assert taut.time == pytest.approx(np.sqrt(1.0 / G), abs=1e-12)
    speed, t = np.sqrt(G), recorded["time"] - taut.time
    after = t > 0.0
    expected = restitution * speed - G * t if restitution else 0.0 * t
    free = after & (t < 2.0 * restitution * speed / G) if restitution else after
    np.testing.assert_allclose(recorded["bodies/velocity"][free, 0, 2], expected[free], atol=1e-11)


def test_an_elastic_rope_pulls_and_does_not_push():
    """The load falls by 0.5 m before the rope of k = 1000 N/m pulls; m g (h + δ) = k δ²/2."""
    _, recorded = run(scene(LOAD + "    stiffness: 1000 N/m\n    length: 2.0 m + 0.1*pi\n"))
    weight = 2.0 * G
    deepest = (weight + np.sqrt(weight**2 + 1000.0 * weight)) / 1000.0
    energy = recorded["diagnostics/total_energy"]
    np.testing.assert_allclose(energy, energy[0], atol=1e-9)
    height = recorded["bodies/position"][:, 0, 2]
    assert height.max() <= -1.0 + 1e-9
    assert height.min() >= -1.5 - deepest - 1e-9
    assert height.min() == pytest.approx(-1.5 - deepest, abs=0.01)


def test_a_force_acts_along_a_free_rope():
    """It lifts the load by the rope over the sheave: a = F/m - g."""
    force = "forces:\n  muscle: {type: linear_spring_damper, joint: rope, coordinate: length, force: -24 N}\n"
    _, recorded = run(scene(LOAD + "    free: true\n" + force, duration=0.1))
    np.testing.assert_allclose(recorded["bodies/acceleration"][:, 0, 2], 12.0 - G, rtol=1e-12)


def test_a_rope_between_points_may_be_normal_to_its_plane():
    """Its length and gradient are those of the straight line, which no plane changes."""
    x = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 0], [0, 0, 2]])
    rope = Rope((0.0, 0.0), (0.0,), (1.0,), (0.0,))
    with np.errstate(all="raise"):
        assert rope.value(x) == [2.0]
        np.testing.assert_array_equal(rope.gradient(x)[0, 2:], [[0, 0, -1], [0, 0, 1]])


def test_a_motion_winds_a_rope():
    motion = "motions:\n  wind: {joint: rope, length: {expression: 1.5 m + 0.1*pi - 0.2*t**2}}\n"
    _, recorded = run(scene(LOAD + motion, duration=0.5))
    np.testing.assert_allclose(recorded["bodies/position"][:, 0, 2], -1.0 + 0.2 * recorded["time"] ** 2, atol=1e-13)
    np.testing.assert_allclose(np.abs(recorded["motions/force"][:, 0]), 2.0 * (G + 0.4), rtol=1e-12)


def test_a_bob_on_a_rope_over_a_sheave_swings():
    """About straight down: ω² = g/l, whatever the sheave, for l changes by r a to first order."""
    bob = LOAD.replace(
        "guide: {type: prismatic, bodies: [ground, load], location: [0.1, 0, -1], axis: [0, 0, 1]}",
        "guide: {type: planar, bodies: [ground, load], location: [0, 0, 0], axis: [0, 1, 0]}",
    )
    found = modes(read_scene_text(scene(bob)))
    assert max(found.frequencies) * 2.0 * np.pi == pytest.approx(np.sqrt(G), rel=1e-9)


@pytest.mark.parametrize("formulation", ["reduced", "full"])
def test_a_rope_that_leaves_its_sheave_ends_the_run(formulation):
    """A load that is thrown up and over takes the rope off the sheave."""
    thrown = """
bodies:
  load: {mass: 2, inertia: [1, 1, 1], position: [0.6, 0, 0.05], velocity: [0, 0, 3]}
joints:
  plane: {type: planar, bodies: [ground, load], location: [0, 0, 0], axis: [0, 1, 0]}
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {point: ground, at: [-1, 0, 0.1]}
      - {sheave: ground, at: [0, 0, 0], radius: 0.1, bends: right}
      - {point: load, at: [0.6, 0, 0.05]}
"""
    with pytest.raises(SimulationError, match=r"rope 'rope': it leaves its place 2: the rope no longer lies on"):
        run(scene(thrown, formulation, 0.5, tolerance="1.0e-8"))


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize(
    ("formulation", "settings"),
    [
        ("planar", "integrator: dop853, tolerance: 1.0e-9"),
        ("planar", "integrator: rk4, step: 1 ms"),
        ("planar", "integrator: radau5, tolerance: 1.0e-7"),
        ("full", "integrator: rk4, step: 10 ms"),
    ],
)
def test_a_bob_that_is_drawn_into_its_wheel_ends_the_run(formulation, settings):
    """By a weight of 9 kg, before 0.15 s have passed; whatever a step meets there."""
    drawn = ATWOOD.replace("left: {mass: 1,", "left: {mass: 9,").replace("0.6*", "0.15*")
    text = scene(drawn, formulation, 0.5).replace("integrator: dop853, tolerance: 1.0e-12", settings)
    with pytest.raises(SimulationError, match="rope 'rope': its part between places 2 and 3 is gone") as caught:
        run(text)
    assert 0.05 < caught.value.time < 0.25


WRONG = {
    "radius: 0.1": ("radius: 0.6", "places 1 and 2 of this path overlap: no rope runs straight between them"),
    "{sheave: ground, at": ("{sheave: ground, turns: 0.5, at", "is not a whole number of turns"),
    "{point: ground, at: [-0.1, 0, -0.5]}": (
        "{sheave: load, at: [0, 0, -0.5], radius: 0.05, bends: left}",
        "a sheave at the end",
    ),
    "type: rope": ("type: rope\n    length: 1 kg", "'length' is in m, this is a mass, in kg"),
    "at: [-0.1, 0, -0.5]": ("at: [-0.1, 0.2, -0.5]", "leans by .* deg out of the plane of its sheaves"),
    "{point: load, at": ("{point: lod, at", "unknown body 'lod'"),
    "type: rope\n": (
        "type: rope\n    length: 0.45 m\n",
        "shorter than its path: 0.45 m, of 0.5 m between places of one",
    ),
    "      - {point: load": (
        "      - {sheave: ground, at: [0.15, 0, 0], radius: 0.1, bends: right}\n      - {point: load",
        "places 2 and 3 of this path overlap",
    ),
    "normal: [0, -1, 0]": (
        "normal: [0, -1, 0]\n    free: true\n    length: 2 m",
        "'free' and 'length' cannot both be given",
    ),
}


@pytest.mark.parametrize("old", WRONG)
def test_what_a_rope_cannot_be(old):
    new, message = WRONG[old]
    with pytest.raises(InputError, match=message):
        read_scene_text(scene(LOAD.replace(old, new)))


#: A rope between two points of the ground, along a sheave of the load.
SAGGING = """
bodies:
  load: {mass: 2, inertia: [1, 1, 1], position: [0, 0, 0]}
joints:
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {point: ground, at: [-1, 0, HEIGHT]}
      - {sheave: load, radius: 0.1, bends: SIDE}
      - {point: ground, at: [1, 0, HEIGHT]}
"""


def test_a_rope_is_on_the_right_side_of_its_sheave():
    above = SAGGING.replace("HEIGHT", "0.11").replace("SIDE", "right")
    with pytest.raises(
        InputError, match=r"would wrap 35.* deg around place 2: it is on the wrong side; write bends: left"
    ):
        read_scene_text(scene(above))


def test_a_rope_is_not_shorter_than_its_path():
    short = SAGGING.replace("HEIGHT", "0.5").replace("SIDE", "left") + "    length: 1.5 m\n"
    with pytest.raises(InputError, match=r"shorter than its path: 1.5 m between ends 2 m apart"):
        read_scene_text(scene(short))
