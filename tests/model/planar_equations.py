"""C, C_p and γ in the coordinates of the plane, by the primitives of `mbproj.joints.primitives.table` on vectors (x, y, 0).

No row is defined a second time: the plane selects rows and columns. The kernel is tested against these.
"""

from __future__ import annotations

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.model.planar.plane import PlanarSet, Plane
from mbproj.model.primitive_set import Binding, PrimitiveSet, bind


@dataclass(frozen=True, eq=False)
class _Embedded:
    """A planar set as a spatial one with all in the plane z = 0; `kept` (m,) are its rows but for coincidence in z."""

    bound: PrimitiveSet
    kept: Integers


def planar_constraint(plane: Plane, p: Numbers) -> Numbers:
    """C of the joints' rows in the plane, (..., m), at p (..., 3n)."""
    return planar_value(plane.joints, p)


def planar_jacobian(plane: Plane, p: Array) -> Array:
    """C_p of the joints' rows in the plane, (m, 3n), at one p (3n,)."""
    embedded = _embedded(plane.joints)
    bound, bodies = embedded.bound, len(plane.mass)
    x, arm = _attached(bound, p)
    gradient, slot = bound.gradient_entries(x), bound.entry_slot
    entries = np.empty((len(slot), 3))
    entries[:, :2] = bound.is_point[slot, None] * gradient[:, :2]
    entries[:, 2] = np.sum(gradient * _turned(arm)[slot], axis=-1)
    total = np.zeros((bound.size, bodies + 1, 3))
    np.add.at(total, (bound.entry_row, bound.body[slot]), entries)
    return total[embedded.kept, :bodies].reshape(len(embedded.kept), -1)


def planar_gamma(plane: Plane, p: Numbers, u: Numbers) -> Numbers:
    """γ of the joints' rows in the plane, (..., m): C'' = C_p p'' - γ along a motion with p' = u (..., 3n)."""
    embedded = _embedded(plane.joints)
    bound = embedded.bound
    x, arm = _attached(bound, p)
    rates = _by_body(u)[..., bound.body, :]
    velocity = rates * [1.0, 1.0, 0.0] * bound.is_point[:, None]
    spin = rates[..., 2:]
    bias = bound.derivative_along(bound.gradient_entries(x), -(spin**2) * arm)
    return -(bias + bound.curvature(x, velocity + spin * _turned(arm)))[..., embedded.kept]


def planar_value(planar: PlanarSet, p: Numbers) -> Numbers:
    """The values of a planar set, (..., m), at p (..., 3n): C of joints, or what coordinates are."""
    embedded = _embedded(planar)
    x, _ = _attached(embedded.bound, p)
    return embedded.bound.value(x)[..., embedded.kept] - planar.offset


def _embedded(planar: PlanarSet) -> _Embedded:
    bindings, kept, first = [], [], 0
    ends = np.append(planar.row, planar.size)
    for index, primitive in enumerate(planar.primitives):
        slots = planar.first_slot[index] + np.arange(len(primitive.slots))
        attachments = tuple((int(planar.body[slot]), 1, np.array([*planar.local[slot], 0.0])) for slot in slots)
        bindings.append(Binding(primitive, int(planar.owner[index]), attachments))
        kept.append(first + np.arange(ends[index + 1] - ends[index]))
        first += primitive.rows
    return _Embedded(bind(bindings), np.concatenate([np.zeros(0, dtype=np.intp), *kept]))


def _attached(bound: PrimitiveSet, p: Numbers) -> tuple[Numbers, Numbers]:
    """Points and vectors (..., S, 3), and what of them turns with the body."""
    place = _by_body(p)[..., bound.body, :]
    cosine, sine = np.cos(place[..., 2:]), np.sin(place[..., 2:])
    arm = cosine * bound.local + sine * _turned(bound.local)
    return arm + place * [1.0, 1.0, 0.0] * bound.is_point[:, None], arm


def _turned(vectors: Numbers) -> Numbers:
    """A quarter turn of (x, y, 0): (-y, x, 0)."""
    return np.stack([-vectors[..., 1], vectors[..., 0], np.zeros_like(vectors[..., 2])], axis=-1)


def _by_body(flat: Numbers) -> Numbers:
    """(..., 3n) as (..., n+1, 3), the ground last and at rest."""
    rows = flat.reshape(*flat.shape[:-1], -1, 3)
    return np.concatenate([rows, np.zeros((*rows.shape[:-2], 1, 3), dtype=rows.dtype)], axis=-2)
