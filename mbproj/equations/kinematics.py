"""Poses and velocities of the bodies from q and q': rotation matrices, and points and vectors fixed in the bodies.

q holds (r, Λ) per body (Eq. 1), 7n numbers; leading axes (samples in time) are free. The ground is appended as body n.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.model.euler_parameters import E_times_L, matrix_L, rotation_matrix, turning
from mbproj.model.primitive_set import PrimitiveSet

_GROUND = np.array([[0.0, 0, 0, 1, 0, 0, 0]])


@dataclass(frozen=True, eq=False)
class Pose:
    """Position (..., n+1, 3) and Euler parameters (..., n+1, 4). Derived quantities are computed on first use: energies
    need no A."""

    position: Numbers
    orientation: Numbers

    @cached_property
    def L(self) -> Numbers:
        """L of each body, (..., n+1, 3, 4)."""
        return matrix_L(self.orientation)

    @cached_property
    def rotation(self) -> Numbers:
        """A = E Lᵀ of each body, (..., n+1, 3, 3)."""
        return rotation_matrix(self.orientation)

    @cached_property
    def _places(self) -> dict[PrimitiveSet, Numbers]:
        return {}

    def places(self, bound: PrimitiveSet) -> Numbers:
        """Return the global points and vectors of a set, (..., S, 3). They are cached, because C, C' and C'' use
        them."""
        if bound not in self._places:
            self._places[bound] = attached(self, *slots_of(bound))
        return self._places[bound]


@dataclass(frozen=True, eq=False)
class Twist:
    """r' (..., n+1, 3) and Λ' (..., n+1, 4) at bodies with Euler parameters `orientation`. Derived quantities are
    computed on first use: energies need no A'."""

    velocity: Numbers
    rate: Numbers
    orientation: Numbers

    @cached_property
    def rotation_dot(self) -> Numbers:
        """A' = 2 E L'ᵀ, (..., n+1, 3, 3)."""
        return 2.0 * E_times_L(self.orientation, self.rate)

    @cached_property
    def rotation_bias(self) -> Numbers:
        """The part 2 E' L'ᵀ of A'' that has no Λ'', (..., n+1, 3, 3)."""
        return 2.0 * E_times_L(self.rate, self.rate)

    @cached_property
    def _rates(self) -> dict[PrimitiveSet, Numbers]:
        return {}

    def rates(self, bound: PrimitiveSet) -> Numbers:
        """Return the velocities of a set's points and vectors, (..., S, 3)."""
        if bound not in self._rates:
            self._rates[bound] = attached_velocity(self, *slots_of(bound))
        return self._rates[bound]


def pose_of(q: Numbers) -> Pose:
    """Return the pose of every body and of the ground from q (..., 7n)."""
    rows = _by_body(q, _GROUND)
    return Pose(rows[..., :3], rows[..., 3:])


def twist_of(pose: Pose, v: Numbers) -> Twist:
    """Return the velocity of every body from its pose and v = q' (..., 7n)."""
    rows = _by_body(v, np.zeros((1, 7)))
    return Twist(velocity=rows[..., :3], rate=rows[..., 3:], orientation=pose.orientation)


def attached(pose: Pose, body: Integers, local: Array, is_point: Array) -> Numbers:
    """Return global points r + A s (where `is_point` is 1) and vectors A s (where 0), (..., S, 3)."""
    return _rotated(pose.rotation, body, local) + is_point[:, None] * pose.position[..., body, :]


def attached_velocity(twist: Twist, body: Integers, local: Array, is_point: Array) -> Numbers:
    """Return the velocities of points and vectors, (..., S, 3)."""
    return _rotated(twist.rotation_dot, body, local) + is_point[:, None] * twist.velocity[..., body, :]


def attached_bias(twist: Twist, body: Integers, local: Array) -> Numbers:
    """Return the part of the accelerations of points and vectors without q'', (..., S, 3)."""
    return _rotated(twist.rotation_bias, body, local)


def slots_of(bound: PrimitiveSet) -> tuple[Integers, Array, Array]:
    """Return a set's attachments as the arguments of `attached`."""
    return bound.body, bound.local, bound.is_point


def body_rates(pose: Pose, twist: Twist) -> Numbers:
    """Return angular velocities ω = 2 L Λ' in body axes, (..., n+1, 3) (Eq. 16)."""
    return turning(pose.orientation, twist.rate)


def _rotated(matrices: Numbers, body: Integers, local: Array) -> Numbers:
    """Return the products of bodies' matrices and their vectors, column by column: over many samples several times
    faster than a product of stacks."""
    if not local.any():
        return np.zeros((*matrices.shape[:-3], *local.shape), dtype=matrices.dtype, order="F")
    first, second, third = (matrices[..., column][..., body, :] * local[:, column, None] for column in range(3))
    first += second
    first += third
    return first


def _by_body(flat: Numbers, ground: Array) -> Numbers:
    rows = flat.reshape(*flat.shape[:-1], -1, 7)
    return np.concatenate([rows, np.broadcast_to(ground, (*rows.shape[:-2], 1, 7))], axis=-2)
