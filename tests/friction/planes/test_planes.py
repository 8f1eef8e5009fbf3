"""Friction of points on planes as scenes write it and studies change it."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene_text, settings_to_run, simulate
from mbproj.scene import SceneText, friction_units, to_matrix
from mbproj.scene.fields.rotations import unit
from mbproj.studies import RigidMotion, rescaled, with_speed
from tests.scene.scenes import errors
from tests.stops.runs import Recorded

#: A puck that slides down a slope and comes to rest, and a pad on a disc, which turns beside it.
SCENE = """\
mbproj: 1
gravity: [3, 0, -9]
parameters: {rough: 0.5}
simulation: {duration: 1.5, tolerance: 1e-10, integrator: dop853, output_step: 0.1}
bodies:
  puck: {mass: 2, inertia: [0.1, 0.1, 0.1], position: [0, 0, 0], velocity: [0, 1, 0]}
  disc: {mass: 1, inertia: [1, 1, 1], position: [5, 0, 0]}
joints: {A: {type: revolute, bodies: [ground, disc], location: [5, 0, 0], axis: [0, 0, 1], speed: 2}}
forces:
  floor:
    type: stop
    plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]}
    point: {body: puck, location: {puck: [0, 0, 0]}}
    rigid: true
    friction: {coefficient: rough, static: 1.2 * rough, stribeck_speed: 0.4}
  wall:
    type: stop
    plane: {body: ground, location: [9, 0, 0], normal: [-1, 0, 0]}
    point: {body: puck, location: {puck: [0, 0, 0]}}
    rigid: true
    friction: 0.1
  pad: {type: friction, joint: A, coulomb: {torque: 1}}
markers: {puck: {body: puck, location: {puck: [0, 0, 0]}}}
"""
NAMES = {"pad": "rad", **dict.fromkeys(("floor.1", "floor.2", "wall.1", "wall.2"), "m")}


def ran(scene):
    """What a run of a scene records."""
    system, recorded = compile_system(scene), Recorded()
    simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorded)
    return recorded


@pytest.fixture(scope="module")
def scene():
    return read_scene_text(SCENE)


@pytest.fixture(scope="module")
def known(scene):
    return ran(scene)


def test_names_and_units_are_those_of_the_arrays(scene):
    names = compile_system(scene).names
    assert dict(zip(names.frictions, names.friction_units, strict=True)) == NAMES
    by_name = [{item.name: item for item in items} for items in (scene.joints, scene.forces)]
    assert friction_units(*by_name) == NAMES


def test_expectations_are_of_either_tangent():
    expected = SCENE + "expect: {e: {friction: NAME, quantity: force, at: end, value: 1 N, absolute: 1, source: x}}\n"
    (found,) = read_scene_text(expected.replace("NAME", "floor.2")).expectations
    assert (found.item, found.unit) == ("floor.2", "N")
    (message,) = errors(expected.replace("NAME", "floor"))
    assert message == "f.yaml:24:24: error: unknown dry friction 'floor'; did you mean 'floor.2'?"


def test_a_study_changes_any_value_of_it():
    """By its path, in short and at length, or by a parameter."""
    text = SceneText(SCENE, "f.yaml")

    def static(**changes):
        return compile_system(text.scene(changes)).frictions.static[[1, 3]].tolist()

    assert static() == [0.6, 0.1]
    assert static(rough=1.0) == [1.2, 0.1]
    assert static(**{"forces.floor.friction.static": 0.8, "forces.wall.friction": "rough / 2"}) == [0.8, 0.25]
    units = text.units()
    assert units["forces", "floor", "friction", "stribeck_speed"] == "m/s" and units["forces", "wall", "friction"] == ""


def test_in_another_unit_of_length_it_moves_alike(scene, known):
    k = 7.0
    larger = ran(rescaled(scene, k))
    assert known["friction/state"][0, 2] == 1.0 and (known["friction/state"][-1, 1:3] == 0.0).all()
    np.testing.assert_allclose(larger["bodies/position"], k * known["bodies/position"], atol=k * 1e-9)
    np.testing.assert_allclose(larger["friction/dissipation"], k**2 * known["friction/dissipation"], atol=k**2 * 1e-8)


def test_turned_it_moves_alike(scene, known):
    """Both tangents are then others: what they lose together is the same."""
    turn, by = np.array(to_matrix(unit((0.3, -0.5, 0.2, 0.7)))), np.array([1.0, -2.0, 0.5])
    moved = ran(RigidMotion(turn, by).scene(scene))
    np.testing.assert_allclose(moved["bodies/position"], known["bodies/position"] @ turn.T + by, atol=1e-8)
    lost = [found["friction/dissipation"][:, 1:3].sum(axis=1) for found in (moved, known)]
    np.testing.assert_allclose(*lost, atol=1e-8)
    assert lost[0][-1] > 1.0


def test_a_faster_scene_has_the_same_friction(scene):
    before, after = compile_system(scene).frictions, compile_system(with_speed(scene, 2.0)).frictions
    for name in ("static", "sliding", "stribeck"):
        np.testing.assert_array_equal(getattr(before, name), getattr(after, name))
