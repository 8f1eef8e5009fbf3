"""Ropes over sheaves and drums against closed forms: motion, tensions, and what is refused."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pytest
from click.testing import CliRunner

import mbproj
from mbproj import InputError, SimulationError, modes, read_scene_text
from mbproj.base.mechanisms_folder import mechanism
from mbproj.commands.main import mbproj as command
from mbproj.joints.primitives.rope import Rope
from mbproj.results.analysis.contacts import pushed_by_ropes
from mbproj.results.analysis.tables import tables
from mbproj.show.figures import kinds
from tests.kernel.scenes import needs_kernel
from tests.ropes.scenes import ATWOOD, LOAD, UP, G, R, scene, swinging
from tests.stops.runs import run

pytestmark = needs_kernel


# Ropes over sheaves: hoists, tackles and Atwood's machines against their closed forms, and what is refused.

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


#: A drum that draws its load into a pulley on the ground at 2 m after 1.25 s.
WOUND = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 2 s, tolerance: 1e-8, output_step: 10 ms}
bodies:
  drum: {mass: 20, inertia: [0.5, 0.5, 0.5], position: [0, 0, 0]}
  load: {mass: 80, inertia: [1, 1, 1], position: [1.2, 0, 1]}
joints:
  axle: {type: revolute, bodies: [ground, drum], location: [0, 0, 0], axis: y}
  guide: {type: prismatic, bodies: [ground, load], location: [1.2, 0, 1], axis: z}
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {drum: drum, radius: 0.2, bends: right}
      - {sheave: ground, at: [1, 0, 2], radius: 0.2, bends: right}
      - {point: load, at: [1.2, 0, 1]}
motions: {wind: {joint: axle, angle: -0.8*t/0.2}}
"""


@pytest.mark.filterwarnings("error")
def test_a_load_that_is_driven_into_its_sheave_ends_the_run_without_a_word_of_others(capfd):
    """By the rope's name, not the motion's; neither NumPy nor LAPACK has anything to say."""
    with pytest.raises(SimulationError, match="rope 'rope': its part between places 2 and 3 is gone") as caught:
        mbproj.run(read_scene_text(WOUND))
    assert caught.value.time == pytest.approx(1.25, abs=1e-6)
    assert capfd.readouterr() == ("", "")


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


# The tension of each portion of a rope, as a run records it.

LENGTH = "    length: 2.0 m + 0.1*pi\n"


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_the_tensions_on_both_sides_of_a_wheel(formulation):
    """Against the machine's own equations."""
    _, recorded = run(scene(ATWOOD, formulation, 1))
    *_, first, second = swinging(recorded["time"])
    np.testing.assert_allclose(recorded["ropes/tension"].T, [first, second], atol=1e-9)


def test_a_rope_that_becomes_taut_bears_the_load():
    """Nothing while it is slack."""
    _, recorded = run(scene(LOAD + "    slack: true\n" + LENGTH, duration=0.6))
    (taut, *_) = recorded.of("impact", "touch", "contact")
    expected = np.where(recorded["time"] > taut.time, 2.0 * G, 0.0)
    np.testing.assert_allclose(recorded["ropes/tension"][:, 0], expected, atol=1e-9)


def test_an_elastic_rope_bears_what_its_stiffness_says():
    _, recorded = run(scene(LOAD + "    stiffness: 1000 N/m\n" + LENGTH, duration=0.5))
    longer = recorded["joints/coordinate"][:, 1] - 2.0 - 0.1 * np.pi
    np.testing.assert_allclose(recorded["ropes/tension"][:, 0], 1000.0 * np.maximum(longer, 0.0), atol=1e-9)
    assert longer.max() > 0.05


def test_what_winds_a_rope_pulls():
    motion = "motions:\n  wind: {joint: rope, length: {expression: 1.5 m + 0.1*pi - 0.2*t**2}}\n"
    _, recorded = run(scene(LOAD + motion, duration=0.2))
    np.testing.assert_allclose(recorded["ropes/tension"][:, 0], 2.0 * (G + 0.4), rtol=1e-12)


