"""The equations of motion M u' + Gᵀλ = f + B p on the tangent space, solved for the forces p of actuators.

With a null space matrix N of G, NᵀB p = Nᵀ(M u' - f). The constraint forces drop out, and constraints may be redundant.
Of all solutions p the one with the least Σ w p² is taken. Where the actuators are as many as the freedoms, there is
only one.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.derivatives.linear_equations import MotionAtTime, tangent_force
from mbproj.dynamics.derivatives.row_derivatives import rows_at
from mbproj.dynamics.derivatives.tangent_space import TangentSpace, tangent_space
from mbproj.dynamics.equations.constraint_equations import set_bias, set_velocity
from mbproj.dynamics.equations.forces import applied
from mbproj.dynamics.equations.kinematics import body_rates
from mbproj.errors import InputError, Place, Problem
from mbproj.model.contacts import Contacts, in_contact
from mbproj.model.system import System
from mbproj.studies.inverse.actuators import Actuators
from mbproj.thresholds import THRESHOLDS

#: Actuators move nothing along singular vectors of NᵀB with singular values below this part of its largest column.
DEAD = 1e-8
#: The part of the largest force up to which a missing force is round-off. A freedom with a larger one lacks an
#: actuator.
MISSING = 1e-7


@dataclass(frozen=True, eq=False)
class PowerBalance:
    """The forces (T, k) of actuators, and the rates (T, k) along which they act. `off` (T,) is the error of the power
    balance over the largest power in it. `dead` (T,) tells where the actuators cannot move the mechanism; forces are
    NaN there. `freedom` is the mechanism's number of freedoms, `rank` the number that the actuators reach."""

    force: Array
    rate: Array
    off: Array
    dead: Array
    freedom: int
    rank: int


@dataclass(frozen=True, eq=False)
class _Sample:
    force: Array
    rate: Array
    gained: Array
    left: float
    size: float
    rank: int
    space: TangentSpace
    reached: Array


def balance(actuators: Actuators, motions: Sequence[MotionAtTime]) -> PowerBalance:
    """Compute the forces along a motion. Raises InputError where a freedom needs a force and has no actuator."""
    rubbing = SlidingFrictions(actuators.system, motions)
    samples = [_at(replace(actuators, system=rubbing.at(motion)), motion) for motion in motions]
    rank, freedom = max(sample.rank for sample in samples), samples[0].space.freedom
    size = max(sample.size for sample in samples)
    dead = np.array([sample.rank < rank and sample.left > MISSING * sample.size for sample in samples])
    missing = [sample.left if not gone else 0.0 for sample, gone in zip(samples, dead, strict=True)]
    if max(missing) > MISSING * size:
        raise _refused(actuators.system, samples[int(np.argmax(missing))], motions[-1], rank)
    force = np.array([sample.force for sample in samples])
    rate = np.array([sample.rate for sample in samples])
    force[dead] = np.nan
    gained = np.array([sample.gained for sample in samples])
    put_in = np.where(dead, gained.sum(axis=1), np.sum(force * rate, axis=1))
    largest = max(float(np.abs(gained).max(initial=0.0)), float(np.abs(force * rate)[~dead].max(initial=0.0)))
    off = np.abs(gained.sum(axis=1) - put_in) / (largest or 1.0)
    return PowerBalance(force, rate, off, dead, freedom, rank)


def _at(actuators: Actuators, motion: MotionAtTime) -> _Sample:
    system = actuators.system
    space = tangent_space(system, rows_at(system.rows, motion.pose).dense())
    B, own = actuators.columns(motion)
    weights = np.sqrt(actuators.weights)
    A = (space.N.T @ B) / weights
    wanted = -(space.N.T @ (tangent_force(system, motion) - B @ own))
    U, σ, V = np.linalg.svd(A, full_matrices=False)
    alone = np.linalg.norm(space.lengths[:, None] * B, axis=0) / weights
    rank = int(np.count_nonzero(σ > DEAD * alone.max(initial=0.0)))
    reached = U[:, :rank]
    force = V[:rank].T @ ((reached.T @ wanted) / σ[:rank]) / weights
    left = wanted - A @ (weights * force)
    size = _size(system, motion)
    gained = _power_terms(system, motion, own, B)
    return _Sample(force, B.T @ motion.u, gained, float(np.linalg.norm(left)), size, rank, space, reached)


