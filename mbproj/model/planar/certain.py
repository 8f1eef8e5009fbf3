"""Decides from the topology alone, where it can, that a mechanism is planar. The verdict is cached, so that a search or
a sweep decides once.

Let n be a global axis. Let every vector of the joints lie across n or along n, and every row be inside or outside, none
tilted. Then `planar_reduction` takes n for any lengths and masses:

- Candidates for the normal are directions of vectors and normals of two. Each is n or lies across n, but for round-off.
- Seen along another candidate e, rows outside are those of coincident points, and those of a vector along e. Vectors
  across n that one joint has in one body can lie along e together only where they are parallel. This bounds the number
  of rows outside along e. Where the bound is below the number of rows outside along n, n is the first candidate.
- A joint that locks a shift along n, and turns about two directions across n that are fixed in one body, holds two
  bodies in one plane at any length. Where such joints connect all bodies to the ground, the rank is full.

The verdict is cached, with these facts alone as its key: the sides of rows, which vectors lie along n, and which
vectors of one joint in one body are parallel. `candidate_normals` are those that a search tries where the topology does
not decide.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import lru_cache
from itertools import combinations
from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Flags, Integers, Numbers, cross, numbers
from mbproj.base.cases import per_case
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.joints.primitives.basic import Primitive
from mbproj.joints.primitives.table import name_of
from mbproj.model.primitive_set import PrimitiveSet, SetLayout

# --- Classifies the joints' rows --------------------------------------------------------------------------------------
# Those that act in a plane, and those that hold the bodies in it.
# All vectors are in plane axes (e1, e2, n). A motion in the plane changes no component of a point or vector along n.
# So a row is one of these:
#
#    inside    a function of components in the plane alone: coincident along e1 and e2, perpendicular and along with
#              vectors in the plane, distance between points of one depth, angle with vectors in the plane,
#              places on curves in it, and couplings of such coordinates;
#    outside   constant in such a motion, its gradient in the plane is zero: coincident along n, perpendicular with one
#              vector along n, along with the vector along n;
#    tilted    neither, unless the joint's other rows help (`tilt`);
#    strange   no function of 2-vectors: a screw, a distance between different depths, an angle out of the plane;
#    beside    slip along n, at velocity level: zero in such a motion, and without effect on what holds the bodies.


INSIDE, OUTSIDE, TILTED, STRANGE, BESIDE = range(5)
#: For each kind of slip, the slots of the plane's normal and of the direction of the row.
_OF_SLIP = {"ball_slip": (3, 1), "ellipsoid_slip": (3, 1), "edge_slip": (7, 7)}


@dataclass(frozen=True, eq=False)
class RowMap:
    """A sparse matrix W (size, m) that makes new rows of a set's m rows: entries `weight` at (`row`, `source`)."""

    size: int
    row: Integers
    source: Integers
    weight: Array

    def rows(self, values: Array) -> Array:
        """Return W C, (..., size), from C (..., m)."""
        return _summed(self.weight * values[..., self.source], self.row, self.size)

    def multipliers(self, λ: Array, count: int) -> Array:
        """Return Wᵀ λ, (..., m), of the set's m = `count` rows, from the multipliers λ (..., size) of the new rows."""
        return _summed(self.weight * λ[..., self.row], self.source, count)


@dataclass(frozen=True, eq=False)
class Seen:
    """A set's attachments in plane axes: `arm` (..., S, 3) from the body's centre of mass, `x` (..., S, 3) from the
    origin. Vectors in the plane or along n up to round-off are set exactly in it or along it. Depths are compared with
    `extent` in m."""

    arm: Array
    x: Array
    extent: float

    def in_axes(self, number: int) -> Seen:
        """Return the attachments in the axes with this number, where there are several."""
        return Seen(self.arm[number], self.x[number], self.extent)


def kind_of(primitive: Primitive) -> str:
    """Return the primitive's name in PRIMITIVES, or that of its class."""
    return name_of(type(primitive))


def see(bound: PrimitiveSet, position: Array, rotation: Array, axes: Array, length: float) -> Seen:
    """Return a set's attachments in plane axes (..., 3, 3) at a pose: position (n+1, 3) and rotation (n+1, 3, 3), the
    ground last."""
    return seen_from(bound, (rotation[bound.body] @ bound.local[..., None])[..., 0] @ axes, position @ axes, length)


