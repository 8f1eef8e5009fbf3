"""Loops of bodies whose masses leave the factor of S = G M⁻¹ Gᵀ few digits, or none: against decimals of 80 digits."""

from __future__ import annotations

import dataclasses
from decimal import Decimal, localcontext

import numpy as np
import pytest

from mbproj.base.arrays import Array
from mbproj.equations.kinematics import body_rates, pose_of, twist_of
from tests.kernel.scenes import Case, loops, needs_kernel, opened

pytestmark = needs_kernel
DIGITS = 80


def exactly(A: Array, b: Array) -> Array:
    """A⁻¹ b with the numbers as they are, by elimination with row pivots in decimals, rounded at the end."""
    with localcontext() as context:
        context.prec = DIGITS
        rows = [[Decimal(float(x)) for x in (*row, last)] for row, last in zip(A, b, strict=True)]
        for column in range(len(rows)):
            pivot = max(range(column, len(rows)), key=lambda row: abs(rows[row][column]))
            rows[column], rows[pivot] = rows[pivot], rows[column]
            for row in rows[column + 1 :]:
                if row[column]:
                    factor = row[column] / rows[column][column]
                    for entry in range(column, len(row)):
                        row[entry] -= factor * rows[column][entry]
        found = [Decimal(0)] * len(rows)
        for row in reversed(range(len(rows))):
            known = sum((rows[row][k] * found[k] for k in range(row + 1, len(rows))), Decimal(0))
            found[row] = (rows[row][-1] - known) / rows[row][row]
        return np.array([float(x) for x in found])


def uneven(seed: int, ratio: float) -> Case:
    """Five bodies in loops, every second one so many times as heavy as the others."""
    scene = loops(seed)
    bodies = tuple(
        dataclasses.replace(
            body, mass=factor * body.mass, inertia=tuple(tuple(factor * x for x in row) for row in body.inertia)
        )
        for body, factor in zip(scene.bodies, [1.0, ratio] * 3, strict=False)
    )
    return opened(dataclasses.replace(scene, bodies=bodies))


def reference(case: Case) -> tuple[Array, Array]:
    """(r'', ω' global) of each body, (6n,), and λ of [M Gᵀ; G 0] with the kernel's own G and γ."""
    system, pose, equations = case.system, pose_of(case.q), case.reduced.equations()
    A, omega = pose.rotation[:-1], body_rates(pose, twist_of(pose, case.v))[:-1]
    G = equations.jacobian(case.y).reshape(-1, 6 * system.bodies)
    size, rows = G.shape[1], len(G)
    bordered = np.zeros((size + rows, size + rows))
    blocks = bordered[:size, :size].reshape(system.bodies, 6, system.bodies, 6)
    index = np.arange(system.bodies)
    blocks[index, :3, index, :3] = system.mass[:, None, None] * np.eye(3)
    blocks[index, 3:, index, 3:] = A @ system.inertia @ np.swapaxes(A, -1, -2)
    bordered[size:, :size], bordered[:size, size:] = G, G.T
    torque = -np.cross(omega, (system.inertia @ omega[..., None])[..., 0])
    force = np.concatenate([system.mass[:, None] * system.gravity, (A @ torque[..., None])[..., 0]], axis=1)
    found = exactly(bordered, np.concatenate([force.ravel(), equations.gamma(case.y)]))
    return found[:size], found[size:]


def compared(case: Case) -> tuple[Array, Array, Array, Array]:
    """The kernel's accelerations (n, 6), global, and λ, and the reference's."""
    solved = case.reduced.equations().accelerations(case.y)
    assert solved is not None
    acceleration, multipliers = solved
    A = pose_of(case.q).rotation[:-1]
    found = np.concatenate([acceleration[:, :3], (A @ acceleration[:, 3:, None])[..., 0]], axis=1)
    expected, forces = reference(case)
    return found, expected.reshape(-1, 6), multipliers, forces


@pytest.mark.parametrize("ratio", [1e0, 1e4, 1e8, 1e12])
@pytest.mark.parametrize("seed", range(6))
def test_accelerations_and_multipliers_to_ten_digits(seed, ratio):
    """Where heavy bodies bear on each other through light ones, what these are left with is a difference of forces that
    are `ratio` times as large: ε times that, relative to the largest acceleration, is G's own round-off."""
    found, expected, multipliers, forces = compared(uneven(seed, ratio))
    atol = max(1e-10, 1e-17 * ratio) * np.abs(expected).max()
    np.testing.assert_allclose(found, expected, rtol=0, atol=atol)
    np.testing.assert_allclose(multipliers, forces, rtol=0, atol=1e-10 * np.abs(forces).max())


@pytest.mark.parametrize("ratio", [1e16, 1e18, 1e20])
@pytest.mark.parametrize("seed", range(6))
def test_beyond_what_s_has_digits_for_heavy_bodies_and_forces_are_right(seed, ratio):
    """By an orthogonal factorisation of G itself; the rows hold for the light ones too."""
    case = uneven(seed, ratio)
    found, expected, multipliers, forces = compared(case)
    np.testing.assert_allclose(found[1::2], expected[1::2], rtol=0, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(multipliers, forces, rtol=0, atol=1e-12 * np.abs(forces).max())
    equations = case.reduced.equations()
    gamma = equations.gamma(case.y)
    G = equations.jacobian(case.y).reshape(len(gamma), -1)
    np.testing.assert_allclose(G @ found.ravel(), gamma, rtol=0, atol=1e-12 * np.abs(gamma).max())
