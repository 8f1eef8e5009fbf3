"""What a scene's values and its `expect` block come to, and that a second reading is the first to the bit."""

from __future__ import annotations

import gc
import math
import subprocess
import sys
from dataclasses import fields
from itertools import pairwise

import pytest

from mbproj.base.errors import InputError, Place
from mbproj.base.mechanisms_folder import mechanism, validation_scenes
from mbproj.base.settings import ProjectionSettings, Settings
from mbproj.scene import scene as read_module
from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.blocks.observables import OBSERVABLES
from mbproj.scene.records import Body, Expectation, Joint, Marker, Pair
from mbproj.scene.sampling import nearest_samples, output_times
from mbproj.scene.scene import SceneText, read_scene
from mbproj.scene.text.document import compose
from tests.crossed import where
from tests.scene.scenes import GOOD, changed, errors, read, read_with

X, NOWHERE = (1.0, 0.0, 0.0), (0.2, 0.0, 0.0)
HALF = math.sqrt(0.5)


def diagonal(x: float, y: float, z: float) -> tuple[tuple[float, float, float], ...]:
    return ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))


def test_the_scene_of_the_design() -> None:
    scene = read(GOOD)
    crank, rod, slider = scene.bodies
    assert scene.gravity == (0.0, 0.0, -9.8)
    assert scene.parameters == {"crank_length": 0.08, "rod_length": 0.3}
    assert (crank.name, crank.mass, crank.inertia) == ("crank", 0.12, diagonal(1e-4, 1e-5, 1e-4))
    assert (crank.position, crank.velocity) == ((0.0, 0.1, 0.12), (1.0, 2.0, 3.0))
    assert crank.angular_velocity == (6.0, 0.0, 0.0)
    assert crank.orientation == pytest.approx((HALF, HALF, 0.0, 0.0), abs=2e-16)
    assert rod == Body("rod", 0.5, diagonal(4e-3, 4e-4, 4e-3), (0.1, 0.05, 0.1))
    assert slider == Body("slider", 2.0, diagonal(1e-4, 1e-4, 1e-4), NOWHERE)
    assert scene.markers == (Marker("tip", "slider", NOWHERE),)
    assert scene.settings == Settings(
        duration=10.0,
        step=0.01,
        output_step=0.01,
        integrator="rk4",
        formulation="auto",
        acceleration="bordered",
        projection=ProjectionSettings(method="gpopm"),
    )
    assert (scene.text, scene.path, scene.overrides) == (GOOD, None, {})


def test_the_joints_of_the_design() -> None:
    a, b, c, d = read(GOOD).joints
    first = (0.0, -2 / math.sqrt(5), 1 / math.sqrt(5))
    assert a == Joint(
        "A", "revolute", ("ground", "crank"), Pair((0.0, 0.1, 0.12), (0.0, 0.1, 0.12)), Pair(X, X), {}, {"angle": 6.0}
    )
    assert b == Joint("B", "spherical", ("crank", "rod"), Pair((0.0, 0.1, 0.2), (0.0, 0.1, 0.2)))
    assert (c.bodies, c.points, c.axes and c.axes.second) == (("rod", "slider"), Pair(NOWHERE, NOWHERE), X)
    assert c.axes is not None
    assert c.axes.first == pytest.approx(first, abs=2e-16)
    assert d == Joint("D", "prismatic", ("ground", "slider"), Pair(NOWHERE, NOWHERE), Pair(X, X))


ORIENTATIONS = {
    "{axis: [2, 0, 0], angle: 90 deg}": (HALF, HALF, 0, 0),
    "{quaternion: [2, 2, 0, 0]}": (HALF, HALF, 0, 0),
    "{quaternion: [1e-320, 0, 0, 0]}": (1, 0, 0, 0),
    "{quaternion: [0, 1e308, 0, 1e308]}": (0, HALF, 0, HALF),
    "{matrix: [[1, 0, 0], [0, 0, -1], [0, 1, 0]]}": (HALF, HALF, 0, 0),
    "{euler: [90 deg, 0, 0], sequence: xyz}": (HALF, HALF, 0, 0),
    "{euler: [90 deg, 90 deg, 0], sequence: zxz}": (0.5, 0.5, 0.5, 0.5),
}


@pytest.mark.parametrize("written", ORIENTATIONS)
def test_orientations(written: str) -> None:
    scene = read_with("{axis: [1, 0, 0], angle: 90 deg}", written)
    assert scene.bodies[0].orientation == pytest.approx(ORIENTATIONS[written], abs=2e-16)