def seen_from(bound: PrimitiveSet, arm: Array, centre: Array, length: float) -> Seen:
    """Return a set's attachments from their arms (..., S, 3) and the centres of mass (..., n+1, 3), both in plane
    axes."""
    vector = bound.is_point == 0.0
    of_vectors = np.where(vector[:, None], arm, 1.0)
    level = np.abs(of_vectors[..., 2]) <= THRESHOLDS.rounding
    upright = np.linalg.norm(of_vectors[..., :2], axis=-1) <= THRESHOLDS.rounding
    arm[level, 2], arm[upright, :2] = 0.0, 0.0
    x = arm + bound.is_point[:, None] * centre[..., bound.body, :]
    return Seen(arm, x, np.maximum(length, np.abs(centre).max()).item())


def level_and_upright(bound: PrimitiveSet, x: Numbers) -> tuple[Any, Any]:
    """Which vectors of a set are in the plane, and which along n, (..., S); no points."""
    of_vectors = np.where((bound.is_point == 0.0)[:, None], x, 1.0)
    return of_vectors[..., 2] == 0.0, np.abs(of_vectors[..., :2]).max(axis=-1) == 0.0


def sides(bound: PrimitiveSet, seen: Seen) -> Integers:
    """Return the side of each row on its own: INSIDE, OUTSIDE, TILTED, STRANGE or BESIDE, (..., m)."""
    side = np.full((*seen.x.shape[:-2], bound.size), STRANGE, dtype=np.intp)
    depth = seen.x[..., 2]
    is_level, is_upright = level_and_upright(bound, seen.x)
    for group in bound.groups:
        level, upright = is_level[..., group.slots], is_upright[..., group.slots]
        kind, row = kind_of(group.primitive), group.rows[:, 0]
        if kind == "coincident":
            side[..., group.rows] = [INSIDE, INSIDE, OUTSIDE]
        elif kind == "perpendicular":
            side[..., row] = _side(level.all(axis=-1), upright.any(axis=-1))
        elif kind == "along":
            side[..., row] = _side(level[..., 0], upright[..., 0])
        elif kind == "distance":
            apart = depth[..., group.slots[:, 1]] - depth[..., group.slots[:, 0]]
            side[..., row] = np.where(np.abs(apart) <= THRESHOLDS.rounding * seen.extent, INSIDE, STRANGE)
        elif kind == "coupling":
            row_of: Any = group.primitive
            parts = [_is_coordinate_inside(level[..., slots], each) for each, _, slots in row_of.terms()]
            side[..., row] = np.where(np.all(parts, axis=0), INSIDE, STRANGE)
        elif kind == "rope":
            deep = np.ptp(depth[..., group.slots[:, 2:]], axis=-1) > THRESHOLDS.rounding * seen.extent
            side[..., row] = np.where(level[..., :2].all(axis=-1) & ~deep, INSIDE, STRANGE)
        elif kind == "wheel_height":
            side[..., row] = np.where(level[..., 1] & upright[..., 3], INSIDE, STRANGE)
        elif kind == "ellipsoid_height":
            rolls = level[..., 1] & _is_axis_across(level[..., 3:], upright[..., 3:])
            side[..., row] = np.where(rolls, INSIDE, STRANGE)
        elif kind in ("wheel_slip_along", "wheel_slip_across"):
            rolls = level[..., 3] & upright[..., 7]
            side[..., row] = np.where(rolls, INSIDE if kind == "wheel_slip_along" else BESIDE, STRANGE)
        elif kind in _OF_SLIP:
            normal, along = _OF_SLIP[kind]
            inside = level[..., normal] & level[..., along]
            inside_or_not = np.where(inside, INSIDE, np.where(upright[..., along], BESIDE, STRANGE))
            rolls = kind != "ellipsoid_slip" or _is_axis_across(level[..., 5:], upright[..., 5:])
            side[..., row] = np.where(rolls, inside_or_not, STRANGE)
        elif group.primitive.acts_in_plane:
            side[..., row] = np.where(_is_coordinate_inside(level, group.primitive), INSIDE, STRANGE)
    return side


