"""Classifies the joints' rows: those that act in a plane, and those that hold the bodies in it.

All vectors are in plane axes (e1, e2, n). A motion in the plane changes no component of a point or vector along n. So a
row is one of these:

    inside    a function of components in the plane alone: coincident along e1 and e2, perpendicular and along with
              vectors in the plane, distance between points of one depth, angle with vectors in the plane,
              places on curves in it, and couplings of such coordinates;
    outside   constant in such a motion, its gradient in the plane is zero: coincident along n, perpendicular with one
              vector along n, along with the vector along n;
    tilted    neither, unless the joint's other rows help (`tilt`);
    strange   no function of 2-vectors: a screw, a distance between different depths, an angle out of the plane;
    beside    slip along n, at velocity level: zero in such a motion, and without effect on what holds the bodies.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers, Numbers
from mbproj.constraints import Primitive, name_of
from mbproj.dataclass import dataclass
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.thresholds import THRESHOLDS

INSIDE, OUTSIDE, TILTED, STRANGE, BESIDE = range(5)
_CAUSES = {
    "distance": "keeps a distance between points at different depths",
    "angle": "holds an angle that is not in the plane",
    "profile": "follows a curve that is not in the plane",
    "lap": "counts along a curve that is not in the plane",
    "face": "follows a curve that is not in the plane",
    **dict.fromkeys(("face_place", "face_slip"), "counts along a face that is not in the plane"),
    **dict.fromkeys(
        ("two_curves", "place_on_first", "place_on_second", "slip_of_two"), "has curves that are not in the plane"
    ),
    "arc": "counts along a curve that is not in the plane",
    **dict.fromkeys(("beside_first", "beside_second", "space_arc"), "follows a curve in space"),
    "rope": "runs over sheaves at different depths, or out of the plane",
    "coupling": "couples coordinates that are not in the plane",
    "wheel_height": "rolls out of the plane",
    "ellipsoid_height": "rolls out of the plane",
    "ball_slip": "rolls out of the plane",
    "ellipsoid_slip": "rolls out of the plane",
    "edge_slip": "slides on an edge that is tilted",
}
#: Primitives that act in the plane where all their vectors are in it.
_IN_PLANE = frozenset(
    (
        *("angle", "profile", "arc", "lap", "face", "face_place", "face_slip"),
        *("two_curves", "place_on_first", "place_on_second", "slip_of_two"),
    )
)
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

    def multipliers(self, made: Array, count: int) -> Array:
        """Return Wᵀ λ, (..., m), of the set's m = `count` rows, from the multipliers λ (..., size) of the new rows."""
        return _summed(self.weight * made[..., self.row], self.source, count)


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
        elif kind in _IN_PLANE:
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
    kind = next(kind_of(group.primitive) for group in bound.groups if row in group.rows)
    return _CAUSES.get(kind, f"has no planar form ({kind})")


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
