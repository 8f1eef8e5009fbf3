"""The direction of a joint's x, which the scene may say: displacements along it, angles from it."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene_text
from mbproj.base.errors import InputError
from mbproj.equations.assembly.assemble import coordinate_values
from mbproj.equations.kinematics import pose_of
from mbproj.studies.variants import RigidMotion

SPEED = "{displacement_x: 2, displacement_y: 0.5}"
X = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
Y = np.array([-1.0, 1.0, 0.0]) / np.sqrt(2.0)


def scene(kind: str, x_axis: str, rest: str = "", axis: str = "[0, 0, 3]"):
    return read_scene_text(
        f"""
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {{duration: 1, step: 0.01}}
bodies: {{puck: {{mass: 1, inertia: [1, 1, 1], position: [0.2, 0.3, 0]}}}}
joints:
  table: {{type: {kind}, bodies: [ground, puck], location: LOCATION, axis: {axis}, x_axis: {x_axis}{rest}}}
""".replace("LOCATION", "{ground: [0, 0, 0], puck: [0, 0, 0]}" if "puck" in x_axis else "[0, 0, 0]")
    )


def started(of):
    system = compile_system(of)
    return system, assemble(system, initial_guess(of, system))


@pytest.mark.parametrize("kind", ["planar", "point_in_plane"])
def test_displacements_are_along_the_direction_given_and_across_it(kind):
    _, state = started(scene(kind, "[2, 2, 7]", f", speed: {SPEED}"))
    velocity = state.v[:3] + np.cross(2.0 * state.v[4:7], [-0.2, -0.3, 0.0])  # Λ = (1, 0, 0, 0): ω is 2 (e₁', e₂', e₃')
    np.testing.assert_allclose(velocity, 2.0 * X + 0.5 * Y, atol=1e-14)


def test_a_scene_that_is_turned_takes_the_direction_along():
    turn = RigidMotion(np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]]), np.array([1.0, 2.0, 3.0]))
    given = scene("planar", "[2, 2, 7]", f", speed: {{{SPEED[1:-1]}, angle: 0}}")
    np.testing.assert_allclose(started(turn.scene(given))[1].v[:3], turn.rotation @ started(given)[1].v[:3], atol=1e-14)


def test_an_angle_is_counted_between_the_directions_of_both_bodies():
    by_body = "{ground: [1, 0, 0], puck: [cos(30 deg), sin(30 deg), 0]}"
    system, state = started(scene("planar", by_body, axis="{ground: [0, 0, 1], puck: [0, 0, 1]}"))
    at = system.names.coordinates.index("table.angle")
    np.testing.assert_allclose(coordinate_values(system, pose_of(state.q))[at], np.radians(30.0), atol=1e-14)


def test_a_direction_along_the_axis_is_none():
    with pytest.raises(InputError, match="'x_axis' is along the axis; give a direction across it"):
        scene("planar", "[0, 0, -1]")