def _size(system: System, motion: MotionAtTime) -> float:
    """The largest inertial, gravitational or applied force on a body at a sample, N m; forces count at the mechanism's
    length."""
    loads, u_dot = applied(motion.instant(system)), motion.change.reshape(-1, 6)
    inertia = system.mass[:, None] * u_dot[:, :3], (system.inertia @ u_dot[:, 3:, None])[..., 0]
    weight = system.mass[:, None] * system.gravity
    lengths = [inertia[0], weight, loads.force[:-1]]
    turns = [inertia[1], loads.torque[:-1]]
    largest = [system.length * float(np.abs(part).max(initial=0.0)) for part in lengths]
    return max(*largest, *(float(np.abs(part).max(initial=0.0)) for part in turns), float(np.finfo(float).tiny))


def _power_terms(system: System, motion: MotionAtTime, own: Array, B: Array) -> Array:
    """The terms of the power that the actuators supply, W: the changes of kinetic energy by translation, rotation and
    reflected inertias, and the negative powers of gravity and of the scene's other forces. It does not use the tangent
    space."""
    pose = motion.pose
    twist, change = motion.twist(pose), motion.change_of(pose)
    velocity, ω = twist.velocity[:-1], body_rates(pose, twist)[:-1]
    u_dot, loads = motion.change.reshape(-1, 6), applied(motion.instant(system))
    turning = (system.inertia @ u_dot[:, 3:, None])[..., 0]
    rows = system.reflected.rows
    rate = set_velocity(rows, pose, twist)
    faster = set_velocity(rows, pose, change) + set_bias(rows, pose, twist)
    others = np.sum(loads.force * twist.velocity) + np.sum(loads.torque[:-1] * ω)
    return np.array(
        [
            np.sum(system.mass[:, None] * velocity * u_dot[:, :3]),
            np.sum(ω * turning),
            np.sum(system.reflected.inertia * rate * faster),
            -np.sum(system.mass[:, None] * velocity * system.gravity),
            -(others - own @ (B.T @ motion.u)),
        ]
    )


def _refused(system: System, sample: _Sample, motion: MotionAtTime, rank: int) -> InputError:
    """The error for a freedom without an actuator. It names the joint coordinates that move most along such
    freedoms."""
    space = sample.space
    beyond = np.eye(space.freedom) - sample.reached @ sample.reached.T
    G = rows_at(system.coordinates, motion.pose).dense() @ space.N @ beyond
    lengths = np.array([unit == "m" for unit in system.names.coordinate_units], dtype=bool)
    moved = np.linalg.norm(G / np.where(lengths, system.length, 1.0)[:, None], axis=1)
    most = np.argsort(-moved, kind="stable")[: max(1, space.freedom - rank)]
    names = [f"'{system.names.coordinates[k]}'" for k in most if moved[k] > 0.0]
    message = (
        f"the actuators reach {rank} of {space.freedom} degrees of freedom, and the motion needs forces along the "
        f"{'other' if space.freedom - rank == 1 else 'others'}"
    )
    hint = f"add an actuator, along {' and '.join(names)} say" if names else "add an actuator"
    return InputError(Problem(message, Place("--actuator"), hint))


class SlidingFrictions:
    """A system whose dry frictions act as sliding laws, cached by their directions of sliding."""

    def __init__(self, system: System, motions: Iterable[MotionAtTime]) -> None:
        self._system, self._by_directions = system, dict[tuple[float, ...], System]()
        self._fastest = 0.0 if system.frictions is None else max(_speed(system, each) for each in motions)

    def at(self, motion: MotionAtTime) -> System:
        """The system at a sample of the motion, with each friction sliding in its direction there."""
        frictions = self._system.frictions
        if frictions is None:
            return self._system
        rate = set_velocity(frictions.coordinates, motion.pose, motion.twist(motion.pose))
        size = np.where(frictions.coordinates.is_length, self._system.length, 1.0)
        moves = np.abs(rate) > THRESHOLDS.stop_rests * self._fastest * size
        directions = tuple(np.where(moves, np.sign(rate), 0.0).tolist())
        if directions not in self._by_directions:
            sliding = {k: direction for k, direction in enumerate(directions) if direction}
            self._by_directions[directions] = in_contact(self._system, Contacts(sliding=sliding))
        return self._by_directions[directions]


def _speed(system: System, motion: MotionAtTime) -> float:
    """The speed of the fastest part of the mechanism, in its lengths and rad per s."""
    twist = motion.twist(motion.pose)
    return float(np.abs(twist.velocity).max() / system.length + np.abs(body_rates(motion.pose, twist)).max())
