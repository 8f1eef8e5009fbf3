"""Dry friction as a scene gives it and as arrays."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mbproj import assemble, compile_system, initial_guess, read_scene_text
from mbproj.functions import constant_series
from mbproj.functions.series import run
from mbproj.model import obstacle_in_plane, planar_reduction
from tests.friction.scenes import EVERY_FRICTION


@pytest.fixture(scope="module")
def system():
    return compile_system(read_scene_text(EVERY_FRICTION, "f.yaml"))


def test_what_can_stick(system):
    """What is regularised is a law; the numbers of coordinates and bearings are the system's."""
    dry, names = system.frictions, system.names
    assert names.frictions == ("bearing", "brake", "sleeve.displacement", "thread", "collar")
    assert names.friction_units == ("rad", "rad", "m", "rad", "rad")
    on = [names.coordinates[at] for at in dry.joint_coordinate]
    assert on == ["A.angle", "A.angle", "C.displacement", "S.angle", "S.angle"]
    np.testing.assert_array_equal(dry.sliding, [0.2, 4, 2, 0.1, 0.3])
    np.testing.assert_array_equal(dry.static, [0.3, 5, 2.5, 0.1, 0.3])
    np.testing.assert_array_equal(dry.stribeck, [0, 0.05, 0, 0, 0])
    np.testing.assert_array_equal(dry.bearing, [0, -1, -1, 2, 3])
    assert dry.owners[1] == "force 'brake'" and dry.owners[2] == "force 'sleeve'"
    lines = EVERY_FRICTION.splitlines()
    begins = ["coulomb:", "coulomb: {torque", "displacement: {", "coulomb: {coefficient", "angle: {coefficient"]
    for place, text in zip(dry.places, begins, strict=True):
        assert lines[place.line - 1][place.column - 1 :].startswith(text)


def test_bearings(system):
    """Arms in m on angles, parts of the force on displacements; a screw's thread is pressed by the axial force."""
    bearings = system.bearings
    assert [system.names.joints[at] for at in bearings.joint] == ["A", "D", "S", "S"]
    np.testing.assert_allclose(bearings.radial, [0.01, 1, 0, 0.006], rtol=1e-15)
    np.testing.assert_allclose(bearings.axial, [0.008, 0, 0.006, 0.009], rtol=1e-15)
    np.testing.assert_array_equal(bearings.length, [0.03, np.inf, np.inf, np.inf])
    np.testing.assert_allclose(bearings.preload, [0.05, 2000, 0.06, 0], rtol=1e-15)
    # The plate sits on the disc, whose axes are global at the start; block and nut have their own.
    np.testing.assert_allclose(bearings.axis, [[0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, 1]], atol=1e-15)


def test_what_is_regularised_is_a_law(system):
    laws = system.forces.laws
    assert system.names.forces == ("guide", "sleeve.angle")
    np.testing.assert_array_equal(laws.damping, [3, 0.5])
    np.testing.assert_array_equal(laws.bearing, [1, -1])
    assert laws.loses.tolist() == [True, True]
    s = np.linspace(-7.0, 7.0, 29)
    at = [constant_series(x) for x in (np.zeros_like(s), np.zeros_like(s), s)]
    guide, sleeve = (run(system.forces.programs, int(program), at)[0] for program in laws.program)
    np.testing.assert_allclose(guide, -0.1 * np.tanh(s / 1e-3), rtol=1e-15)
    np.testing.assert_allclose(sleeve, -(1 + np.exp(-((s / 3) ** 2))) * np.tanh(s / 0.1), rtol=1e-14)


def test_dry_friction_that_sticks_is_no_law():
    scene = read_scene_text(EVERY_FRICTION)
    dry = tuple(force for force in scene.forces if force.name in ("bearing", "brake", "thread"))
    system = compile_system(replace(scene, forces=dry))
    assert system.forces.is_empty and system.names.forces == () and system.frictions.size == 3
    none = compile_system(replace(scene, forces=()))
    assert none.frictions is None and none.bearings is None and none.names.frictions == ()


FOUR_BAR = """\
mbproj: 1
gravity: [0, 0, -9.81]
bodies:
  crank: {mass: 1, inertia: [1, 1, 1], position: [0, 0, 0.5]}
  rod: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 1]}
  rocker: {mass: 1, inertia: [1, 1, 1], position: [2, 0, 0.5]}
joints:
  A: {type: revolute, bodies: [ground, crank], location: [0, 0, 0], axis: [0, 1, 0]}
  B: {type: revolute, bodies: [crank, rod], location: [0, 0, 1], axis: [0, 1, 0]}
  C: {type: cylindrical, bodies: [rod, rocker], location: [2, 0, 1], axis: [0, 1, 0]}
  D: {type: revolute, bodies: [ground, rocker], location: [2, 0, 0], axis: [0, 1, 0]}
forces:
  pin: {type: friction, joint: C, coulomb: {FRICTION}}
"""


def test_friction_across_the_plane_makes_a_mechanism_spatial():
    """The pin cannot slide along its axis, and the planar formulation has no such coordinate."""
    obstacles = []
    for text in ("angle: {torque: 1}", "displacement: {force: 1}"):
        scene = read_scene_text(FOUR_BAR.replace("FRICTION", text))
        system = compile_system(scene)
        plane = planar_reduction(system, assemble(system, initial_guess(scene, system)).q)
        obstacles.append(obstacle_in_plane(system, plane))
    assert obstacles == [None, "force 'pin' acts along a coordinate out of the plane"]
