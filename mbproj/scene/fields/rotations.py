"""Unit Euler parameters (scalar first, body to global) from whatever form a rotation is written in, and back."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mbproj.base.cases import per_case
from mbproj.scene.records import Matrix, Quaternion, Vector

#: The sequences of Euler angles: three letters of xyz, no two neighbours equal.
SEQUENCES = tuple(a + b + c for a in "xyz" for b in "xyz" for c in "xyz" if a != b != c)
#: How far the rows of a rotation matrix may be from orthonormal: six written digits are enough, five are not.
ORTHONORMAL = 1e-6


@per_case
def unit(vector: Sequence[float]) -> tuple[float, ...] | None:
    """The vector over its length; None for a zero vector. Scaled by a power of two first, so nothing overflows."""
    largest = max(abs(x) for x in vector)
    if largest == 0.0:
        return None
    exponent = math.frexp(largest)[1]
    scaled = [math.ldexp(x, -exponent) for x in vector]
    length = math.hypot(*scaled)
    return tuple(x / length for x in scaled)


def multiply(p: Quaternion, q: Quaternion) -> Quaternion:
    """The rotation q, followed by p in global axes (or: p, followed by q in the axes that p has turned)."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


@per_case
def from_axis_angle(axis: Vector, angle: float) -> Quaternion:
    """The rotation by `angle` (rad) about the unit vector `axis`."""
    sine = math.sin(angle / 2)
    return (math.cos(angle / 2), sine * axis[0], sine * axis[1], sine * axis[2])


def from_euler(angles: Vector, sequence: str) -> Quaternion:
    """Three rotations (rad) in turn, each about the body's own axis that `sequence` names, e.g. "zxz"."""
    result: Quaternion = (1.0, 0.0, 0.0, 0.0)
    for angle, letter in zip(angles, sequence, strict=True):
        axis: Vector = (float(letter == "x"), float(letter == "y"), float(letter == "z"))
        result = multiply(result, from_axis_angle(axis, angle))
    return result


@per_case
def from_matrix(matrix: Matrix) -> Quaternion:
    """The rotation of an orthonormal matrix whose columns are the body's axes; of ± the one with w >= 0.

    Shepperd's (1978) branches: the largest of the four components is found first and divides the others.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = matrix
    w, x, y, z = 1 + xx + yy + zz, 1 + xx - yy - zz, 1 + yy - xx - zz, 1 + zz - xx - yy
    products = (  # 4 times each component's products with all four
        (w, zy - yz, xz - zx, yx - xy),
        (zy - yz, x, yx + xy, xz + zx),
        (xz - zx, yx + xy, y, zy + yz),
        (yx - xy, xz + zx, zy + yz, z),
    )
    squares = (w, x, y, z)
    quaternion = unit(products[squares.index(max(squares))])
    assert quaternion is not None
    w, x, y, z = quaternion
    return (w, x, y, z) if w >= 0 else (-w, -x, -y, -z)


def to_matrix(p: Quaternion) -> Matrix:
    """The matrix whose columns are the body's axes."""
    w, x, y, z = p
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def orthonormality_error(matrix: Matrix) -> float:
    """The largest element of |RRᵀ - I|."""
    rows = range(3)
    return max(
        abs(sum(a * b for a, b in zip(matrix[i], matrix[j], strict=True)) - (i == j)) for i in rows for j in rows
    )


def cross(u: Vector, v: Vector) -> Vector:
    """u × v."""
    return (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])


def determinant(matrix: Matrix) -> float:
    """det of a 3 x 3 matrix."""
    return sum(a * b for a, b in zip(matrix[0], cross(matrix[1], matrix[2]), strict=True))


# --- Inertia tensors --------------------------------------------------------------------------------------------------
# The three ways to write one, and whether a body can have it.


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
    return all(value >= 0.0 for value in (x, y, z)) and all(
        value <= slack for value in (x - y - z, y - z - x, z - x - y)
    )


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
