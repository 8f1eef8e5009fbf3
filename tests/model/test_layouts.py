"""What sets of primitives share: scenes that differ in numbers alone have one layout, which nobody can write to."""

import numpy as np
import pytest

from mbproj import read_scene_text
from mbproj.base.arrays import Array, cross
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.energy import kinetic_energy, potential_energy
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.model.compile.mechanism import initial_guess
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.reduction import planar_reduction
from mbproj.model.system import System

PENDULUMS = """
mbproj: 1
gravity: [0, 0, -9.8]
parameters: {length: 1 m, teeth: 20}
simulation: {duration: 1 s, step: 0.01 s}
bodies:
  upper: {mass: 1 kg, inertia: [0.1, 0.2, 0.3], position: [length / 2, 0, 0]}
  lower: {mass: 2 kg, inertia: [0.1, 0.2, 0.3], position: [1.5 * length, 0, 0]}
joints:
  hip: {type: revolute, bodies: [ground, upper], location: [0, 0, 0], axis: [1, 2, 2]}
  knee: {type: revolute, bodies: [upper, lower], location: [length, 0, 0], axis: [1, 2, 2]}
"""
GEAR = "  mesh: {type: gear, joints: [hip, knee], teeth: [teeth, 30]}\n"


def compiled(text: str = PENDULUMS, **parameters: float) -> System:
    return compile_system(read_scene_text(text, parameters=parameters))


def test_scenes_that_differ_in_numbers_share_their_layout() -> None:
    short, long = compiled(), compiled(length=3.0)
    assert short.joints.layout is long.joints.layout and short.coordinates.layout is long.coordinates.layout
    assert np.abs(long.joints.local - short.joints.local).max() > 0.9
    with pytest.raises(ValueError, match="read-only"):
        short.joints.body[0] = 1


def test_numbers_of_a_primitive_are_of_its_layout() -> None:
    text = PENDULUMS + GEAR
    coarse, fine, again = compiled(text), compiled(text, teeth=40), compiled(text)
    assert coarse.joints.layout is again.joints.layout is not fine.joints.layout
    assert coarse.couplings.weight.tolist() != fine.couplings.weight.tolist()


def samples(count: int) -> tuple[System, Plane, Array, Array, Array]:
    """Random motions of the pendulums in their plane, which stands at an angle."""
    system = compiled()
    plane = planar_reduction(system, initial_guess(read_scene_text(PENDULUMS), system).q)
    assert isinstance(plane, Plane)
    p, u, change = np.random.default_rng(1).normal(size=(3, count, 6))
    return system, plane, p, u, change


def test_samples_are_the_same_in_blocks_of_any_length() -> None:
    system, plane, p, u, change = samples(101)
    whole = plane.expand(p, u, change)
    energies = (
        kinetic_energy(system, pose := pose_of(whole[0]), twist_of(pose, whole[1])),
        potential_energy(system, pose),
    )
    for block in (slice(0, 1), slice(1, 4), slice(4, 101)):
        parts = plane.expand(p[block], u[block], change[block])
        assert all(np.array_equal(part, all_of_it[block]) for part, all_of_it in zip(parts, whole, strict=True))
        pose = pose_of(parts[0])
        assert np.array_equal(kinetic_energy(system, pose, twist_of(pose, parts[1])), energies[0][block])
        assert np.array_equal(potential_energy(system, pose), energies[1][block])


def test_what_is_expanded_is_reduced_again() -> None:
    _, plane, p, u, change = samples(50)
    p[:, 2::3] = np.remainder(p[:, 2::3], 4.0 * np.pi) - 2.0 * np.pi
    q, v, _ = plane.expand(p, u, change)
    back, rate = plane.reduce(q * np.tile([1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0], 2), v)
    assert np.abs(back - p).max() < 1e-14
    assert np.abs(plane.reduce(q, v)[1] - u).max() < 4e-15 * np.abs(u).max()
    assert rate.shape == u.shape


def test_products_of_vectors_are_those_of_numpy() -> None:
    a, b = np.random.default_rng(2).normal(size=(2, 4, 5, 3))
    assert np.abs(cross(a, b[0]) - np.cross(a, b[0])).max() == 0.0
    assert cross(a[0, 0], 1j * b[0, 0]).dtype == complex
