"""Right-hand sides of the rows of C for velocities and accelerations, and contradictions between dependent rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.constraint_equations import gamma, set_velocity, time_derivative
from mbproj.dynamics.equations.kinematics import Pose, Twist, body_rates, pose_of, twist_of
from mbproj.dynamics.equations.motions import Drive, drive_at
from mbproj.dynamics.rank.row_space import Dependence
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class RightHandSides:
    """-C_t and γ of Eqs. 5 and 7 for all rows but the norm rows, (k,) each, in units of the length or rad.

    `quadratic` is γ without -C_tt: it is quadratic in the bodies' velocities `moving`, (r' / length, ω), (n, 6).
    `speed` is the expected size of velocities, per s. `doubt` is the relative error of the velocities."""

    velocity: Array
    acceleration: Array
    quadratic: Array
    moving: Array
    speed: float
    doubt: float = 0.0

    def with_doubt(self, part: Dependence) -> RightHandSides:
        """Return the right-hand sides with the `doubt` of a component: the part of its velocities that its rows do not
        allow. The velocity of a component at rest is round-off, so that its doubt may be 1."""
        moving = self.moving[part.component.bodies].ravel()
        left = part.rows @ moving - self.velocity[part.component.rows] * part.scale
        wrong = np.abs(np.linalg.lstsq(part.rows, left, rcond=THRESHOLDS.dependent)[0]).max()
        return replace(self, doubt=float(wrong / max(np.abs(moving).max(), TINY)))

    def disagreement(self, rows: Integers, weights: Array, floor: float) -> tuple[float, float]:
        """Return Σ weight × right-hand side of rows with Σ weight × row = 0 in C_q, for velocity and acceleration;
        round-off counts as 0. Rows count as dependent up to the distance `floor`."""
        largest = float(np.abs(weights).max())
        quadratic = float(np.abs(weights * self.quadratic[rows]).sum()) + largest * self.speed**2
        return (
            _beyond_round_off(weights * self.velocity[rows], floor * largest * self.speed),
            _beyond_round_off(weights * self.acceleration[rows], (floor + 2.0 * self.doubt) * quadratic),
        )


def _beyond_round_off(parts: Array, round_off: float) -> float:
    """Return the size of a sum; 0 where it is round-off."""
    off = abs(float(parts.sum()))
    return off if off > round_off + THRESHOLDS.dependent * float(np.abs(parts).sum()) else 0.0


def right_hand_sides(system: System, state: State) -> RightHandSides:
    """Return the right-hand sides at a state."""
    pose, n = pose_of(state.q), system.bodies
    twist, drive = twist_of(pose, state.v), drive_at(system, state.t)
    scale = system.row_scale[n:]
    velocity = -time_derivative(system, drive)[n:] / scale
    moving = np.concatenate([twist.velocity / system.length, body_rates(pose, twist)], axis=1)[:n]
    steady = replace(drive, acceleration=np.zeros_like(drive.acceleration))
    return RightHandSides(
        velocity,
        acceleration=tangent_gamma(system, pose, twist, drive) / scale,
        quadratic=tangent_gamma(system, pose, twist, steady) / scale,
        moving=moving,
        speed=float(np.abs(np.concatenate([moving.ravel(), velocity])).max()),
    )


def tangent_gamma(system: System, pose: Pose, twist: Twist, drive: Drive) -> Array:
    """Return γ of all rows but the norm rows, (k,), for accelerations in (r'', ω'). The part of Λ'' that keeps |Λ|,
    which the norm rows require, is -|Λ'|² Λ."""
    kept = np.zeros((system.bodies, 7))
    kept[:, 3:] = -np.sum(twist.rate[:-1] ** 2, axis=1, keepdims=True) * pose.orientation[:-1]
    change = twist_of(pose, kept.ravel())
    right = gamma(system, pose, twist, drive)[system.bodies :] - set_velocity(system.rows, pose, change)
    return np.asarray(right, dtype=float)