def _is_axis_across(level: npt.NDArray[np.bool_], upright: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Whether one of three axes is along n, and the others therefore in the plane."""
    return np.asarray(upright.any(axis=-1) & (level | upright).all(axis=-1), dtype=bool)


def _is_coordinate_inside(level: npt.NDArray[np.bool_], primitive: Primitive) -> npt.NDArray[np.bool_]:
    """Whether a coordinate acts in the plane: all its vectors are in it. `level` (..., k, s): whether each slot's
    vector is."""
    vectors = [kind == "vector" for kind in primitive.slots]
    return np.asarray(level[..., vectors].all(axis=-1), dtype=bool)


def strangeness(bound: PrimitiveSet, row: int) -> str:
    """Return the cause of a strange row, in words that follow its joint's name."""
    return next(group.primitive.off_plane for group in bound.groups if row in group.rows)


def _summed(terms: Array, place: Integers, size: int) -> Array:
    """Return the sums (..., size) of the terms (..., k) that have the same place (k,)."""
    if terms.ndim == 1:
        sums: Array = np.bincount(place, terms, minlength=size).astype(float)
        return sums
    total = np.zeros((size, *terms.shape[:-1]), like=terms)
    np.add.at(total, place, np.moveaxis(terms, -1, 0))
    return np.moveaxis(total, 0, -1)


def _side(inside: npt.NDArray[np.bool_], outside: npt.NDArray[np.bool_]) -> Integers:
    return np.where(outside, OUTSIDE, np.where(inside, INSIDE, TILTED))


# --- Decides from the topology alone, where it can, that a mechanism is planar ----------------------------------------


#: The number of verdicts that are kept.
KEPT = 64


@dataclass(frozen=True, eq=False)
class CertainPlane:
    """The plane's `axes` (3, 3), the joints as `seen` along them, and the `side` of each row (m,). `is_held` is False
    where the topology does not show that the joints hold all bodies in the plane."""

    axes: Array
    seen: Seen
    side: Integers
    is_held: bool


def certain_plane(joints: PrimitiveSet, position: Array, rotation: Array, length: float) -> CertainPlane | None:
    """Return the plane of a mechanism at a pose where the topology alone decides, else None; the ground is the last
    body."""
    bodies = len(position) - 1
    axis = _axis(joints, rotation) if 0 < bodies <= THRESHOLDS.large else None
    if axis is None:
        return None
    axes = np.roll(np.eye(3), 2 - axis, axis=1)
    seen = see(joints, position, rotation, axes[None], length)
    side = sides(joints, seen)[0]
    seen = seen.in_axes(0)
    level, along = level_and_upright(joints, seen.x)
    if not (along | level)[joints.is_point == 0.0].all():
        return None
    first, second = _pairs(joints.layout)
    parallel = _sine(joints.local[first], joints.local[second]) < THRESHOLDS.near_singular
    verdict = _verdict(joints.layout, bodies, side.tobytes(), along.tobytes(), parallel.tobytes())
    return CertainPlane(axes, seen, side, verdict.is_held) if verdict.is_first else None


def _axis(joints: PrimitiveSet, rotation: Array) -> int | None:
    """Return the number of the global axis along which most of the joints' first vectors lie, None where none does.
    `candidate_normals` contains this axis."""
    first = np.flatnonzero(joints.is_point == 0.0)[:DIRECTIONS]
    return _most_along((rotation[joints.body[first]] @ joints.local[first, :, None])[..., 0])


def _most_along(vectors: Array) -> int | None:
    """Return the number of the axis along which most of the vectors (k, 3) lie; None where none does, or one lies
    nearly along."""
    sizes = np.sort(np.abs(vectors), axis=-1)
    size, off = sizes[:, 2], np.sqrt(sizes[:, 0] ** 2 + sizes[:, 1] ** 2)
    is_along = (off <= 0.5 * THRESHOLDS.rounding * size) & (size > 0.0)
    if (~is_along & (off <= 2.0 * THRESHOLDS.same_written * size) & (size > 0.0)).any():
        return None  # a vector nearly along an axis is another candidate
    along = np.argmax(np.abs(vectors[is_along]), axis=-1)
    return int(np.argmax(np.bincount(along, minlength=3))) if len(along) else None


@lru_cache(KEPT)
def _pairs(layout: SetLayout) -> tuple[Integers, Integers]:
    """Return the pairs of vectors that belong to one joint and one body, including each vector with itself."""
    joint = np.zeros(len(layout.body), dtype=np.intp)
    joint[layout.entry_slot] = layout.owner[layout.entry_row]
    is_vector = layout.is_point == 0.0
    same = (joint[:, None] == joint) & (layout.body[:, None] == layout.body) & is_vector[:, None] & is_vector
    first, second = np.nonzero(same)
    return first, second


@dataclass(frozen=True)
class _Verdict:
    """`is_first`: whether n is the first candidate. `is_held`: whether the joints hold all bodies in the plane."""

    is_first: bool
    is_held: bool


@lru_cache(KEPT)
def _verdict(layout: SetLayout, bodies: int, side: bytes, along: bytes, parallel: bytes) -> _Verdict:
    """Return the verdict for the sides of rows (m,), the attachments along n (S,), and the pairs that are parallel."""
    sides_of, is_along = np.frombuffer(side, dtype=np.intp), np.frombuffer(along, dtype=bool)
    are_parallel = np.zeros((len(layout.body),) * 2, dtype=bool)
    are_parallel[_pairs(layout)] = np.frombuffer(parallel, dtype=bool)
    if not np.isin(sides_of, (INSIDE, OUTSIDE, BESIDE)).all():
        return _Verdict(is_first=False, is_held=False)
    rows = [_Row(layout, row, is_along) for row in range(len(sides_of))]
    outside = [row for row, row_side in zip(rows, sides_of, strict=True) if row_side == OUTSIDE]
    return _Verdict(_most_elsewhere(rows, are_parallel) < len(outside), _all_held(outside, are_parallel, bodies))


class _Row:
    """A row with its joint, its kind, its bodies, and the slots of the vectors across n that it binds."""

    def __init__(self, layout: SetLayout, row: int, along: Flags) -> None:
        member = layout.members[layout.member[row]]
        self.joint, self.kind = int(layout.owner[row]), kind_of(member.primitive)
        self.is_third = row == member.rows[-1]
        self.bodies = frozenset(int(layout.body[slot]) for slot in member.slots)
        self.across = [slot for slot in member.slots if layout.is_point[slot] == 0.0 and not along[slot]]
        self.body_of = {slot: int(layout.body[slot]) for slot in self.across}


def _most_elsewhere(rows: list[_Row], parallel: Flags) -> int:
    """Return the most rows that can be outside along a direction that is not n."""
    most = sum(row.kind == "coincident" and row.is_third for row in rows)
    groups: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for number, row in enumerate(rows):
        if row.kind in ("perpendicular", "along"):
            for slot in row.across:
                groups.setdefault((row.joint, row.body_of[slot]), []).append((number, slot))
    for group in groups.values():
        most += max(len({k for k, other in group if parallel[slot, other]}) for _, slot in group)
    return most


def _all_held(outside: list[_Row], parallel: Flags, bodies: int) -> bool:
    """Whether joints that hold two bodies in one plane connect all bodies to the ground."""
    held, links = {bodies}, [*_links(outside, parallel)]
    while True:
        reached = {body for link in links if link & held for body in link} - held
        if not reached:
            return len(held) == bodies + 1
        held |= reached


def _links(outside: list[_Row], parallel: Flags) -> Iterator[frozenset[int]]:
    """The pairs of bodies that one joint holds in one plane."""
    by_joint: dict[tuple[int, frozenset[int]], list[_Row]] = {}
    for row in outside:
        by_joint.setdefault((row.joint, row.bodies), []).append(row)
    for (_, pair), rows in by_joint.items():
        turns = [row for row in rows if row.kind == "perpendicular" and len(row.across) == 1]
        apart = any(
            a.body_of[i] == b.body_of[j] and not parallel[i, j]
            for a, b in combinations(turns, 2)
            for i, j in [(*a.across, *b.across)]
        )
        if apart and len(pair) == 2 and any(row.kind in ("coincident", "along") for row in rows):
            yield pair


def _sine(first: Array, second: Array) -> Array:
    """Return the sines of the angles between vectors (..., 3); 0 where a vector has no length."""
    size = np.linalg.norm(first, axis=-1) * np.linalg.norm(second, axis=-1)
    sines: Array = np.linalg.norm(cross(first, second), axis=-1) / np.where(size > 0.0, size, 1.0)
    return sines


#: The most directions of the joints' vectors that are considered. A joint has at most three. Two directions in the
#: plane are enough, and so is the normal itself.
DIRECTIONS = 6


def candidate_normals(joints: PrimitiveSet, rotation: Array) -> Array:
    """Return unit vectors (k, 3): the directions of the joints' vectors at a pose with rotation (n+1, 3, 3), and then
    the normals of pairs of them.

    In a planar scene each joint has the normal among its vectors, or a vector in the plane, or two vectors. The normal
    of two vectors is in the plane or is the plane's normal. So two joints that are not alike give the plane's normal.
    If all joints are alike, any of their directions across the common one is a normal.
    """
    vectors = np.flatnonzero(joints.is_point == 0.0)
    directions = _distinct((rotation[joints.body[vectors]] @ joints.local[vectors, :, None])[..., 0], DIRECTIONS)
    first, second = np.triu_indices(len(directions), k=1)
    across = cross(directions[first], directions[second])
    across = across[_lengths(across) > THRESHOLDS.rounded]  # normals of nearly parallel vectors are not accurate
    apart = _lengths(cross(across[:, None], directions)) > THRESHOLDS.same_written
    others = _distinct(across[apart.all(axis=1)], DIRECTIONS**2 - len(directions))
    return np.concatenate([directions, others])


@per_case
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