def test_a_file_its_tables_and_its_picture_have_them(tmp_path):
    path = tmp_path / "results.h5"
    results = mbproj.run(mechanism("swinging_atwood"), duration=0.1, output=path)
    with h5py.File(path) as file:
        assert [name.decode() for name in file["ropes/names"]] == ["rope.tension_1", "rope.tension_2"]
        stored = file["ropes/tension"][:]
    with mbproj.open_results(path) as found:
        (table,) = [table for table in tables(found) if table.name == "joint-rope"]
        own = [table.headings.index(f"tension_{number} (N)") for number in (1, 2)]
        np.testing.assert_array_equal(table.read()[:, own], stored)
        figure = kinds.draw("ropes", [found], ["run"])
    labels = [axis.get_ylabel() for axis in figure.axes]
    assert any("tension" in label for label in labels) and any("rope: length" in label for label in labels)
    assert stored.shape == (len(results.time), 2)


def test_a_free_rope_has_none():
    _, recorded = run(scene(LOAD + "    free: true\n", duration=0.02))
    assert "ropes/tension" not in recorded.blocks[0]


@pytest.mark.parametrize(("item", "quantity"), [("rope", "tension_2"), ("guide", "tension_1")])
def test_what_has_no_such_tension_says_so(item, quantity):
    pull = f"{{joint: {item}, quantity: {quantity}, at: end, value: 1 N, relative: 1, source: none}}"
    with pytest.raises(InputError, match=f"has no '{quantity}'"):
        read_scene_text(scene(LOAD + f"expect:\n  pull: {pull}\n"))


@pytest.mark.full_where(formulation="full")
@pytest.mark.parametrize("formulation", ["planar", "reduced", "full"])
def test_a_driven_rope_turns_its_wheel(formulation):
    """J φ'' = r (T2 - T1). A rope that is drawn in at its end lifts the load by s(t)."""
    text = """
bodies:
  load: {mass: 3, inertia: [1, 1, 1], position: [-0.1, 0, -2]}
  wheel: {mass: 2, inertia: [0.02, 0.02, 0.02], position: [0, 0, 0]}
joints:
  guide: {type: prismatic, bodies: [ground, load], location: [-0.1, 0, -2], axis: z}
  axle: {type: revolute, bodies: [ground, wheel], location: [0, 0, 0], axis: y}
  rope:
    type: rope
    normal: [0, -1, 0]
    path:
      - {point: load, at: [-0.1, 0, -2]}
      - {wheel: wheel, radius: 0.1, bends: right}
      - {point: ground, at: [0.1, 0, -1]}
motions:
  draws: {joint: rope, length: {expression: 3 m + 0.1*pi - 0.4*t**2}}
"""
    parts = scene(text, formulation, 0.1 if formulation == "full" else 1)
    _, found = run(
        parts.replace("simulation: {", "simulation: {kinematic: false, ") if formulation == "full" else parts
    )
    t = found["time"]
    np.testing.assert_allclose(found["bodies/position"][:, 0, 2], -2.0 + 0.4 * t**2, atol=1e-12)
    np.testing.assert_allclose(np.abs(found["joints/coordinate"][:, 1]), 4.0 * t**2, atol=1e-11)
    first, second = found["ropes/tension"].T
    np.testing.assert_allclose(first, 3.0 * (G + 0.8), rtol=1e-10)
    np.testing.assert_allclose(second - first, 0.02 * 8.0 / 0.1, rtol=1e-9)
    np.testing.assert_allclose(np.abs(found["motions/force"][:, 0]), second, rtol=1e-12)


def test_a_rope_that_pushes_is_told(tmp_path):
    """A weight of 2 kg that is lifted with 30 N: at π/20 s the rope pushes with what that is more."""
    (tmp_path / "push.yaml").write_text(scene(LOAD + UP, duration=0.3).replace("20 ms", "0.5 ms"))
    done = CliRunner().invoke(command, ["run", str(tmp_path / "push.yaml"), "-o", str(tmp_path / "push.h5"), "--json"])
    pushed = json.loads(done.stdout)["ropes_that_push"]["rope"]
    assert pushed["push"] == pytest.approx(30.0 - 2.0 * G, rel=1e-6)
    assert pushed["time"] == pytest.approx(np.pi / 20.0, abs=5e-4)
    assert "note: rope 'rope' pushes with up to 10.38 N" in done.stderr


