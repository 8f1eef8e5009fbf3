"""What a scene may expect of its stops."""

from __future__ import annotations

import pytest

from mbproj import compile_system, read_scene_text
from mbproj.scene import stop_units
from tests.scene.scenes import errors
from tests.stops.scenes import SCENE as MANY

SCENE = """\
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1 s, step: 1 ms}
bodies:
  arm: {mass: 2 kg, inertia: [1, 1, 1], position: [1, 0, 0]}
joints:
  hinge: {type: revolute, bodies: [ground, arm], location: [0, 0, 0], axis: [0, 0, 1],
    limits: {angle: {range: [null, 90 deg], stiffness: 100}}}
expect:
  hit: {STOP, source: statics}
"""


def expecting(given):
    return SCENE.replace("STOP", given)


def test_stops_have_the_names_and_units_of_the_arrays():
    scene = read_scene_text(MANY)
    names = compile_system(scene).names
    found = stop_units({joint.name: joint for joint in scene.joints}, {force.name: force for force in scene.forces})
    assert found == dict(zip(names.stops, names.stop_units, strict=True))


@pytest.mark.parametrize(
    ("quantity", "number", "value", "unit"),
    [("gap", "45 deg", 0.7853981633974483, "rad"), ("rate", "1 rad/s", 1.0, "rad/s"), ("force", "3 N*m", 3.0, "N*m")],
)
def test_an_expectation_of_a_stop(quantity, number, value, unit):
    """The scene has no forces, and its stop is there all the same."""
    given = f"stop: hinge.angle.high, quantity: {quantity}, at: end, value: {number}, relative: 0.1"
    (found,) = read_scene_text(expecting(given)).expectations
    assert (found.of, found.item, found.quantity, found.unit) == ("stop", "hinge.angle.high", quantity, unit)
    assert found.value == pytest.approx((value,), rel=1e-15)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("stop: hinge.angle.low, quantity: gap", "10:15: error: unknown stop 'hinge.angle.low'; did you mean "
         "'hinge.angle.high'?"),
        ("stop: hinge.angle.high, quantity: position",
         "10:43: error: a stop has no 'position'; it has: gap, rate, force"),
    ],
)  # fmt: skip
def test_an_expectation_of_no_stop(given, message):
    assert errors(expecting(f"{given}, at: end, value: 1, absolute: 1")) == [f"f.yaml:{message}"]


def test_a_force_that_is_a_stop_is_expected_as_a_stop():
    text = expecting("force: rope, quantity: force, at: end, value: 1, absolute: 1").replace(
        "expect:",
        "forces: {rope: {type: stop, points: {ground: [0, 0, 0], arm: [1, 0, 0]}, longest: 2, rigid: true}}\nexpect:",
    )
    (found,) = errors(text)
    assert "force 'rope' is a stop; write  stop: NAME  with the quantity gap, rate or force" in found


def test_units_of_what_is_expected_are_those_of_the_stop():
    (found,) = errors(expecting("stop: hinge.angle.high, quantity: force, at: end, value: 3 N, absolute: 1"))
    assert found == "f.yaml:10:66: error: 'force' is in N*m, this is a force, in N"
