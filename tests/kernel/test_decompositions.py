"""The kernel's decompositions against NumPy and against what they promise: residuals of the size of round-off."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.kernel import core
from tests.kernel.scenes import needs_kernel

pytestmark = needs_kernel
EPS = np.finfo(float).eps
SIZES = (1, 2, 3, 8, 17, 40)


@pytest.fixture
def random():
    return np.random.default_rng(7)


def conditioned(random, rows, columns, condition):
    """A matrix whose singular values fall from 1 to 1/condition."""
    count = min(rows, columns)
    left, right = (np.linalg.qr(random.normal(size=(n, count)))[0] for n in (rows, columns))
    return (left * np.geomspace(1.0, 1.0 / condition, count)) @ right.T


def entries(A):
    return [(int(r), int(c), float(A[r, c])) for r, c in np.argwhere(A != 0.0)]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("condition", [1.0, 1e10])
def test_linear_equations_are_solved_to_round_off_of_their_terms(random, size, condition):
    """Whatever the condition: |A x - b| is some ε |A| |x| with pivots in their columns."""
    A, b = conditioned(random, size, size, condition), random.normal(size=size)
    x = core().solved(A, b)
    assert np.linalg.norm(A @ x - b) <= 8.0 * size * EPS * np.linalg.norm(A, 2) * np.linalg.norm(x)


def test_a_pivot_of_zero_is_exchanged_and_an_equation_of_nothing_has_the_solution_zero():
    assert core().solved(np.array([[0.0, 2.0], [4.0, 0.0]]), np.array([6.0, 8.0])) == pytest.approx([2.0, 3.0])
    assert core().solved(np.diag([2.0, 0.0]), np.array([4.0, 0.0])).tolist() == [2.0, 0.0]
    assert not np.isfinite(core().solved(np.diag([2.0, 0.0]), np.array([4.0, 1.0]))).all()


@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (5, 3), (3, 5), (8, 8), (30, 12), (12, 30)])
@pytest.mark.parametrize("lost", [0, 1, 2])
def test_least_squares_take_the_shortest_of_the_best(random, rows, columns, lost):
    rank = max(min(rows, columns) - lost, 1)
    A = conditioned(random, rows, rank, 10.0) @ conditioned(random, rank, columns, 10.0)
    b = random.normal(size=rows)
    expected = np.linalg.lstsq(A, b, rcond=1e-10)[0]
    assert core().least_squares(A, b) == pytest.approx(expected, rel=0.0, abs=1e-12 * np.linalg.norm(expected))


def test_least_squares_of_nothing_are_zero():
    assert core().least_squares(np.zeros((3, 2)), np.ones(3)).tolist() == [0.0, 0.0]


@pytest.mark.parametrize(("rows", "columns"), [(1, 1), (6, 4), (12, 12), (60, 25)])
def test_the_nearest_vector_has_the_wanted_products(random, rows, columns):
    """The lengths of the columns differ by 1e6, and all of them are found to their own digits."""
    Y = random.normal(size=(rows, columns)) * np.geomspace(1.0, 1e-6, columns)
    w, c = random.normal(size=rows), random.normal(size=columns) * np.linalg.norm(Y, axis=0)
    moved, multipliers = core().nearest(Y, w, c)
    lengths = np.linalg.norm(Y, axis=0)
    unit = Y / lengths
    size = np.linalg.norm(w) + np.linalg.norm(moved)
    assert unit.T @ moved == pytest.approx(c / lengths, rel=0.0, abs=1e-13 * size)
    assert moved == pytest.approx(w - unit @ (lengths * multipliers), rel=0.0, abs=1e-12 * size)


@pytest.mark.parametrize("size", [1, 2, 3, 9, 30, 90, 240])
def test_the_sign_of_a_determinant_is_that_of_numpy(random, size):
    """Of bands with a corner far away, in any order of the rows, as loops have them; and dense ones."""
    for _ in range(20):
        A = np.triu(np.tril(random.normal(size=(size, size)), 4), -3)
        A[0, -1], A[-1, 0] = random.normal(size=2)
        A = A[random.permutation(size)][:, random.permutation(size)]
        assert core().determinant_sign(size, entries(A)) == np.linalg.slogdet(A)[0]
    A = random.normal(size=(size, size))
    assert core().determinant_sign(size, entries(A)) == np.linalg.slogdet(A)[0]


def test_the_determinant_of_a_singular_matrix_has_no_sign():
    assert core().determinant_sign(3, [(0, 0, 1.0), (1, 1, 1.0)]) == 0
    assert core().determinant_sign(2, [(0, 0, 1.0), (0, 1, 2.0), (1, 0, 2.0), (1, 1, 4.0)]) == 0
    assert core().determinant_sign(3, [(r, c, 1.0) for r, c in ((0, 1), (1, 1), (2, 0))]) == 0
    assert core().determinant_sign(2, [(0, 0, 0.0), (0, 1, 1.0), (1, 0, 1.0)]) == -1


@pytest.mark.parametrize("kind", ["full", "diagonal", "graded", "two equal", "semidefinite"])
def test_roots_and_eigenvalues_of_symmetric_matrices(random, kind):
    for _ in range(50):
        axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
        values = {"graded": np.array([1.0, 1e-4, 1e-8]), "two equal": np.array([2.0, 2.0, 5.0])}.get(
            kind, random.uniform(0.1, 10.0, size=3)
        )
        if kind == "semidefinite":
            values[1] = 0.0
        A = np.diag(values) if kind == "diagonal" else (axes * values) @ axes.T
        A = 0.5 * (A + A.T)
        least, most, R, inverse, norm = core().small_decompositions(A)
        size = values.max()
        assert [least, most] == pytest.approx([values.min(), size], rel=0.0, abs=16.0 * EPS * size)
        assert pytest.approx(A, rel=0.0, abs=16.0 * EPS * size) == R.T @ R
        if kind == "semidefinite":
            continue
        assert not np.triu(inverse, 1).any()
        condition = size / values.min()
        assert inverse @ A @ inverse.T == pytest.approx(np.eye(3), rel=0.0, abs=16.0 * EPS * condition)
        assert norm == pytest.approx(np.linalg.norm(1.0 / values), rel=16.0 * EPS * condition)


def test_negative_eigenvalues_count_as_zero_in_a_root(random):
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    _, _, R, _, _ = core().small_decompositions((axes * [2.0, -3.0, 0.5]) @ axes.T)
    assert pytest.approx((axes * [2.0, 0.0, 0.5]) @ axes.T, rel=0.0, abs=1e-15 * 30.0) == R.T @ R


def test_what_does_not_fit_is_refused_with_its_name():
    with pytest.raises(ValueError, match="A"):
        core().solved(np.eye(3), np.ones(2))
    with pytest.raises(ValueError, match="row"):
        core().determinant_sign(2, [(2, 0, 1.0)])
    with pytest.raises(ValueError, match="Y has more columns than rows"):
        core().nearest(np.ones((1, 2)), np.ones(1), np.ones(2))
