"""A planar mechanism: three coordinates a body, x, y and θ, and the conversions from and to seven."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Integers, may_overflow, numbers
from mbproj.base.dataclass import dataclass
from mbproj.joints.primitives.basic import Primitive
from mbproj.model.euler_parameters import product
from mbproj.model.planar.certain import RowMap, Seen, kind_of
from mbproj.model.primitive_set import LAYOUTS, Member, PrimitiveSet, SetLayout

# --- Primitives bound to bodies in a plane ----------------------------------------------------------------------------
# The PrimitiveSet of 2-vectors.


@dataclass(frozen=True, eq=False)
class PlanarSet:
    """k primitives on S attachments, with m rows: those of a spatial set that act in the plane.

    Per primitive: `primitives` (k,); `first_slot` (k,), its first attachment, which the others follow; `row` (k,), its
    first row; `owner` (k,), the joint. A coincident primitive has two rows, along e1 and e2, the others one.

    Per attachment: `body` (S,), where the ground is the last index; `local` (S, 2) in the body's planar axes, which are
    e1 and e2 at angle zero; `is_point` (S,), 1 for points and 0 for vectors. Per row: `offset` (m,). `source` makes the
    rows from the spatial set's, and the spatial set's multipliers from the rows' multipliers.

    A vector may point out of the plane, as in a prismatic joint. Then `local` is its part in the plane, and `offset`
    contains the constant from its part along n.
    """

    primitives: tuple[Primitive, ...]
    first_slot: Integers
    row: Integers
    owner: Integers
    body: Integers
    local: Array
    is_point: Array
    offset: Array
    source: RowMap

    @property
    def size(self) -> int:
        """m, the number of rows."""
        return self.source.size

    @property
    def kinds(self) -> tuple[str, ...]:
        """The primitives' names in PRIMITIVES, (k,)."""
        return tuple(kind_of(primitive) for primitive in self.primitives)


def planar_set(bound: PrimitiveSet, seen: Seen, inside: npt.NDArray[np.bool_], axes: Array) -> PlanarSet:
    """Return the primitives of `bound` whose rows are `inside` (m,); coincident ones along e1, e2 and n of `axes` (3,
    3)."""
    layout = _planar_layout(bound.layout, inside.tobytes(), axes.tobytes())
    slots, source = layout.slots, layout.source
    whole, flat = bound.value(np.stack([seen.x, seen.x * [1.0, 1.0, 0.0]]))
    for each in bound.layout.members:
        if kind_of(each.primitive) == "wheel_height":  # its planar form assumes that the axis is normal to the plane
            flat[list(each.rows)] = whole[list(each.rows)]
    return PlanarSet(
        primitives=layout.primitives,
        first_slot=layout.first_slot,
        row=layout.row,
        owner=layout.owner,
        body=bound.body[slots],
        local=seen.arm[slots, :2],
        is_point=bound.is_point[slots],
        offset=source.rows(bound.offset) - (whole - flat)[layout.rows],
        source=source,
    )


@dataclass(frozen=True, eq=False)
class _PlanarLayout:
    """The parts of a `PlanarSet` that do not depend on its numbers, with the attachments (S,) and rows (m,) of the
    spatial set."""

    primitives: tuple[Primitive, ...]
    first_slot: Integers
    row: Integers
    owner: Integers
    slots: Integers
    rows: Integers
    source: RowMap


@lru_cache(LAYOUTS)
def _planar_layout(layout: SetLayout, inside: bytes, axes: bytes) -> _PlanarLayout:
    """Return the layout of a planar set from the cache. Sets share it, so that nobody may write to it."""
    acts = np.frombuffer(inside, dtype=bool).tolist()
    members = [(each, rows) for each in layout.members if (rows := [row for row in each.rows if acts[row]])]
    planar = _PlanarLayout(
        primitives=tuple(each.primitive for each, _ in members),
        first_slot=_starts([len(each.slots) for each, _ in members]),
        row=_starts([len(rows) for _, rows in members]),
        owner=layout.owner[[each.rows[0] for each, _ in members]],
        slots=np.array([slot for each, _ in members for slot in each.slots], dtype=np.intp),
        rows=np.array([row for _, rows in members for row in rows], dtype=np.intp),
        source=_source(members, np.frombuffer(axes).reshape(3, 3)),
    )
    for part in (*vars(planar).values(), *vars(planar.source).values()):
        if isinstance(part, np.ndarray):
            part.flags.writeable = False
    return planar


def _source(members: list[tuple[Member, list[int]]], axes: Array) -> RowMap:
    """Return the map to the planar rows: one spatial row each, but all three rows of coincident points."""
    along: list[list[float]] = axes.T.tolist()
    row: list[int] = []
    source: list[int] = []
    weight: list[float] = []
    size = 0
    for each, rows in members:
        for spatial in rows:
            all_three = len(each.rows) == 3
            parts = zip(each.rows, along[spatial - each.rows[0]], strict=True) if all_three else [(spatial, 1.0)]
            used = [(source_row, part) for source_row, part in parts if part]
            row += [size] * len(used)
            source += [source_row for source_row, _ in used]
            weight += [part for _, part in used]
            size += 1
    return RowMap(size, np.array(row, dtype=np.intp), np.array(source, dtype=np.intp), np.array(weight))


def _starts(lengths: list[int]) -> Integers:
    return np.cumsum([0, *lengths], dtype=np.intp)[:-1]


