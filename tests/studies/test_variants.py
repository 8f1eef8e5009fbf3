"""Variants of a scene: what each field's declared quantity does to it, where a turn, a shift or a scale changes it."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

import numpy as np
import pytest

from mbproj import compile_system, initial_guess, read_scene_text
from mbproj.equations.constraints import constraint_at
from mbproj.scene import records
from mbproj.scene.fields.rotations import to_matrix, unit
from mbproj.studies.variants import RigidMotion, quantities, rescaled, with_speed
from tests.support import assembled

TURN = RigidMotion(np.array(to_matrix(unit((0.3, -0.5, 0.2, 0.7)))), np.array([1.0, -2.0, 0.5]))
HEAD = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1, step: 1 ms}
bodies:
  one: {mass: 1, inertia: [0.1, 0.2, 0.2], position: [0.5, 0, 0], start: {position: [0.2, 0, 0.4]}}
  two: {mass: 1, inertia: [0.2, 0.1, 0.2], position: [2, 0, 0.4]}
"""
#: Numbers of records that keep their value in all variants, and vectors whose quantity is that of their holder.
PURE = {
    "Expectation": {"at", "value", "tolerance", "below", "above"},  # what a run gives, not the mechanism
    "Passage": {"value"},
    "StopLaw": {"exponent", "restitution"},
    "PlaneFriction": {"sliding", "static"},
    "PlacedShape": {"orientation"},
    "MeshFile": {"orientation"},
    "Appearance": {"opacity"},
    "Pair": {"first", "second"},
    "Orientations": {"first", "second"},
    "OfBody": {"vector"},
}


def test_each_number_of_a_record_declares_its_quantity():
    """A number without one would be the same in another unit of length, and a vector the same in a turned scene."""
    for name, kind in vars(records).items():
        if not (isinstance(kind, type) and is_dataclass(kind) and kind.__module__ == records.__name__):
            continue
        texts = {each.name: str(each.type) for each in fields(kind)}
        numbers = ("float", "Vector", "Quaternion", "Matrix", "Program", "Any", "OfBody", "Pair", "Orientations")
        able = {field for field, text in texts.items() if any(word in text for word in numbers)}
        assert able - quantities(kind).keys() == PURE.get(name, set()), name


def test_where_assembly_starts_moves_and_grows_with_the_scene():
    scene = read_scene_text(HEAD + "joints: {pin: {type: spherical, bodies: [ground, one], location: [0, 0, 0]}}\n")
    _, known = assembled(scene)
    _, moved = assembled(TURN.scene(scene))
    _, larger = assembled(rescaled(scene, 1000.0))
    position = known.q[:3]
    assert abs(position[2]) > 0.1  # not as the bodies lie in the file
    np.testing.assert_allclose(moved.q[:3], TURN.rotation @ position + TURN.shift, atol=1e-12)
    np.testing.assert_allclose(larger.q[:3], 1000.0 * position, atol=1e-9)


def test_the_axis_of_a_wheel_on_a_plane_turns_with_the_scene():
    wheel = """
forces:
  floor:
    {type: stop, plane: {body: ground, location: [0, 0, -1], normal: [0, 0, 1]},
     point: {body: one, location: [0.5, 0, 0]}, axis: [0, 1, 0], radius: 0.1, rigid: true}
"""
    scene = read_scene_text(HEAD + wheel)
    (before,), (after,) = scene.forces, TURN.scene(scene).forces
    np.testing.assert_allclose(after.axis.vector, TURN.rotation @ before.axis.vector, atol=1e-15)
    by_body = read_scene_text(HEAD + wheel.replace("axis: [0, 1, 0]", "axis: {one: [0, 1, 0]}"))
    assert TURN.scene(by_body).forces[0].axis == by_body.forces[0].axis


COUPLED = """
joints:
  A: {type: revolute, bodies: [ground, one], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: TYPE, bodies: [ground, two], location: [2, 0, 0.4], axis: [0, 1, 0]}
  G: {type: coupler, of: OF, MORE}
"""


def test_teeth_and_pressure_angles_have_no_length():
    text = COUPLED.replace("TYPE", "revolute").replace("OF", "{A: 20, B: 40}").replace("MORE", "pressure_angle: 20 deg")
    scene = read_scene_text(HEAD + text)
    assert rescaled(scene, 1000.0).joints == tuple(rescaled(scene, 1000.0).joints[:2] + scene.joints[2:])


def test_a_coupling_with_a_length_is_a_row_of_lengths():
    """Σ kᵢ sᵢ - f(s₀) of the scaled coordinates is k times that of the scene's, in m and of a function of an angle."""
    text = COUPLED.replace("TYPE", "prismatic").replace("OF", "{A: 0 m, B: 2}").replace("MORE", "function: 3*sin(s)")
    scene = read_scene_text(HEAD + text)
    assert scene.joints[2].couples.unit == "m"
    k, scale = 7.0, np.tile([7.0, 7.0, 7.0, 1.0, 1.0, 1.0, 1.0], 2)
    one, other = compile_system(scene), compile_system(rescaled(scene, k))
    q = initial_guess(scene, one).q + 0.01 * np.random.default_rng(0).normal(size=14)
    rows = [constraint_at(system, each, 0.0)[-1] for system, each in ((one, q), (other, scale * q))]
    assert rows[1] == pytest.approx(k * rows[0], rel=1e-9) and abs(rows[0]) > 1e-3


def test_shapes_are_drawn_in_the_scenes_unit_of_length():
    text = HEAD.replace("inertia: [0.2, 0.1, 0.2], position", "shape: {box: [1, 2, 3]}, position").replace(
        "mass: 1, shape", "density: 10, shape"
    )
    (_, body) = rescaled(read_scene_text(text), 1000.0).bodies
    assert body.shapes[0].sizes == {"a": 1000.0, "b": 2000.0, "c": 3000.0}


@pytest.mark.parametrize("k", [0.25, 3.0])
def test_a_speed_of_friction_is_no_speed_of_the_start(k):
    text = """
joints: {A: {type: revolute, bodies: [ground, one], location: [0, 0, 0], axis: [0, 1, 0], speed: 2}}
forces: {rub: {type: friction, joint: A, coulomb: {torque: 1, static: 2, stribeck_speed: 0.1}}}
"""
    scene = read_scene_text(HEAD + text)
    variant = with_speed(scene, k)
    assert (variant.joints[0].speed, variant.forces) == ({"angle": 2 * k}, scene.forces)
