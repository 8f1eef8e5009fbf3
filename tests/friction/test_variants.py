"""What a change of the scene, of its unit of length or of its order does to dry friction."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbproj import InputError, compile_system, read_scene_text
from mbproj.functions import constant_series
from mbproj.functions.series import run
from mbproj.scene import SceneText, to_matrix
from mbproj.scene.fields.rotations import unit
from mbproj.studies import RigidMotion, renumbered, rescaled, with_damping
from tests.friction.scenes import EVERY_FRICTION


def carried(bearings, force, torque):
    """The loads of bearings whose joints exert a force and a torque (3,) in the axes of body 2."""
    z = bearings.axis
    axial = z @ force
    bent = np.cross(torque, z) / bearings.length[:, None]
    ends = [np.linalg.norm(0.5 * (force - axial[:, None] * z) + sign * bent, axis=1) for sign in (1, -1)]
    return bearings.preload + bearings.radial * sum(ends) + bearings.axial * np.abs(axial)


def held(system, force, torque):
    """The largest force or torque that each friction holds."""
    dry, load = system.frictions, carried(system.bearings, force, torque)
    return dry.static * np.where(dry.bearing < 0, 1.0, load[dry.bearing])


def slid(system, s):
    """What the regularised frictions give at these rates, without the load of a bearing."""
    programs, at = system.forces.programs, [constant_series(x) for x in (0.0 * s, 0.0 * s, s)]
    return [run(programs, int(program), at)[0] for program in system.forces.laws.program]


def test_a_scene_in_another_unit_of_length_has_the_same_friction():
    """Forces are k times, torques k² times as large where the joints bear so much more, at k times the speed in m/s."""
    scene, k = read_scene_text(EVERY_FRICTION), 7.0
    system, larger = compile_system(scene), compile_system(rescaled(scene, k))
    force, torque = np.array([3.0, -4.0, 5.0]), np.array([0.2, 0.3, -0.1])
    of = np.where(np.array(system.names.friction_units) == "m", k, k**2)
    ratio = held(larger, k * force, k**2 * torque) / held(system, force, torque)
    np.testing.assert_allclose(ratio, of, rtol=1e-12)
    np.testing.assert_array_equal(larger.frictions.stribeck, system.frictions.stribeck)  # all of them in rad/s
    s = np.linspace(-0.01, 0.01, 7)
    np.testing.assert_allclose(slid(larger, s)[1], k**2 * slid(system, s)[1], rtol=1e-12)
    np.testing.assert_allclose(slid(larger, k * s)[0], slid(system, s)[0], rtol=1e-12)  # a coefficient of the load


def test_a_scene_moved_or_numbered_otherwise_has_the_same_friction():
    scene = read_scene_text(EVERY_FRICTION)
    system = compile_system(scene)
    turn = np.array(to_matrix(unit((0.3, -0.5, 0.2, 0.7))))
    moved = compile_system(RigidMotion(turn, np.array([1.0, -2.0, 0.5])).scene(scene))
    np.testing.assert_allclose(moved.bearings.axis, system.bearings.axis, atol=1e-12)
    other = compile_system(renumbered(scene, seed=2))
    assert other.names.frictions != system.names.frictions
    at = [system.names.frictions.index(name) for name in other.names.frictions]
    for name in ("sliding", "static", "stribeck"):
        np.testing.assert_array_equal(getattr(other.frictions, name), getattr(system.frictions, name)[at])
    force, torque = np.array([3.0, -4.0, 5.0]), np.array([0.2, 0.3, -0.1])
    np.testing.assert_allclose(held(other, force, torque), held(system, force, torque)[at], rtol=1e-14)


def test_a_study_changes_any_value_of_it():
    """By its path or by a parameter that it names, from the text that was read once; wrong ones have their place."""
    text = SceneText(EVERY_FRICTION, "f.yaml")

    def dry(**changes):
        frictions = compile_system(text.scene(changes)).frictions
        return frictions.sliding[1], frictions.static[1], frictions.stribeck[1]

    assert dry() == (4.0, 5.0, 0.05)
    assert dry(grip="4500 N*mm") == (4.5, 5.0, 0.05)
    assert dry(**{"forces.brake.coulomb.torque": 3.0}) == (3.0, 5.0, 0.05)
    assert dry(**{"forces.brake.coulomb.static": "2 * grip", "grip": 2.5}) == (2.5, 5.0, 0.05)
    assert dry(**{"forces.brake.coulomb.stribeck_speed": "1 rpm"})[2] == pytest.approx(np.pi / 30)
    assert dry() == (4.0, 5.0, 0.05)
    with pytest.raises(InputError, match=r"'static' must be at least the 'torque', 6 N\*m, found 5"):
        dry(grip=6.0)
    units = text.units()
    wanted = {"torque": "N*m", "static": "N*m", "stribeck_speed": "rad/s"}
    assert {key: units["forces", "brake", "coulomb", key] for key in wanted} == wanted
    assert (
        units["forces", "bearing", "coulomb", "static"] == "" and units["forces", "guide", "coulomb", "preload"] == "N"
    )


def test_a_study_of_damping_leaves_dry_friction_as_it_is():
    scene = read_scene_text(EVERY_FRICTION)
    before, after = compile_system(scene), compile_system(with_damping(scene, 3.0))
    np.testing.assert_array_equal(after.forces.laws.damping, 3.0 * before.forces.laws.damping)
    np.testing.assert_array_equal(after.frictions.static, before.frictions.static)


PIN = """\
mbproj: 1
gravity: [0, 0, -9.81]
bodies: {rod: {mass: 1, inertia: [1, 1, 1], position: [1, 0, 0]}}
joints: {A: {type: revolute, bodies: [ground, rod], location: [0, 0, 0], axis: [0, 1, 0]}}
forces: {k: {type: friction, joint: A, coulomb: {"""
SIZES = st.floats(0.0, 1e6)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(SIZES, SIZES, st.floats(1e-6, 1e3), st.floats(1e-6, 1e3))
def test_regularised_friction_never_drives_nor_passes_its_bounds(sliding, static, speed, width):
    """At any rate it takes energy, is not more than what holds, and tends to what slides; where less holds than slides
    the reader says so, and where as much does that there is nothing from which friction could fall."""
    text = f"{PIN}torque: {sliding!r}, static: {static!r}, stribeck_speed: {speed!r}, regularised: {width!r}}}}}}}\n"
    if static <= sliding:
        with pytest.raises(InputError, match=r"'static' must be at least|'stribeck_speed' does nothing"):
            read_scene_text(text)
        return
    s = np.concatenate([[0.0], *(np.outer([1e-3, 0.1, 1.0, 40.0], [-of, of]).ravel() for of in (speed, width))])
    (found,) = slid(compile_system(read_scene_text(text)), s)
    assert (found * s <= 0.0).all() and found[0] == 0.0
    assert np.abs(found).max() <= static * (1.0 + 1e-15)
    far = 40.0 * max(speed, width) * np.array([-1.0, 1.0])
    (last,) = slid(compile_system(read_scene_text(text)), far)
    np.testing.assert_allclose(last, -np.sign(far) * sliding, rtol=1e-14)