# --- A planar mechanism -----------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Plane:
    """A planar mechanism of n bodies.

    `axes` (3, 3): columns e1, e2 and the normal n, right-handed. `depth` (n,): n·r of each body in m, which does not
    change. `reference` (n, 4): the orientation at angle zero, the one at the pose of the reduction. `mass` (n,) in kg,
    `inertia` (n,) about n in kg m², `gravity` (2,) along e1 and e2 in m/s². `joints`: the rows that act in the plane.

    `coordinates`: the joints' coordinates that can change; their `source` refers to the system's. `constant` (c,): the
    indices of the coordinates that cannot change.
    """

    axes: Array
    depth: Array
    reference: Array
    mass: Array
    inertia: Array
    gravity: Array
    joints: PlanarSet
    coordinates: PlanarSet
    constant: Integers

    def reduce(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Return p (..., 3n), that is (x, y, θ) of each body with θ in (-2π, 2π], and u = p', from q and v = q' (...,
        7n).

        Components of q and v out of the plane are dropped, and so is the length of Λ. The opposite sign of Λ gives a θ
        that differs by one turn.
        """
        rows, rates = q.reshape(*q.shape[:-1], -1, 7), v.reshape(*v.shape[:-1], -1, 7)
        orientation = rows[..., 3:]
        cosine, sine = ((orientation * across).sum(axis=-1) for across in (self.reference, self._opposite))
        angle = 2.0 * np.arctan2(sine, cosine)
        p, u = (np.empty((*each.shape[:-1], 3), like=each) for each in (rows, rates))
        p[..., :2], u[..., :2] = rows[..., :3] @ self.axes[:, :2], rates[..., :3] @ self.axes[:, :2]
        p[..., 2] = np.where(angle <= -2.0 * np.pi, 2.0 * np.pi, angle)
        quarter = orientation @ self._half_turn.T
        u[..., 2] = 2.0 * (rates[..., 3:] * quarter).sum(axis=-1) / (orientation * orientation).sum(axis=-1)
        return p.reshape(*q.shape[:-1], -1), u.reshape(*v.shape[:-1], -1)

    def expand(self, p: Array, u: Array, u_dot: Array) -> tuple[Array, Array, Array]:
        """Return q, q' and q'' (..., 7n) from p, u = p' and u' = p'' (..., 3n)."""
        return *self.expanded(p, u), self.expanded_rate(p, u, u_dot)

    def expanded(self, p: Array, u: Array) -> tuple[Array, Array]:
        """Return q and q' (..., 7n) from p and u = p' (..., 3n), with the last axis outermost in memory.

        Λ = (cos θ/2, n sin θ/2) Λ_reference is a unit and continuous in θ, and has a period of two turns.
        """
        x, x_dot = _by_body(p), _by_body(u)
        (flat_q, q), (flat_v, v) = self._in_space(x), self._in_space(x_dot)
        q[..., :3] += self.depth[:, None] * self.axes[:, 2]
        spin = 0.5 * x_dot[..., 2]
        with may_overflow():
            for place, orientation, quarter in self._turned(x[..., 2]):
                q[..., place], v[..., place] = orientation, spin * quarter
        return flat_q, flat_v

    def expanded_rate(self, p: Array, u: Array, u_dot: Array) -> Array:
        """Return q'' (..., 7n) from p, u = p' and u' (..., 3n), in memory as `expanded`."""
        x, x_dot, x_ddot = _by_body(p), _by_body(u), _by_body(u_dot)
        flat, acceleration = self._in_space(x_ddot)
        spin, change = 0.5 * x_dot[..., 2], 0.5 * x_ddot[..., 2]
        with may_overflow():
            square = spin**2
            for place, orientation, quarter in self._turned(x[..., 2]):
                acceleration[..., place] = change * quarter - square * orientation
        return flat

    def _in_space(self, part: Array) -> tuple[Array, Array]:
        """Return vectors of length 7n, and the same by bodies (..., n, 7), whose first three numbers are those of
        planar vectors (..., n, 3)."""
        flat = np.empty((*part.shape[:-2], 7 * len(self.mass)), order="F", like=part)
        whole = flat.reshape(*part.shape[:-2], -1, 7)
        for axis, (along_x, along_y) in enumerate(self.axes[:, :2]):  # round-off of `@` depends on lengths
            whole[..., axis] = along_x * part[..., 0] + along_y * part[..., 1]
        return flat, whole

    def _turned(self, angle: Array) -> Iterator[tuple[int, Array, Array]]:
        """The components of Λ at angles (..., n), and of (0, n) Λ: the rate of Λ is ½ ω times this. Each comes with its
        place among the seven numbers of a body."""
        half = 0.5 * angle
        cosine, sine = np.cos(half), np.sin(half)
        for at in range(4):
            here, opposite = self.reference[:, at], self._opposite[:, at]
            yield 3 + at, cosine * here + sine * opposite, cosine * opposite - sine * here

    @cached_property
    def rows(self) -> Integers:
        """For each row in the plane one row of the system that it comes from, (m,)."""
        source = self.joints.source
        return source.source[np.searchsorted(source.row, np.arange(source.size))]

    @cached_property
    def _half_turn(self) -> Array:
        """The matrix (4, 4) of the product (0, n) Λ: it turns Λ by 180 degrees about n."""
        return product(numbers([0.0, *self.axes[:, 2]]), np.eye(4)).T

    @cached_property
    def _opposite(self) -> Array:
        """The reference orientations, turned by 180 degrees about n."""
        return self.reference @ self._half_turn.T


def _by_body(flat: Array) -> Array:
    """Return planar vectors (..., 3n) by bodies, (..., n, 3), with the first axis innermost in memory."""
    return np.asfortranarray(flat, like=flat).reshape(*flat.shape[:-1], -1, 3)
