"""Reduced coordinates: r, Λ, r' and ω in body axes, 6 degrees of freedom a body."""

from __future__ import annotations

from typing import Any, final

import numpy as np

from mbproj.base.arrays import Array, Integers, contiguous, cross, numbers
from mbproj.equations.assembly.assemble import State, coordinate_values
from mbproj.equations.constraints import tangent_jacobian
from mbproj.equations.forces import applied
from mbproj.equations.kinematics import body_rates, pose_of, twist_of
from mbproj.equations.samples import Samples
from mbproj.kernel.models import joints_with_rows, plane_record, plane_row_scale, space_record
from mbproj.model.euler_parameters import matrix_L
from mbproj.model.layout import Block, Layout, uncontrolled
from mbproj.model.planar.plane import Plane
from mbproj.model.system import System
from mbproj.motion.formulations.compiled import Compiled, Recorded
from mbproj.motion.formulations.redundant_rows import count_redundant


class Reduced(Compiled):
    """A system in the kernel's spatial coordinates."""

    name = "reduced"
    dimension = "Space"

    def __init__(self, core: Any, system: System) -> None:
        def record() -> Recorded:
            of_a_body = numbers([system.length] * 3 + [1.0] * 4 + [system.length] * 3 + [1.0] * 3)
            layout = layout_in_bodies(system, of_a_body, system.coordinates.size)
            return Recorded(layout, joints_with_rows(system.joints.owner), space_record(core, system, layout))

        super().__init__(core, system, system.cached("record in space", (core,), record))

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
        from mbproj.equations.symmetries import rigid_fields

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

    def of_all(self, of_kernel: Array) -> Array:
        return of_kernel

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


# --- Planar coordinates -----------------------------------------------------------------------------------------------
# X, y and θ of each body. Reactions out of the plane take one spatial solution a sample.


