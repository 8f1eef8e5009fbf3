"""The equations of planar scenes are rows and columns of the full ones."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from mbproj.equations.assembly.assemble import coordinate_values
from mbproj.equations.constraints import constraint, gamma, jacobian
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.of_motion import generalised_force, mass_matrix
from mbproj.model.euler_parameters import matrix_E
from mbproj.model.planar.certain import TILTED, see, sides
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.reduction import PlaneSplit, split
from mbproj.scene.scene import read_scene
from tests.model.planar_scenes import (
    CLOSED_ONLY,
    SCENES,
    Drawing,
    chain,
    planar,
    planar_constraint,
    planar_gamma,
    planar_jacobian,
    planar_value,
)
from tests.support import MECHANISMS


def random_states(plane: Plane, q: np.ndarray, seed: int, count: int):
    """States in the plane near the scene's pose, with joints open by a tenth of their size."""
    rng = np.random.default_rng(seed)
    p, _ = plane.reduce(q, np.zeros_like(q))
    return p + 0.1 * rng.normal(size=(count, len(p))), rng.normal(size=(count, len(p)))


def columns(plane: Plane, p: np.ndarray) -> np.ndarray:
    """∂q/∂p, (7n, 3n)."""
    unit = np.eye(len(p))
    return plane.expand(np.tile(p, (len(p), 1)), unit, np.zeros_like(unit))[1].T


def test_along_a_global_axis_the_plane_has_the_same_numbers():
    scene = read_scene(next(path for path in MECHANISMS if path.stem == "five_bar"))
    system, q, plane = planar(scene)
    assert plane.axes.tolist() == [[0, 1, 0], [0, 0, 1], [1, 0, 0]]
    assert plane.inertia.tolist() == system.inertia[:, 1, 1].tolist()
    assert plane.gravity.tolist() == [-9.8, 0.0]
    assert plane.reduce(q, q)[0].reshape(-1, 3).tolist() == [[0.0, 0.5 + bar, 0.0] for bar in range(5)]
    assert plane.joints.kinds == ("coincident",) * 5
    assert (plane.joints.local[:2, 1].tolist(), plane.joints.row.tolist()) == ([0.0, -0.5], [0, 2, 4, 6, 8])
    assert set(plane.joints.source.weight) == {1.0}


def test_coordinates_that_the_plane_locks_are_constant():
    scene = read_scene(next(path for path in MECHANISMS if path.stem == "planar_four_bar"))
    system, _, plane = planar(scene)
    assert [system.names.coordinates[index] for index in plane.constant] == ["C.angle_1"]
    system, _, plane = planar(SCENES["cylinder on a plane"](Drawing(1)))
    assert [system.names.coordinates[index] for index in plane.constant] == ["A.displacement", "C.displacement"]


def test_a_turn_back_is_a_turn_forth():
    """θ is in (-2π, 2π] to the last bit."""
    _, q, plane = planar(read_scene(next(path for path in MECHANISMS if path.stem == "five_bar")))
    back = q.reshape(-1, 7).copy()
    for zero in (0.0, -0.0):
        back[:, 3:] = [-1.0, 0.0, zero, 0.0]  # by ±2π about the y axis
        assert set(plane.reduce(back.ravel(), q)[0].reshape(-1, 3)[:, 2]) == {2.0 * np.pi}


