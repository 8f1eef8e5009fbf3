"""A planar mechanism: three coordinates a body, x, y and θ, and the way there and back."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.model.euler_parameters import matrix_E, product
from mbproj.model.planar.planar_set import PlanarSet


@dataclass(frozen=True, eq=False)
class Plane:
    """A planar mechanism of n bodies.

    `axes` (3, 3): columns e1, e2 and the normal n, right-handed. `depth` (n,): n·r of each body in m, which does not
    change. `reference` (n, 4): the orientation at angle zero, the one at the pose of the reduction. `mass` (n,) in kg,
    `inertia` (n,) about n in kg m², `gravity` (2,) along e1 and e2 in m/s². `joints`: the rows that act in the plane.
    `coordinates`: the joints' coordinates that can change, by its `source` the rows of the system's; `constant` (c,):
    the indices of those that cannot, `constant_value` (c,) in m or rad.
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
    constant_value: Array

    def reduce(self, q: Array, v: Array) -> tuple[Array, Array]:
        """p (..., 3n), holding (x, y, θ) a body with θ in (-π, π], and u = p', from q and v = q' (..., 7n).

        What q and v have out of the plane is dropped; neither sign nor length of Λ matters.
        """
        rows, rates = q.reshape(*q.shape[:-1], -1, 7), v.reshape(*v.shape[:-1], -1, 7)
        orientation, normal = rows[..., 3:], self.axes[:, 2]
        turn = product(orientation, self.reference * [1.0, -1.0, -1.0, -1.0])
        cosine, sine = turn[..., 0], turn[..., 1:] @ normal
        sign = np.where(cosine < 0.0, -1.0, 1.0)
        angle = 2.0 * np.arctan2(sign * sine, sign * cosine)
        angle = np.where(angle <= -np.pi, np.pi, angle)
        spin = 2.0 * (matrix_E(orientation) @ rates[..., 3:, None])[..., 0] @ normal
        spin = spin / np.sum(orientation * orientation, axis=-1)
        p = np.concatenate([rows[..., :3] @ self.axes[:, :2], angle[..., None]], axis=-1)
        u = np.concatenate([rates[..., :3] @ self.axes[:, :2], spin[..., None]], axis=-1)
        return p.reshape(*q.shape[:-1], -1), u.reshape(*v.shape[:-1], -1)

    def expand(self, p: Array, u: Array, u_dot: Array) -> tuple[Array, Array, Array]:
        """q, q' and q'' (..., 7n) of p, u = p' and u' = p'' (..., 3n).

        Λ = (cos θ/2, n sin θ/2) Λ_reference is a unit and continuous in θ; where θ jumps by 2π, Λ changes its sign.
        """
        x, x_dot, x_ddot = (part.reshape(*part.shape[:-1], -1, 3) for part in (p, u, u_dot))
        half, spin, change = 0.5 * x[..., 2:], x_dot[..., 2:], x_ddot[..., 2:]
        cosine, sine = np.cos(half), np.sin(half)
        turned = product(np.array([0.0, *self.axes[:, 2]]), self.reference)  # by 180 degrees about n
        orientation = cosine * self.reference + sine * turned
        quarter = cosine * turned - sine * self.reference  # (0, n) Λ: the rate of Λ is ½ ω times that
        parts = (
            (self._in_space(x) + self.depth[:, None] * self.axes[:, 2], orientation),
            (self._in_space(x_dot), 0.5 * spin * quarter),
            (self._in_space(x_ddot), 0.5 * change * quarter - 0.25 * spin**2 * orientation),
        )
        q, v, acceleration = (np.concatenate(part, axis=-1).reshape(*p.shape[:-1], -1) for part in parts)
        return q, v, acceleration

    def _in_space(self, x: Array) -> Array:
        """The vectors (..., 3) with these components (..., 3) along the axes, the last of which is an angle."""
        return x[..., :1] * self.axes[:, 0] + x[..., 1:2] * self.axes[:, 1]
