"""Inertia tensors: the three ways to write one, and whether a body can have it."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mbproj.cases import per_case
from mbproj.scene.records import Matrix, Vector

#: The largest error that counts as round-off, relative to the largest principal moment (or element).
ROUND_OFF = 1e-12
_PLANES = ((0, 1), (0, 2), (1, 2))


def from_principal(moments: Vector) -> Matrix:
    """The tensor with these principal moments about the body's axes."""
    x, y, z = moments
    return ((x, 0.0, 0.0), (0.0, y, 0.0), (0.0, 0.0, z))


def from_elements(elements: Sequence[float]) -> Matrix:
    """The tensor from [Ixx, Iyy, Izz, Ixy, Ixz, Iyz], tensor elements: Ixy = -∫xy dm."""
    xx, yy, zz, xy, xz, yz = elements
    return ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))


def symmetric(matrix: Matrix) -> Matrix | None:
    """The matrix with its round-off asymmetry averaged out; None where it is not symmetric."""
    scale = max(abs(x) for row in matrix for x in row)
    if any(abs(matrix[i][j] - matrix[j][i]) > ROUND_OFF * scale for i, j in _PLANES):
        return None
    diagonal = [matrix[i][i] for i in range(3)]
    return from_elements([*diagonal, *(matrix[i][j] / 2 + matrix[j][i] / 2 for i, j in _PLANES)])


def principal_moments(matrix: Matrix) -> tuple[float, float, float]:
    """The eigenvalues of a symmetric matrix in ascending order, by Jacobi's rotations, to a few ε of the largest."""
    scale = max(abs(x) for row in matrix for x in row)
    if scale == 0.0:
        return (0.0, 0.0, 0.0)
    a = [[x / scale for x in row] for row in matrix]
    while sum(a[i][j] ** 2 for i, j in _PLANES) > 1e-34:
        for i, j in _PLANES:
            _rotate(a, i, j)
    first, second, third = sorted(a[i][i] * scale for i in range(3))
    return (first, second, third)


def _rotate(a: list[list[float]], i: int, j: int) -> None:
    """Turn the plane (i, j) so that a[i][j] vanishes (Golub & Van Loan, 8.5.2)."""
    if a[i][j] == 0.0:
        return
    half = (a[j][j] - a[i][i]) / (2 * a[i][j])
    tangent = math.copysign(1.0, half) / (abs(half) + math.hypot(1.0, half))
    cosine = 1 / math.hypot(1.0, tangent)
    sine = tangent * cosine
    for k in range(3):
        a[k][i], a[k][j] = cosine * a[k][i] - sine * a[k][j], sine * a[k][i] + cosine * a[k][j]
    for k in range(3):
        a[i][k], a[j][k] = cosine * a[i][k] - sine * a[j][k], sine * a[i][k] + cosine * a[j][k]
    a[i][j] = a[j][i] = 0.0  # else rotations would go on for round-off, without end where two moments are equal


def impossible(matrix: Matrix) -> str | None:
    """Return the reason why no body can have this symmetric tensor; None where one can. Principal moments are not
    negative, and none is larger than the sum of the other two."""
    return None if _is_possible_diagonal(matrix) else _why_impossible(matrix)


def _is_possible_diagonal(matrix: Matrix) -> bool:
    """Whether the tensor is diagonal and possible: its principal moments are then the diagonal."""
    if any(matrix[i][j] != 0.0 for i, j in _PLANES):
        return False
    x, y, z = (matrix[i][i] for i in range(3))
    slack = ROUND_OFF * (x + y + z) / 3.0
    return all(own >= 0.0 for own in (x, y, z)) and all(own <= slack for own in (x - y - z, y - z - x, z - x - y))


@per_case
def _why_impossible(matrix: Matrix) -> str | None:
    low, middle, high = principal_moments(matrix)
    slack = ROUND_OFF * max(abs(low), abs(high))
    shown = f"principal moments {low:.6g}, {middle:.6g} and {high:.6g}"
    if low < -slack:
        return f"has a negative principal moment ({shown})"
    if high - middle > low + slack:
        return f"breaks the triangle inequality: {high:.6g} exceeds the sum of the other two ({shown})"
    return None
