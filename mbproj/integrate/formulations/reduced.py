"""Reduced coordinates: r, Λ, r' and ω in body axes, 6 degrees of freedom a body."""

from __future__ import annotations

from typing import Any

import numpy as np

from mbproj.arrays import Array, Integers, contiguous, numbers
from mbproj.dynamics.observe.samples import Samples
from mbproj.integrate.formulations.compiled import Compiled, Recorded
from mbproj.kernel.models import joints_with_rows, space_record
from mbproj.model.euler_parameters import matrix_L
from mbproj.model.layout import Block, Layout, uncontrolled
from mbproj.model.system import System


class Reduced(Compiled):
    """A system in the kernel's spatial coordinates."""

    name = "reduced"
    dimension = "Space"

    def __init__(self, core: Any, system: System) -> None:
        def record() -> Recorded:
            of_a_body = numbers([system.length] * 3 + [1.0] * 4 + [system.length] * 3 + [1.0] * 3)
            layout = layout_in_bodies(system, of_a_body, system.coordinates.size)
            return Recorded(layout, joints_with_rows(system.joints.owner), space_record(core, system, layout))

        super().__init__(core, system, system.kept("record in space", (core,), record))

    def with_system(self, system: System, whole: System | None = None) -> Reduced:
        copy = Reduced(self.core, system)
        copy.model.rows = self.model.rows
        return copy

    @property
    def degrees_of_freedom(self) -> int:
        return 7 * self.system.bodies - self.system.constraints + int(self.model.rows.redundant)

    @property
    def row_scale(self) -> Array:
        return self.system.row_scale[self.system.bodies :]

    def state(self, q: Array, v: Array) -> Array:
        return space_state(q, v)

    def motion(self, bodies: Array) -> tuple[Array, Array]:
        return space_motion(bodies)

    def acceleration(self, bodies: Array, acceleration: Array) -> Array:
        return space_acceleration(bodies, acceleration)

    def rigid_fields(self, q: Array) -> Array:
        from mbproj.dynamics.symmetries import rigid_fields

        return rigid_fields(q)

    def multipliers(self, samples: Samples, forces: Array | None = None) -> Array:
        """Return λ of all rows; the smallest where redundant rows leave reactions undetermined."""
        if not self.model.rows.redundant:
            return samples.carried
        bodies = contiguous(space_state(samples.q, samples.v))
        spread: Array = self.equations().spread(bodies, samples.t, samples.carried)
        return spread

    def turns(self, turns: Integers) -> Integers:
        return turns

    def of_all(self, kept: Array) -> Array:
        return kept

    def row(self, number: int) -> int:
        return self.system.bodies + number

    def coordinate(self, number: int) -> int:
        return number


def space_state(q: Array, v: Array) -> Array:
    """Return (r, Λ, r', ω in body axes) of each body, (..., n, 13), from q and v = q' (..., 7n)."""
    at, rate = (part.reshape(*part.shape[:-1], -1, 7) for part in (q, v))
    omega = 2.0 * (matrix_L(at[..., 3:]) @ rate[..., 3:, None])[..., 0]
    return np.concatenate([at, rate[..., :3], omega], axis=-1)


def space_motion(bodies: Array) -> tuple[Array, Array]:
    """Return q and q' (T, 7n) from states (T, n, 13): Λ' = ½ Lᵀω."""
    rate = (_half_transposed(bodies) @ bodies[..., 10:13, None])[..., 0]
    v = np.concatenate([bodies[..., 7:10], rate], axis=-1)
    return bodies[..., :7].reshape(len(bodies), -1), v.reshape(len(bodies), -1)


def space_acceleration(bodies: Array, acceleration: Array) -> Array:
    """Return q'' (T, 7n) from states (T, n, 13) and accelerations (r'', ω' in body axes) (T, n, 6): Λ'' = ½ Lᵀω' -
    ¼ |ω|² Λ."""
    orientation, omega = bodies[..., 3:7], bodies[..., 10:13]
    bend = (_half_transposed(bodies) @ acceleration[..., 3:, None])[..., 0]
    bend -= 0.25 * np.sum(omega * omega, axis=-1, keepdims=True) * orientation
    return np.concatenate([acceleration[..., :3], bend], axis=-1).reshape(len(bodies), -1)


def _half_transposed(bodies: Array) -> Array:
    """Return ½ Lᵀ of each body, (T, n, 4, 3)."""
    half: Array = 0.5 * np.swapaxes(matrix_L(bodies[..., 3:7]), -1, -2)
    return half


def layout_in_bodies(system: System, of_a_body: Array, coordinates: int) -> Layout:
    """Return the layout of a vector that begins with the positions and velocities of each body. `of_a_body`: the scales
    of a body's numbers for the absolute tolerance. `coordinates`: the number of joint coordinates to follow."""
    bodies = Block("bodies", np.concatenate([of_a_body] * system.bodies), projected=True)
    *_, states, quadratures, followed = system.integrated.blocks
    return Layout((bodies, states, quadratures, uncontrolled("followed", coordinates if followed.size else 0)))
