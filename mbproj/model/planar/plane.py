"""A planar mechanism: three coordinates a body, x, y and θ, and the conversions from and to seven."""

from __future__ import annotations

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
        """Return q, q' and q'' (..., 7n) from p, u = p' and u' = p'' (..., 3n).

        Λ = (cos θ/2, n sin θ/2) Λ_reference is a unit and continuous in θ, and has a period of two turns.
        """
        x, x_dot, x_ddot = (part.reshape(*part.shape[:-1], -1, 3) for part in (p, u, u_dot))
        half, spin, change = 0.5 * x[..., 2:], 0.5 * x_dot[..., 2:], 0.5 * x_ddot[..., 2:]
        cosine, sine = np.cos(half), np.sin(half)
        flat = [np.empty((*p.shape[:-1], 7 * len(self.mass)), order="F", like=p) for _ in range(3)]
        q, v, acceleration = (part.reshape(*p.shape[:-1], -1, 7) for part in flat)
        for whole, part in ((q, x), (v, x_dot), (acceleration, x_ddot)):
            for axis, (along_x, along_y) in enumerate(self.axes[:, :2]):  # round-off of `@` depends on lengths
                whole[..., axis] = along_x * part[..., 0] + along_y * part[..., 1]
        q[..., :3] += self.depth[:, None] * self.axes[:, 2]
        orientation = cosine * self.reference + sine * self._opposite
        quarter = cosine * self._opposite - sine * self.reference  # (0, n) Λ: the rate of Λ is ½ ω times this
        q[..., 3:] = orientation
        with may_overflow():
            v[..., 3:] = spin * quarter
            acceleration[..., 3:] = change * quarter - spin**2 * orientation
        return flat[0], flat[1], flat[2]

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