@pytest.mark.parametrize("name", SCENES)
def test_reduce_and_expand_are_inverse(name):
    _, q, plane = planar(SCENES[name](Drawing(1)))
    rng = np.random.default_rng(2)
    p = 2.0 * rng.normal(size=(40, len(plane.mass), 3))
    p[..., 2] = 2.0 * np.pi * (1.0 - 2.0 * rng.uniform(size=p.shape[:2]))  # (-2π, 2π]
    p[0, :, 2] = np.pi
    u, u_dot = rng.normal(size=(2, 40, 3 * len(plane.mass)))
    p = p.reshape(40, -1)
    at, v, acceleration = plane.expand(p, u, u_dot)
    for sign in (1.0, -1.0):  # the other sign of Λ is a turn more or less
        signed = np.tile([1.0, 1, 1, sign, sign, sign, sign], len(plane.mass))
        back, rate = plane.reduce(signed * at, signed * v)
        np.testing.assert_allclose(np.exp(1j * back), np.exp(1j * p), rtol=0, atol=1e-14)
        assert np.all(np.abs(back.reshape(40, -1, 3)[..., 2]) <= 2.0 * np.pi)
        np.testing.assert_allclose(rate, u, rtol=0, atol=1e-14)
        again = plane.expand(back, rate, u_dot)
        np.testing.assert_allclose(again[0], signed * at, rtol=0, atol=1e-14)
    np.testing.assert_allclose(plane.expand(*plane.reduce(q, 0 * q), 0 * u[0])[0], q, rtol=0, atol=1e-14)
    # What determines Λ' and Λ'': the angular velocity and acceleration, and |Λ| = 1.
    Λ, rate, change = (part.reshape(40, -1, 7)[..., 3:] for part in (at, v, acceleration))
    for first, turning in ((rate, u), (change, u_dot)):
        along_normal = turning.reshape(40, -1, 3)[..., 2:] * plane.axes[:, 2]
        np.testing.assert_allclose((2.0 * matrix_E(Λ) @ first[..., None])[..., 0], along_normal, rtol=0, atol=1e-13)
    assert np.abs(np.sum(Λ * rate, axis=-1)).max() < 1e-14
    assert np.abs(np.sum(Λ * change + rate * rate, axis=-1)).max() < 1e-13
    depth = at.reshape(40, -1, 7)[..., :3] @ plane.axes[:, 2]
    np.testing.assert_allclose(depth, np.tile(plane.depth, (40, 1)), rtol=0, atol=1e-14)


def test_a_state_that_has_overflowed_is_expanded_without_a_word():
    """As a step that is far too large leaves it: who records it sees that it is no number."""
    _, _, plane = planar(SCENES["four-bar"](Drawing(1)))
    lost = np.full(3 * len(plane.mass), 1e200)
    with np.errstate(all="raise"):
        *_, acceleration = plane.expand(np.zeros_like(lost), lost, lost)
    assert not np.isfinite(acceleration).all()


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("seed", [1, 2])
def test_the_plane_selects_rows_and_columns(name, seed):
    """C, C_p, γ and the coordinates are those of the full equations, at any state in the plane, joints open or not."""
    system, q, plane = planar(SCENES[name](Drawing(seed)))
    n, source = system.bodies, plane.joints.source
    p, u = random_states(plane, q, seed, 4)
    at, v, bias = plane.expand(p, u, np.zeros_like(u))
    pose = pose_of(at)
    full_gamma = gamma(system, pose, twist_of(pose, v))[:, n:]
    np.testing.assert_allclose(planar_constraint(plane, p), source.rows(constraint(system, pose)[:, n:]), atol=1e-13)
    changing = plane.coordinates.source.source
    coordinates = coordinate_values(system, pose)
    np.testing.assert_allclose(planar_value(plane.coordinates, p), coordinates[:, changing], atol=1e-13)
    assert sorted([*changing, *plane.constant]) == list(range(system.coordinates.size))
    for sample in range(len(p)):
        C_q = jacobian(system, pose_of(at[sample]))[n:]
        C_p = planar_jacobian(plane, p[sample])
        np.testing.assert_allclose(C_p, source.rows((C_q @ columns(plane, p[sample])).T).T, atol=1e-13)
        expected = source.rows(full_gamma[sample] - C_q @ bias[sample])
        np.testing.assert_allclose(planar_gamma(plane, p[sample], u[sample]), expected, atol=1e-12)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("seed", [1, 2])
