"""Rotations and inertias, against each other and NumPy."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest

from mbproj.scene.fields.quantities import inertia_of
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.fields.rotations import (
    SEQUENCES,
    determinant,
    from_axis_angle,
    from_elements,
    from_euler,
    from_matrix,
    from_principal,
    multiply,
    orthonormality_error,
    principal_moments,
    unit,
)
from mbproj.scene.records import Matrix, Quaternion

RNG = np.random.default_rng(20150101)


def about(letter: str, angle: float) -> np.ndarray:
    """The rotation matrix about a coordinate axis."""
    i = "xyz".index(letter)
    j, k = (i + 1) % 3, (i + 2) % 3
    matrix = np.eye(3)
    matrix[j, j] = matrix[k, k] = math.cos(angle)
    matrix[k, j], matrix[j, k] = math.sin(angle), -math.sin(angle)
    return matrix


def matrix_of(q: Quaternion) -> np.ndarray:
    """R v = q v q*, column by column."""
    conjugate = (q[0], -q[1], -q[2], -q[3])
    axes: list[Quaternion] = [(0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0)]
    return np.array([multiply(multiply(q, axis), conjugate)[1:] for axis in axes]).T


def rows(matrix: np.ndarray) -> Matrix:
    (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
    return ((a, b, c), (d, e, f), (g, h, i))


def same_up_to_sign(p: Quaternion, q: Quaternion) -> float:
    return min(np.abs(np.subtract(p, q)).max(), np.abs(np.add(p, q)).max())


def test_the_sequences_are_the_twelve() -> None:
    assert len(SEQUENCES) == len(set(SEQUENCES)) == 12


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_angles_turn_about_the_bodys_axes_in_turn(sequence: str) -> None:
    for angles in RNG.uniform(-7, 7, (20, 3)).tolist():
        expected = about(sequence[0], angles[0]) @ about(sequence[1], angles[1]) @ about(sequence[2], angles[2])
        assert matrix_of(from_euler(tuple(angles), sequence)) == pytest.approx(expected, abs=2e-15)


def test_the_quaternion_of_the_matrix_of_a_quaternion() -> None:
    random = RNG.normal(size=(200, 4)).tolist()
    special = [q for q in product((-1.0, 0.0, 1e-9, 1.0), repeat=4) if any(q)]
    for given in random + special:
        q = unit(given)
        assert q is not None
        found = from_matrix(rows(matrix_of(q)))
        assert same_up_to_sign(found, q) < 1e-15
        assert math.hypot(*found) == pytest.approx(1.0, abs=3e-16)
        assert found[0] >= 0


def test_axis_and_angle_are_a_rotation_about_a_coordinate_axis() -> None:
    for letter, axis in zip("xyz", np.eye(3).tolist(), strict=True):
        for angle in (-4.0, 0.0, 0.3, math.pi):
            assert matrix_of(from_axis_angle(tuple(axis), angle)) == pytest.approx(about(letter, angle), abs=1e-15)


def test_orthonormality_and_determinant() -> None:
    for q in RNG.normal(size=(20, 4)).tolist():
        matrix = matrix_of(unit(q))
        assert orthonormality_error(rows(matrix)) < 3e-15
        assert determinant(rows(matrix)) == pytest.approx(1.0, abs=3e-15)
    assert orthonormality_error(((1.0, 0.0, 0.0), (0.0, 1.0, 0.25), (0.0, 0.0, 1.0))) == 0.25
    assert determinant(((2.0, 1.0, 0.0), (0.0, 3.0, 0.0), (5.0, 0.0, -1.0))) == -6.0


@pytest.mark.parametrize("scale", [1.0, 1e-320, 5e-324, 1e307])
def test_unit_vectors_of_any_size(scale: float) -> None:
    assert unit((scale, 0.0, -scale)) == pytest.approx((math.sqrt(0.5), 0.0, -math.sqrt(0.5)), abs=2e-16)
    assert unit((0.0, 0.0, 0.0)) is None


@pytest.mark.parametrize("scale", [1.0, 1e-9, 1e200, 1e-200])
def test_principal_moments_as_numpys_eigenvalues(scale: float) -> None:
    for elements in RNG.normal(size=(100, 6)).tolist():
        matrix = from_elements([scale * x for x in elements])
        largest = np.abs(matrix).max()
        assert np.array(principal_moments(matrix)) / largest == pytest.approx(
            np.linalg.eigvalsh(np.array(matrix) / largest), abs=4e-15
        )


def test_equal_moments_about_a_diagonal_are_found_at_once() -> None:
    """A rod along (1, 1, 1), as a model has it: rotations once turned what round-off left, without an end."""
    a, b = 0.009318672582184233, 0.004348555749923228
    matrix = from_elements([a, a + 7e-18, a + 5e-18, b, -b - 3e-18, b + 2e-18])
    assert principal_moments(matrix) == pytest.approx([a - 2 * b, a + b, a + b], abs=1e-16)


def turned(moments: tuple[float, float, float]) -> Matrix:
    """The tensor with these principal moments in axes turned at random."""
    R = matrix_of(unit(RNG.normal(size=4).tolist()))
    return rows(R @ np.diag(moments) @ R.T)


@pytest.mark.parametrize("excess", [0.0, 1e-13, -0.5])
def test_flat_bodies_are_possible_in_any_axes(excess: float) -> None:
    for _ in range(20):
        given = turned((1.0, 2.0, 3.0 * (1 + excess)))
        assert np.array(inertia_of(given)) == pytest.approx(np.array(given), abs=1e-15)
    own = from_principal((3.0 * (1 + excess), 1.0, 2.0))
    assert inertia_of(own) == own


def test_bodies_beyond_flat_are_not() -> None:
    for _ in range(20):
        with pytest.raises(Unfit, match="breaks the triangle inequality: 3 exceeds the sum of the other two"):
            inertia_of(turned((1.0, 2.0, 3.0 * (1 + 3e-12))))
        with pytest.raises(Unfit, match="has a negative principal moment"):
            inertia_of(turned((-1e-11, 2.0, 2.0)))
    for moments in ((3.0 * (1 + 3e-12), 1.0, 2.0), (2.0, -1e-11, 2.0)):
        with pytest.raises(Unfit):
            inertia_of(from_principal(moments))