INERTIAS = {
    "[1, 2, 3]": diagonal(1.0, 2.0, 3.0),
    "[2, 2, 2, 0.1, 0.2, 0.3]": ((2.0, 0.1, 0.2), (0.1, 2.0, 0.3), (0.2, 0.3, 2.0)),
    "[[2, 0.1, 0.2], [0.1, 2, 0.3], [0.2, 0.3, 2]]": ((2.0, 0.1, 0.2), (0.1, 2.0, 0.3), (0.2, 0.3, 2.0)),
    "[0, 0, 0]": diagonal(0.0, 0.0, 0.0),
    "[1, 1, 0]": diagonal(1.0, 1.0, 0.0),
    "[0.5 kg * (2 m)**2, 2 kg*m^2, 2]": diagonal(2.0, 2.0, 2.0),
}


@pytest.mark.parametrize("written", INERTIAS)
def test_inertias(written: str) -> None:
    assert read_with("[1.0e-4, 1.0e-5, 1.0e-4]", written).bodies[0].inertia == INERTIAS[written]


def test_a_location_by_body_stands_in_the_order_of_the_bodies() -> None:
    joint = read_with(
        "location: [0.2, 0, 0], axis: [1, 0, 0]",
        "location: {slider: [1, 2, 3], ground: [4, 5, 6]}, axis: {slider: [0, 0, 2], ground: [0, 3, 0]}",
    ).joints[3]
    assert joint.points == Pair((4.0, 5.0, 6.0), (1.0, 2.0, 3.0), local=True)
    assert joint.axes == Pair((0.0, 1.0, 0.0), (0.0, 0.0, 1.0), local=True)


def test_axes_by_body_may_be_parallel_as_numbers() -> None:
    local = "location: {rod: [1, 2, 3], slider: [4, 5, 6]}, axes: {slider: [0, 0, 1], rod: [0, 0, 1]}"
    joint = read_with("location: [0.2, 0, 0], axes: [[0, -2, 1], [1, 0, 0]]", local).joints[2]
    assert joint.axes == Pair((0.0, 0.0, 1.0), (0.0, 0.0, 1.0), local=True)


def test_start_values_and_speeds_of_the_coordinates() -> None:
    text = changed("speed: 6 rad/s", "speed: 60 rpm, angle: 180 deg")
    text = changed("axes: [[0,", "speed: {angle_2: 90 deg/s}, angle_1: 1, axes: [[0,", text)
    text = changed("[0.2, 0, 0], axis:", "[0.2, 0, 0], displacement: 5 mm, speed: 2 cm/s, axis:", text)
    a, _, c, d = read(text).joints
    assert (a.start, a.speed) == ({"angle": math.pi}, {"angle": pytest.approx(2 * math.pi, rel=2e-16)})
    assert (c.start, c.speed) == ({"angle_1": 1.0}, {"angle_2": math.pi / 2})
    assert (d.start, d.speed) == ({"displacement": 0.005}, {"displacement": 0.02})


def test_a_marker_in_its_bodys_axes() -> None:
    scene = read_with("{body: slider, location: [0.2, 0, 0]}", "{body: slider, location: {slider: [1, 2, 3]}}")
    assert scene.markers == (Marker("tip", "slider", (1.0, 2.0, 3.0), local=True),)


def test_a_whole_projection_block() -> None:
    scene = read_with(
        "projection: gpopm",
        "projection: {method: mmopm, tolerance: 1e-9, test: paper, every: 2, "
        "threshold: 1e-6, position: true, velocity: false, max_iterations: 7, alpha: 1e8}",
    )
    assert scene.settings.projection == ProjectionSettings("mmopm", 1e-9, "paper", 2, 1e-6, True, False, 7, 1e8, None)


def test_a_minimal_scene_has_the_defaults() -> None:
    scene = read("mbproj: 1\ngravity: [0, 0, 0]\nbodies: {b: {mass: 0, inertia: [0, 0, 0], position: [0, 0, 0]}}\n")
    assert (scene.title, scene.joints, scene.markers, scene.parameters) == ("", (), (), {})
    assert scene.settings == Settings()
    assert scene.bodies[0].orientation == (1.0, 0.0, 0.0, 0.0)


def test_blocks_with_all_their_entries_commented_out_are_empty() -> None:
    text = "mbproj: 1\ngravity: [0, 0, 0]\nbodies: {b: {mass: 0, inertia: [0, 0, 0], position: [0, 0, 0]}}\n"
    scene = read(text + "joints:\n#  A: 5\nmarkers:\nparameters:\nsimulation:\n")
    assert (scene.joints, scene.markers, scene.settings) == ((), (), Settings())


