"""Candidates for the normal of a planar scene's plane."""

from __future__ import annotations

import math

import numpy as np

from mbproj.arrays import Array, cross
from mbproj.lanes import each_lane, numbers
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.thresholds import THRESHOLDS

#: The most directions of the joints' vectors that are considered. A joint has three at most, and two in the plane, or
#: the normal itself, are enough.
DIRECTIONS = 6


def candidate_normals(joints: PrimitiveSet, rotation: Array) -> Array:
    """Return unit vectors (k, 3): the directions of the joints' vectors at a pose with rotation (n+1, 3, 3), and then
    the normals of pairs of them.

    In a planar scene each joint has the normal among its vectors, or a vector in the plane, or two vectors. The normal
    of the two is in the plane, or the plane's own; so two joints that are not alike give the normal. If all joints are
    alike, any of their own directions across the common one will do.
    """
    vectors = np.flatnonzero(joints.is_point == 0.0)
    found = _distinct((rotation[joints.body[vectors]] @ joints.local[vectors, :, None])[..., 0], DIRECTIONS)
    first, second = np.triu_indices(len(found), k=1)
    across = cross(found[first], found[second])
    across = across[_lengths(across) > THRESHOLDS.rounded]  # normals of nearly parallel vectors are not accurate
    apart = _lengths(cross(across[:, None], found)) > THRESHOLDS.same_written
    others = _distinct(across[apart.all(axis=1)], DIRECTIONS**2 - len(found))
    return np.concatenate([found, others])


@each_lane
def plane_axes(normal: Array) -> Array:
    """Return right-handed axes (3, 3) with columns e1, e2, n. A normal along a global axis becomes that axis, and e1,
    e2 are the other two in cyclic order: coordinates keep their numbers. Else the largest component of n is
    positive."""
    largest = int(np.argmax(np.abs(normal)))
    if math.hypot(normal[largest - 1], normal[largest - 2]) <= THRESHOLDS.rounding:
        return np.roll(np.eye(3), 2 - largest, axis=1)
    n = normal * np.sign(normal[largest])
    farthest = np.eye(3)[np.argmin(np.abs(n))]
    e1 = farthest - (farthest @ n) * n
    e1 /= np.linalg.norm(e1)
    return np.column_stack([e1, cross(n, e1), n])


def _distinct(vectors: Array, most: int) -> Array:
    """Return the directions of vectors (k, 3), up to sign, in their order; at most `most` of them."""
    length = _lengths(vectors)
    left = vectors[length > 0.0] / length[length > 0.0, None]
    distinct: list[Array] = []
    while len(left) and len(distinct) < most:
        distinct.append(left[0])
        left = left[_lengths(cross(left, left[0])) > THRESHOLDS.same_written]
    return numbers(distinct).reshape(-1, 3)


def _lengths(vectors: Array) -> Array:
    return np.sqrt((vectors * vectors).sum(axis=-1))
