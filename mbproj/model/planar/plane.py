"""A planar mechanism: three coordinates a body, x, y and θ, and the conversions from and to seven."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from mbproj.arrays import Array, Integers, may_overflow, numbers
from mbproj.dataclass import dataclass
from mbproj.model.euler_parameters import product
from mbproj.model.planar.planar_set import PlanarSet


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
