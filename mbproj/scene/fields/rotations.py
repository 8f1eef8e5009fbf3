"""Unit Euler parameters (scalar first, body to global) from whatever form a rotation is written in, and back."""

from __future__ import annotations

import math
from collections.abc import Sequence

from mbproj.cases import per_case
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
