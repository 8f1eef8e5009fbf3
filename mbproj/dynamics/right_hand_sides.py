"""What the rows of C ask of velocities and accelerations, and whether rows that depend on each other agree on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dynamics.assembly import State
from mbproj.dynamics.constraint_equations import gamma, jacobian, time_derivative
from mbproj.dynamics.kinematics import Pose, Twist, body_rates, pose_of, twist_of
from mbproj.dynamics.motions import Drive, drive_at
from mbproj.model.system import System

#: Right-hand sides agree to this part of what they are made of.
AGREE = 1e-9


@dataclass(frozen=True, eq=False)
class RightHandSides:
    """-C_t and γ of Eqs. 5 and 7 for the rows but the norm rows, (k,) each, in units of the length or rad, and how
    large they can be expected to be: `speed` per s, and its square."""

    velocity: Array
    acceleration: Array
    speed: float

    def disagreement(self, rows: Integers, weights: Array) -> tuple[float, float]:
        """Σ weight · side of rows whose weighted sum is 0 in C_q, for velocity and acceleration; round-off is 0."""
        found = []
        for side, least in ((self.velocity, self.speed), (self.acceleration, self.speed**2)):
            parts = weights * side[rows]
            off = abs(float(parts.sum()))
            round_off = AGREE * (float(np.abs(parts).sum()) + float(np.abs(weights).max()) * least)
            found.append(off if off > round_off else 0.0)
        return found[0], found[1]


def right_hand_sides(system: System, state: State) -> RightHandSides:
    """The right-hand sides at a state."""
    pose, n = pose_of(state.q), system.bodies
    twist, drive = twist_of(pose, state.v), drive_at(system, state.t)
    scale = system.row_scale[n:]
    velocity = -time_derivative(system, drive)[n:] / scale
    speeds = np.concatenate([(twist.velocity / system.length).ravel(), body_rates(pose, twist).ravel(), velocity])
    acceleration = tangent_gamma(system, pose, twist, drive) / scale
    return RightHandSides(velocity, acceleration, float(np.abs(speeds).max()))


def tangent_gamma(system: System, pose: Pose, twist: Twist, drive: Drive | None) -> Array:
    """γ of the rows but the norm rows, (k,), for accelerations in (r'', ω'): the part of Λ'' that keeps |Λ|, which the
    norm rows ask for, is -|Λ'|² Λ."""
    kept = np.zeros((system.bodies, 7))
    kept[:, 3:] = -np.sum(twist.rate[:-1] ** 2, axis=1, keepdims=True) * pose.orientation[:-1]
    rows = gamma(system, pose, twist, drive) - jacobian(system, pose) @ kept.ravel()
    return np.asarray(rows[system.bodies :], dtype=float)
