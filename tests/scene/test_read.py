"""What a scene's values come to, key by key."""

from __future__ import annotations

import gc
import math
import subprocess
import sys

import pytest

from mbproj.errors import InputError, Place
from mbproj.scene.records import Body, Joint, Marker, Pair, ProjectionSettings, Settings
from tests.scene.scenes import GOOD, changed, read, read_with

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
        "import sys, mbproj.scene.read as r; r.read_scene_text; "
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