def test_a_rope_that_pulls_is_not():
    parsed = read_scene_text(scene(ATWOOD, duration=0.2))
    assert pushed_by_ropes(mbproj.run(parsed), parsed) == {}


# An elastic rope on a drum that turns: slack at first, then taut, as signals write it.

WINCH = """
parameters: {stiffness: 4 kN/m, radius: 0.1 m, slack: 0.05 m}
bodies:
  drum: {mass: 5, inertia: [0.03, 0.03, 0.03], position: [0, 0, 0]}
  load: {mass: 2, inertia: [1, 1, 1], position: [0.1, 0, -1]}
joints:
  axle: {type: revolute, bodies: [ground, drum], location: [0, 0, 0], axis: y}
  guide: {type: prismatic, bodies: [ground, load], location: [0.1, 0, -1], axis: z}
  rope:
    type: rope
    free: true
    normal: [0, -1, 0]
    path: [{drum: ground, at: [0, 0, 0], radius: radius, bends: right}, {point: load, at: [0.1, 0, -1]}]
signals:
  longer: rope.length - radius*axle.angle - (1 m + slack)
  pull: stiffness*max(0, longer)
forces:
  rope: {type: linear_spring_damper, joint: rope, coordinate: length, force: -pull}
  drum: {type: torsion_spring_damper, joint: axle, torque: radius*pull}
"""


@pytest.mark.parametrize("formulation", ["planar", "reduced"])
def test_it_falls_freely_and_then_swings(formulation):
    """x = g t²/2 by the slack, then e = g/ω² (1 - cos) + v/ω sin of the pull k e, ω² = k (1/m + r²/J)."""
    _, found = run(scene(WINCH, formulation, 0.15))
    t, taut = found["time"], np.sqrt(2.0 * 0.05 / G)
    ω, after = np.sqrt(4000.0 * (1.0 / 2.0 + 0.1**2 / 0.03)), np.maximum(t - taut, 0.0)
    longer = G / ω**2 * (1.0 - np.cos(ω * after)) + G * taut / ω * np.sin(ω * after)
    assert longer.min() >= 0.0 and after[-1] * ω > 2.0
    np.testing.assert_allclose(np.abs(found["forces/force"][:, 0]), 4000.0 * longer, atol=1e-6)


#: A drum about y that lifts a load. Its rope lies in the plane normal to NORMAL.
LIFT = """
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  drum: {mass: 6, inertia: [0.1, 0.1, 0.1], position: [0, 0, 3], orientation: {axis: x, angle: 30 deg}}
  load: {mass: 10, inertia: [1, 1, 1], position: [0.1, 0, 1]}
joints:
  axle: {type: revolute, bodies: [ground, drum], location: [0, 0, 3], axis: AXIS}
  guide: {type: prismatic, bodies: [ground, load], location: [0.1, 0, 1], axis: z}
  rope:
    type: rope
    normal: NORMAL
    path:
      - {drum: drum, radius: 0.1, bends: right}
      - {point: load, at: [0.1, 0, 1]}
"""


@pytest.mark.parametrize(
    ("axis", "normal", "off"),
    [("y", "[1, 0, 0]", "90"), ("[0, 1, 0.2]", "[0, 1, 0]", "11.31"), ("y", "[0, 1, 0.1]", "5.711")],
)
def test_a_drum_turns_about_the_normal_of_its_rope(axis, normal, off):
    """It would wind no rope about another axis; a sheave on a body that does not turn is free to lean."""
    wrong = LIFT.replace("AXIS", axis).replace("NORMAL", normal)
    message = rf"scene.yaml:14:16: error: 'drum' turns about the axis of 'axle', which is {off} deg off the normal"
    with pytest.raises(InputError, match=message):
        read_scene_text(wrong, "scene.yaml")
    read_scene_text(LIFT.replace("AXIS", "y").replace("NORMAL", "[0, -1, 0]"), "scene.yaml")