def test_places_of_values_and_of_blocks() -> None:
    scene = read(GOOD)
    assert scene.places["bodies", "crank", "mass"] == Place("f.yaml", 15, 11, "    mass: 0.12")
    assert (str(scene.place("bodies", "crank")), str(scene.place("joints", "A"))) == ("f.yaml:14:3", "f.yaml:24:3")
    assert str(scene.places["joints", "C", "axes", 0, 2]) == "f.yaml:26:85"
    assert str(scene.place("bodies", "crank", "colour")) == "f.yaml:14:3"
    assert str(scene.place("simulation", "projection", "method")) == "f.yaml:12:15"
    assert scene.place("nothing") == scene.places[()]


def test_importing_the_reader_imports_no_arrays() -> None:
    code = (
        "import sys, mbproj.scene.scene as r; r.read_scene_text; "
        "print([m for m in ('numpy', 'h5py', 'scipy', 'matplotlib') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_what_was_read_is_not_searched_for_garbage_again_and_again():
    """It counts as old for Python's search for cycles, which is on or off as it was."""
    bodies = "".join(f"  b{k}: {{mass: 1, inertia: [1, 1, 1], position: [{k}, 0, 0]}}\n" for k in range(500))
    gc.disable()
    try:
        young = len(gc.get_objects(generation=0))
        scene = read(f"mbproj: 1\ngravity: [0, 0, 0]\nbodies:\n{bodies}simulation: {{duration: 1 s, step: 1 ms}}\n")
        assert len(scene.bodies) == 500
        assert len(gc.get_objects(generation=0)) < young + 500
        assert not gc.isenabled()
    finally:
        gc.enable()


@pytest.mark.parametrize(("word", "vector"), [("y", "[0, 1, 0]"), ("-z", "[0, 0, -1]")])
def test_a_direction_along_an_axis_has_a_name(word, vector):
    text = (
        "mbproj: 1\ngravity: [0, 0, 0]\nsimulation: {duration: 1 s, step: 1 ms}\n"
        "bodies: {a: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}}\n"
        "joints: {A: {type: revolute, bodies: [ground, a], location: [0, 0, 0], axis: WORD}}\n"
    )
    assert read(text.replace("WORD", word)).joints == read(text.replace("WORD", vector)).joints
    with pytest.raises(InputError, match="unknown direction 'w'; give 3 numbers, or x, y, z, -x, -y, -z"):
        read(text.replace("WORD", "w"))


# The `expect` block: what is read from it, and which times are sampled.


def expectation(text: str, blocks: str = "", **given: object) -> Expectation:
    (found,) = read(f"{GOOD}{blocks}expect:\n  e: {text}\n", **given).expectations
    return found


def test_a_value_with_units_and_parameters() -> None:
    found = expectation(
        "{marker: tip, quantity: position, at: 3000 ms, value: [2 * crank_length, 1 mm, 0], absolute: 1 mm, source: me}"
    )
    assert found == Expectation(
        "e", "marker", "tip", "position", "m", "", 3.0, "me", value=(0.16, 0.001, 0.0), tolerance=0.001
    )


def test_a_relative_tolerance_is_that_of_the_largest_component() -> None:
    found = expectation("{body: rod, quantity: velocity, at: end, value: [3, -4, 0], relative: 1e-3, source: me}")
    assert found.tolerance == pytest.approx(0.004, rel=1e-15)


def test_a_bound_of_a_diagnostic() -> None:
    found = expectation("{diagnostic: kinetic_energy, at: maximum, below: 3 J, source: me}")
    assert (found.of, found.quantity, found.unit, found.below, found.value) == (
        "diagnostic",
        "kinetic_energy",
        "J",
        3.0,
        None,
    )


SPRING = "forces:\n  k: {type: spring_damper, points: {ground: [0, 0, 0], rod: [0, 0, 1]}, stiffness: 1}\n"
TORSION = "forces:\n  k: {type: torsion_spring_damper, joint: A, stiffness: 1}\n"
FRICTION = "forces:\n  k: {type: friction, joint: D, coefficient: 1}\n"
MOTION = "motions:\n  k: {joint: D, displacement: t}\n"


@pytest.mark.parametrize(
    ("blocks", "of", "units"),
    [
        (SPRING, "force", ("m", "N")),
        (TORSION, "force", ("rad", "N*m")),
        (FRICTION, "force", ("m", "N")),
        (MOTION, "motion", ("m", "N")),
    ],
    ids=["spring", "torsion", "friction", "motion"],
)
def test_units_follow_what_a_force_acts_along(blocks: str, of: str, units: tuple[str, str]) -> None:
    coordinate = "coordinate" if of == "force" else "value"
    for quantity, unit in zip((coordinate, "force"), units, strict=True):
        found = expectation(f"{{{of}: k, quantity: {quantity}, at: end, below: 1 {unit}, source: x}}", blocks)
        assert (found.unit, found.below) == (unit, 1.0)


def test_a_point_force_needs_no_joints() -> None:
    joints = GOOD[GOOD.index("joints:") : GOOD.index("markers:")]
    text = changed(joints, SPRING)
    assert read(f"{text}expect:\n  e: {{force: k, quantity: rate, at: end, below: 1, source: x}}").expectations
    wrong = f"{text}expect:\n  e: {{force: k, quantity: rates, at: end, below: 1, source: x}}"
    assert "unknown quantity 'rates'; did you mean 'rate'?" in errors(wrong)[0]


LATE = "{joint: A, quantity: angle, at: 3 s, value: 0, absolute: 1, source: x}"


def test_the_command_line_may_cut_the_run_short_or_sample_it_otherwise() -> None:
    for options in ({"duration": "1"}, {"output_step": "0.07"}, {"step": "0.004", "output_step": "0.004"}):
        assert expectation(LATE, simulation=options).at == 3.0


def test_a_scene_that_leaves_its_duration_open_may_expect_at_any_time() -> None:
    (found,) = read(changed("  duration: 10\n", "") + f"expect:\n  e: {LATE}\n").expectations
    assert found.at == 3.0


def test_fixed_without_reaction_has_nothing_to_expect() -> None:
    text = changed("{type: spherical, bodies: [crank, rod]", "{type: fixed, bodies: [crank, rod]")
    wrong = f"{text}expect:\n  e: {{joint: B, quantity: reaction_force, component: x, at: end, below: 1, source: x}}\n"
    assert errors(wrong) == [
        "f.yaml:31:14: error: joint 'B' merges its bodies, and nothing of it is recorded; give it reaction: true"
    ]


@pytest.mark.parametrize(
    ("settings", "time", "near"),
    [
        (Settings(duration=10, step=0.01), 0.07, ()),
        (Settings(duration=10, step=0.01, output_step=0.05), 0.07, (0.05, 0.1)),
        (Settings(duration=1, step=0.3), 1.0, ()),  # a shorter last step
        (Settings(duration=1, step=0.3), 0.95, (0.9, 1.0)),
        (Settings(duration=1, step=0.3, output_step=0.6), 0.9, (0.6, 1.0)),
        (Settings(duration=2, tolerance=1e-6), 0.002, ()),
        (Settings(duration=2, tolerance=1e-6), 0.003, (0.002, 0.004)),
        (Settings(duration=1, tolerance=1e-6, output_step=0.4), 0.8, ()),
        (Settings(step=0.1), 0.55, None),
        (Settings(duration=1), 0.55, None),
    ],
)
def test_nearest_samples(settings: Settings, time: float, near: tuple[float, ...] | None) -> None:
    found = nearest_samples(settings, time)
    assert found == (None if near is None else pytest.approx(near, abs=1e-15))


def test_every_output_time_is_a_sample_and_what_lies_between_is_not() -> None:
    settings = Settings(duration=5, tolerance=1e-9, output_step=5 / 299)
    times = output_times(settings, 0.0)
    assert all(nearest_samples(settings, time) == () for time in times)
    between = [0.5 * (a + b) for a, b in pairwise(times)]
    assert all(nearest_samples(settings, time) for time in between)
    assert math.isclose(sum(nearest_samples(settings, between[7]) or ()), times[7] + times[8], rel_tol=1e-14)


def test_coordinates_of_all_joints_are_observable_with_their_speeds() -> None:
    for name, unit in COORDINATES.items():
        assert (OBSERVABLES["joint"][name].unit, OBSERVABLES["joint"][f"{name}_speed"].unit) == (unit, f"{unit}/s")


def test_a_time_is_no_further_mistake_where_the_steps_cannot_be_counted() -> None:
    text = changed("step: 0.01\n  integrator", "step: 1e-40\n  integrator").replace("  output_step: 0.01\n", "")
    text += "expect:\n  e: {diagnostic: energy_drift, at: 3 s, below: 1, source: me}\n"
    (message,) = errors(text)
    assert message.startswith("f.yaml:7:9: error: 'step' of 1e-40 s: 16 digits cannot tell so many steps apart")


# A scene's text is taken apart once: a reading with other values is that of the text with these values, to the bit.

SCENES = [mechanism("five_bar"), mechanism("locomotive"), mechanism("stewart_platform"), *validation_scenes()[:6]]
#: A scene in which a value follows from a parameter by another one, names occur in laws, and a unit depends on a name.
TEXT = """\
mbproj: 1
gravity: [0, 0, -9.81]
parameters: {a: 1 m, b: 2 * a, k: 3, slow: 1}
simulation: {duration: 1, step: 0.01}
bodies:
  bar: {mass: k, inertia: [0.1, 0.1, 0.1], position: [0.5 * b, 0, 0]}
  rod: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 3]}
joints:
  pin: {type: revolute, bodies: [ground, bar], location: [0, 0, 0], axis: [0, 1, 0]}
forces:
  drag: {type: force, body: rod, force: [slow * sin(t), 0, 0]}
"""


def same(one, other):
    """All that the two scenes say; where it says it is known of at least as much."""
    said = {field.name for field in fields(one)} - {"places"}
    assert {name: getattr(one, name) for name in said} == {name: getattr(other, name) for name in said}
    assert one.places.items() >= other.places.items()


@pytest.mark.parametrize(
    "path", where(lambda path: path.stem != "stewart_platform", SCENES), ids=lambda path: path.stem
)
def test_every_parameter_and_mass_changed_in_turn(path):
    text = path.read_text(encoding="utf-8")
    again = SceneText(text, "a")
    plain = again.scene()
    changes = [{name: value * 1.01} for name, value in plain.parameters.items()]
    changes += [{f"bodies.{body.name}.mass": body.mass + 1.0} for body in plain.bodies[:3]]
    for change in [{}, *changes, {}]:
        try:
            expected = SceneText(text, "a").scene(change)
        except InputError as error:
            with pytest.raises(InputError) as raised:
                again.scene(change)
            assert raised.value.problems == error.problems
            continue
        same(again.scene(change), expected)


def test_zeros_of_both_signs_are_two_values():
    text = SceneText(TEXT.replace("position: [0, 0, 3]", "position: [0, 0, 'atan2(slow, -1) / (1 rad)']"), "a")
    places = [text.scene({"slow": zero}).bodies[1].position[2] for zero in (0.0, 0.0, -0.0, 0.0)]
    assert places == [math.pi, math.pi, -math.pi, math.pi]


def test_what_does_not_follow_from_what_changed_is_not_read_again():
    text = SceneText(TEXT, "a")
    first, second, third = text.scene(), text.scene({"a": 1.5}), text.scene({"a": 1.6})
    assert third.bodies[1] is second.bodies[1]
    assert third.joints[0] is second.joints[0]
    assert [scene.bodies[0].position[0] for scene in (first, second, third)] == [1.0, 1.5, 1.6]
    law = text.scene({"slow": 2}).forces
    assert law != third.forces
    assert text.scene({"a": 1.7}).forces[0] is third.forces[0]


def test_a_reading_that_fails_leaves_nothing_behind():
    text = SceneText(TEXT, "a")
    text.scene()
    with pytest.raises(InputError, match=r"unknown name 'x'"):
        text.scene({"a": 4.0, "bodies.rod.mass": "x"})
    for value in (2.0, 3.0):
        same(text.scene({"a": value}), SceneText(TEXT, "a").scene({"a": value}))
    with pytest.raises(InputError, match=r"'mass' must be"):
        text.scene({"k": -1.0})
    same(text.scene({"k": 5.0}), SceneText(TEXT, "a").scene({"k": 5.0}))


def test_a_file_that_is_read_again_is_taken_apart_once_and_anew_when_it_has_changed(tmp_path, monkeypatch):
    composed = []
    monkeypatch.setattr(read_module, "compose", lambda text, name: composed.append(name) or compose(text, name))
    path = tmp_path / "scene.yaml"
    path.write_text(TEXT, encoding="utf-8")
    for value in (1.5, 1.6, 1.7):
        same(read_scene(path, {"a": value}), SceneText(TEXT, str(path), path).scene({"a": value}))
    assert composed == [str(path)] * 4  # one of the file, three of the text
    path.write_text(TEXT.replace("mass: 2", "mass: 5"), encoding="utf-8")
    assert read_scene(path, {"a": 1.5}).bodies[1].mass == 5.0