def test_accelerations_and_multipliers_are_those_of_the_full_equations(name, seed):
    """With open joints too; prismatic and fixed joints across the plane's axes are equivalent where they are closed."""
    system, q, plane = planar(SCENES[name](Drawing(seed)))
    p, u = random_states(plane, q, seed, 1)
    p, u = p[0], u[0]
    if name in CLOSED_ONLY:
        p = plane.reduce(q, q)[0]
        u = u - np.linalg.pinv(planar_jacobian(plane, p)) @ planar_jacobian(plane, p) @ u
    M = np.repeat(plane.mass, 3)
    M[2::3] = plane.inertia
    Q = (plane.mass[:, None] * np.append(plane.gravity, 0.0)).ravel()
    C_p = planar_jacobian(plane, p)
    u_dot, multipliers, condition = bordered(np.diag(M), C_p, Q, planar_gamma(plane, p, u))
    at, v, expected = plane.expand(p, u, u_dot)
    pose = pose_of(at)
    twist = twist_of(pose, v)
    C_q, force = jacobian(system, pose), generalised_force(system, pose, twist)
    q_ddot, full, full_condition = bordered(mass_matrix(system, pose), C_q, force, gamma(system, pose, twist))
    tolerance = 1e-11 * max(condition, full_condition)
    np.testing.assert_allclose(expected, q_ddot, rtol=0, atol=tolerance)
    # In the plane the joints' forces are those of the plane's own multipliers.
    in_plane = (C_q[system.bodies :] @ columns(plane, p)).T
    own = plane.joints.source.multipliers(multipliers, system.joints.size)
    np.testing.assert_allclose(in_plane @ full[system.bodies :], in_plane @ own, rtol=0, atol=tolerance)


def bordered(M, C_q, Q, gamma):
    """Eq. 14 where rows may be redundant: q'', one λ, and the condition of what determines q''."""
    matrix = np.block([[M, C_q.T], [C_q, np.zeros((len(C_q), len(C_q)))]])
    solution, _, _, values = np.linalg.lstsq(matrix, np.concatenate([Q, gamma]), rcond=1e-11)
    return solution[: len(M)], solution[len(M) :], values[0] / values[values > 1e-11 * values[0]][-1]


def test_rows_across_the_plane_combine_to_rows_outside():
    """Two slides whose vectors stand at any angle to the plane: of five rows of each joint two are inside, and of the
    other three combinations have no gradient in the plane."""
    system, q, plane = planar(SCENES["table"](Drawing(1)))
    rotation = pose_of(q).rotation
    seen = see(system.joints, pose_of(q).position, rotation, plane.axes, system.length)
    side = sides(system.joints, seen)
    assert np.count_nonzero(side == TILTED) == 10
    parts = split(system.joints, seen, side)
    assert isinstance(parts, PlaneSplit)
    assert (parts.inside.sum(), parts.outside.size) == (4, 6)
    in_plane = jacobian(system, pose_of(q))[system.bodies :] @ columns(plane, plane.reduce(q, q)[0])
    assert np.abs(parts.outside.rows(in_plane.T)).max() < 1e-14
    assert np.abs(in_plane[~parts.inside]).max() > 0.1


def test_gears_bring_their_teeth():
    _, _, plane = planar(SCENES["gears"](Drawing(1)))
    assert plane.joints.kinds == ("coincident", "coincident", "coincident", "coupling")
    assert plane.joints.primitives[-1].weights == (20.0 / 35.0, -1.0)
    assert plane.joints.row.tolist() == [0, 2, 4, 6]
    assert plane.joints.first_slot.tolist() == [0, 2, 4, 6]


def test_the_pose_is_not_asked_for_symmetry_of_inertia_or_gravity():
    """Products of inertia and gravity out of the plane load the joints only."""
    scene = chain(Drawing(7), ["revolute", "revolute"])
    _, _, plane = planar(dataclasses.replace(scene, gravity=(3.0, 4.0, 5.0)))
    full = np.append(plane.gravity, plane.axes[:, 2] @ [3.0, 4.0, 5.0])
    np.testing.assert_allclose(plane.axes @ full, [3.0, 4.0, 5.0], rtol=1e-14)