@final
class InPlane(Compiled):
    """A system in the kernel's planar coordinates."""

    name = "planar"
    dimension = "Plane"

    def __init__(self, core: Any, system: System, plane: Plane) -> None:
        def record() -> Recorded:
            layout = layout_in_bodies(system, numbers([system.length, system.length, 1.0] * 2), plane.coordinates.size)
            return Recorded(layout, joints_with_rows(plane.joints.owner), plane_record(core, system, plane, layout))

        super().__init__(core, system, system.cached("planar record", (core, plane), record))
        self.plane: Plane = plane
        self._space: Any = None

    def with_system(self, system: System, whole: System | None = None) -> InPlane:
        copy = InPlane(self.core, system, self.plane)
        copy.model.rows = self.model.rows
        return copy

    @property
    def degrees_of_freedom(self) -> int:
        return 3 * self.system.bodies - self.plane.joints.size - self.system.driven + int(self.model.rows.redundant)

    @property
    def row_scale(self) -> Array:
        return plane_row_scale(self.system, self.plane)

    def state(self, q: Array, v: Array) -> Array:
        p, u = self.plane.reduce(q, v)
        return np.concatenate([part.reshape(*part.shape[:-1], -1, 3) for part in (p, u)], axis=-1)

    def motion(self, bodies: Array) -> tuple[Array, Array]:
        return self.plane.expanded(*_halves(bodies))

    def acceleration(self, bodies: Array, acceleration: Array) -> Array:
        return self.plane.expanded_rate(*_halves(bodies), acceleration.reshape(len(bodies), -1))

    def turns(self, turns: Integers) -> Integers:
        return turns[self.plane.coordinates.source.source]

    def of_all(self, of_kernel: Array) -> Array:
        values = np.zeros((*of_kernel.shape[:-1], self.system.coordinates.size), like=of_kernel)
        values[..., self.plane.coordinates.source.source] = of_kernel
        return values

    def row(self, number: int) -> int:
        beyond = number - len(self.plane.rows)
        return self.system.bodies + (int(self.plane.rows[number]) if beyond < 0 else self.system.joints.size + beyond)

    def coordinate(self, number: int) -> int:
        return int(self.plane.coordinates.source.source[number])

    def rigid_fields(self, q: Array) -> Array:
        p, _ = self.plane.reduce(q, np.zeros_like(q))
        at = p.reshape(-1, 3)
        moved = np.zeros((3, *at.shape))
        moved[0, :, 0] = moved[1, :, 1] = moved[2, :, 2] = 1.0
        moved[2, :, 0], moved[2, :, 1] = -at[:, 1], at[:, 0]
        rates = moved.reshape(3, -1)
        return self.plane.expanded(np.broadcast_to(p, rates.shape), rates)[1]

    def multipliers(self, samples: Samples, forces: Array | None = None) -> Array:
        """Return λ from one spatial solution a sample. Where rows out of the plane are redundant, it is the smallest λ
        that keeps the bodies on the motion in the plane."""
        times, q, v, x = samples.t, samples.q, samples.v, samples.x
        if not len(times):
            return np.empty((0, self.system.constraints - self.system.bodies))
        reference = coordinate_values(self.system, pose_of(q)) + 2.0 * np.pi * samples.turns
        if self._space is None:
            self._space = self._equations_in_space(samples.state(0))
        smallest: Array = self._space.smallest_multipliers(
            contiguous(space_state(q, v)), times, np.hstack([reference, x]), forces
        )
        for at in np.flatnonzero(np.isnan(smallest).any(axis=1)).tolist():
            along = None if forces is None else forces[at]
            smallest[at] = self._smallest(samples.state(int(at)), samples.acceleration[at], along)
        return smallest

    def _equations_in_space(self, state: State) -> Any:
        """Return the kernel's equations in space, without rows that are redundant there."""
        space = Reduced(self.core, self.system)
        count_redundant(space, state)
        return space.equations()

    def _smallest(self, state: State, a: Array, forces: Array | None) -> Array:
        """Return the smallest λ with Gᵀλ equal to the applied forces, and `forces` along stops and frictions, less the
        inertial forces of the motion with q'' = `a` (7n,)."""
        system, instant = self.system, state.instant(self.system)
        pose, twist = instant.pose, instant.twist
        G = tangent_jacobian(system.rows, pose)[:, :-1, :6]
        change = twist_of(pose, a)
        omega, spin_up = body_rates(pose, twist)[:-1], body_rates(pose, change)[:-1]
        momentum = (system.inertia @ omega[..., None])[..., 0]
        force = system.mass[:, None] * (system.gravity - change.velocity[:-1])
        torque = -(system.inertia @ spin_up[..., None])[..., 0] - cross(omega, momentum)
        from mbproj.equations.of_motion import inertial_reaction, pull_on_bodies

        loads, reaction = applied(instant), inertial_reaction(system.reflected, pose, twist, change)
        missing = np.concatenate([force + loads.force[:-1], torque + loads.torque[:-1]], axis=-1)
        missing += pull_on_bodies(system.reflected, pose, reaction)
        if forces is not None:
            rubbed = [contact.coordinates for contact in (system.stops, system.frictions) if contact is not None]
            along = np.concatenate([tangent_jacobian(coordinates, pose)[:, :-1, :6] for coordinates in rubbed])
            missing += np.tensordot(forces, along, axes=1)
        weighed = G.reshape(len(G), -1) / system.row_scale[system.bodies :, None]
        multipliers = np.linalg.lstsq(weighed.T, missing.ravel(), rcond=1e-11)[0] / system.row_scale[system.bodies :]
        return np.asarray(multipliers, dtype=float)


def _halves(bodies: Array) -> tuple[Array, Array]:
    """Return p and u = p' (T, 3n) of the kernel's states (T, n, 6)."""
    return bodies[..., :3].reshape(len(bodies), -1), bodies[..., 3:].reshape(len(bodies), -1)
