"""The forces of a mechanism at rest, or in a steady turn, at one pose: what the constraints leave of them, and how that
changes along the tangent space."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Protocol

import numpy as np

from mbproj.arrays import Array, Numbers, cross
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import coordinate_values, nearest
from mbproj.dynamics.blocks import Rows, added, stacked
from mbproj.dynamics.derivatives.linear_equations import (
    LinearEquations,
    MotionAtTime,
    constraint_rows,
    linear_equations,
    tangent_force,
)
from mbproj.dynamics.derivatives.row_derivatives import force_derivative, row_motion, rows_at
from mbproj.dynamics.derivatives.tangent import moved, velocities
from mbproj.dynamics.derivatives.tangent_space import TangentSpace
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.equations.motions import Drive
from mbproj.dynamics.equations.teeth import near
from mbproj.errors import SimulationError
from mbproj.linear.bordered import tangent_space_of
from mbproj.linear.reduction.frames import in_axes
from mbproj.linear.reference import largest_force
from mbproj.model.system import Conditions, System
from mbproj.thresholds import THRESHOLDS

AT_REST = np.zeros(3)


@dataclass(frozen=True, eq=False)
class Turning:
    """A steady turn: Ω (3,) in rad/s about an axis through `point` (3,) in m. Every body turns with it."""

    rate: Array
    point: Array

    def motion(self, t: float, q: Array, expected: Array, x: Array) -> MotionAtTime:
        """The bodies' velocities and accelerations in it, with the states x of elements."""
        pose = pose_of(q)
        velocity = cross(self.rate, pose.position[:-1] - self.point)
        spin = (np.swapaxes(pose.rotation[:-1], -1, -2) @ self.rate[:, None])[..., 0]
        change = np.concatenate([cross(self.rate, velocity), np.zeros_like(velocity)], axis=1)
        return MotionAtTime(t, q, np.concatenate([velocity, spin], axis=1).ravel(), change.ravel(), expected, x)


REST = Turning(AT_REST, AT_REST)


@dataclass(frozen=True, eq=False)
class Problem:
    """What is to be balanced: a system at time `t`, with its motions held where `drive` says. Joint coordinates that
    are `held` are rows of their own. `x` (K,) are the states of elements, `turning` says how it turns. `reach` (m): how
    far the mechanism goes. Shifts are measured beside it: beside the links of a long chain they would be so large that
    each step had to be a small one."""

    system: System
    t: float
    drive: Drive
    held: Conditions
    x: Array
    reach: float
    turning: Turning = REST

    @classmethod
    def of(
        cls,
        system: System,
        t: float,
        q: Array,
        drive: Drive,
        held: Conditions,
        x: Array,
        turning: Turning = REST,
    ) -> Problem:
        """As far as the mechanism reaches at a pose."""
        reach = max(system.length, float(np.ptp(pose_of(q).position[:-1], axis=0).max()))
        return cls(system, t, drive, held, x, reach, turning)

    @property
    def lengths(self) -> Array:
        """The units of tangent coordinates, (6n,)."""
        return np.tile([self.reach] * 3 + [1.0] * 3, self.system.bodies)

    def at(self, q: Array, expected: Array) -> Balance:
        """The forces at a closed pose; `expected` (nc,): the joints' coordinates near there, turns counted."""
        system, pose = self.system, pose_of(q)
        counted = np.asarray(near(system, coordinate_values(system, pose), expected), dtype=float)
        motion = self.turning.motion(self.t, q, counted, self.x)
        force = tangent_force(system, motion)
        held = row_motion(system.coordinates, motion.carried()).G.chosen(self.held.index)
        space = tangent_space_of(system, pose, *self._scaled(constraint_rows(system, motion), held), self.lengths)
        return Balance(self, motion, force, space, space.pseudoinverse.T @ force)

    def moved(self, q: Array, ξ: Array) -> Array:
        """The pose after a displacement (6n,) that the rows allow at q. What rolls goes a way without slip, in the same
        direction less what the rows resist of it: one long step would slip by its square."""
        if not self.system.rolls:
            return moved(q, ξ)
        size = float(np.abs(ξ / self.lengths).max(initial=0.0))
        parts = max(1, int(np.ceil(size / THRESHOLDS.short_way)))
        for _ in range(parts):
            k = [self._rate(q, ξ / parts)]
            for part in (0.5, 0.5, 1.0):
                k.append(self._rate(q + part * k[-1], ξ / parts))
            q = q + (k[0] + 2.0 * k[1] + 2.0 * k[2] + k[3]) / 6.0
        return q

    def _rate(self, q: Array, ξ: Array) -> Array:
        """The part of a displacement (6n,) that the rows allow at q, as a change of q."""
        pose = pose_of(q)
        own, held = rows_at(self.system.rows, pose), rows_at(self.system.coordinates, pose).chosen(self.held.index)
        N = tangent_space_of(self.system, pose, *self._scaled(own, held), self.lengths).N
        return velocities(pose, N @ (N.T @ (ξ / self.lengths**2)))

    def _scaled(self, rows: Rows, held: Rows) -> tuple[Rows, Array]:
        """The rows of joints and motions, and of what is held, with what each is measured against."""
        system = self.system
        scale = np.where(system.coordinates.is_length, system.length, 1.0)[self.held.index]
        return stacked(system.bodies, [rows, held]), np.concatenate([system.row_scale[system.bodies :], scale])

    def closed(self, q: Array) -> Array | None:
        """The closed pose next to q; None where it cannot be closed."""
        found, left = nearest(self.system.at_positions, q, self.held, self.drive, THRESHOLDS.closed_at_rest)
        return found if np.abs(left).max(initial=0.0) <= THRESHOLDS.assembled else None


class Left(Protocol):
    """What is asked of what is left of forces."""

    @property
    def relative(self) -> float:
        """What is left beside what acts."""

    @property
    def is_held(self) -> bool:
        """Whether nothing can move."""


class AnyBalance(Left, Protocol):
    """What is asked of forces at a pose, of small and of large mechanisms."""

    @property
    def problem(self) -> Problem:
        """What is to be balanced."""

    @property
    def motion(self) -> MotionAtTime:
        """The pose, and how it moves."""

    @property
    def force(self) -> Array:
        """The forces (6n,)."""

    @property
    def multipliers(self) -> Array:
        """Those that balance what they can."""

    @property
    def unbalanced(self) -> Array:
        """The displacement (6n,) along which the constraints leave the rest, as large as that."""

    @property
    def lengths(self) -> Array:
        """The units of tangent coordinates, (6n,)."""

    @property
    def largest(self) -> float:
        """The largest torque, or force times the length, that acts."""


def largest_acting(at: AnyBalance) -> float:
    """The largest torque, or force times the length, that acts at a pose."""
    acts = largest_force(at.problem.system, at.motion, at.force)
    return max(acts, float(np.abs(at.force * at.lengths).max(initial=0.0)))


@dataclass(frozen=True, eq=False)
class Balance:
    """The forces (6n,) at a pose and the tangent space there. The multipliers are those that balance what they can:
    first of the rows of joints and motions, then of what is held."""

    problem: Problem
    motion: MotionAtTime
    force: Array
    space: TangentSpace
    multipliers: Array

    @property
    def residual(self) -> Array:
        """What the constraints leave, along the tangent space, (f,), in units of a torque: forces times the length."""
        return self.space.N.T @ self.force

    @property
    def unbalanced(self) -> Array:
        """The displacement (6n,) along which the constraints leave the residual, as large as that."""
        return self.space.N @ self.residual

    @property
    def lengths(self) -> Array:
        """The units of tangent coordinates, (6n,)."""
        return self.space.lengths

    @property
    def is_held(self) -> bool:
        """Whether nothing can move."""
        return self.space.freedom == 0

    @cached_property
    def largest(self) -> float:
        """The largest torque, or force times the length, that acts."""
        return largest_acting(self)

    @property
    def relative(self) -> float:
        """The residual beside the largest force."""
        return float(np.linalg.norm(self.residual)) / max(self.largest, float(np.finfo(float).tiny))

    @cached_property
    def stiffness(self) -> tuple[Array, Array]:
        """K on the tangent space, (f, f), and what its terms sum up to without their signs."""
        equations, in_global = self.linear
        size, K = np.abs(in_global), equations.K.matrix()
        return in_global.T @ (K @ in_global), size.T @ (np.abs(K) @ size)

    @cached_property
    def linear(self) -> tuple[LinearEquations, Array]:
        """The linear equations in the axes of the turn, and the tangent space in them, (6n, f)."""
        problem = self.problem
        rows = problem.system.constraints - problem.system.bodies
        system, motion = problem.system, self.motion
        equations = linear_equations(system, motion, self.multipliers[:rows])
        held = np.zeros(system.coordinates.size)
        held[problem.held.index] = self.multipliers[rows:]
        bent = force_derivative(system.coordinates, motion.carried(), held)
        equations = replace(equations, K=added(system.bodies, [equations.K, bent]))
        turn = motion.pose.rotation[:-1]
        return in_axes(equations, motion, problem.turning.rate), _in_global(self.space.N, turn)

    def after(self, step: Array, x: Array | None = None) -> Balance | None:
        """The forces after a step (f,) along the tangent space and back to the constraints, and with other states of
        elements; None where they open, or a function has no value."""
        problem = self.problem if x is None else replace(self.problem, x=x)
        closed = problem.closed(problem.moved(self.motion.q, self.space.N @ step))
        if closed is None:
            return None
        try:
            there = problem.at(closed, self.motion.expected)
        except SimulationError:
            return None
        return there if np.all(np.isfinite(there.force)) else None


def _in_global(N: Array, turn: Array) -> Array:
    """N with small turns in global axes in place of body axes."""
    rows = N.reshape(len(turn), 6, -1).copy()
    rows[:, 3:] = turn @ rows[:, 3:]
    return rows.reshape(N.shape)


def way(first: MotionAtTime, last: MotionAtTime) -> Numbers:
    """The shift and the turn, in the axes of the first pose, of each body between two poses, (6n,)."""
    here, there = first.pose, last.pose
    shift = there.position[:-1] - here.position[:-1]
    sine = (here.L @ there.orientation[..., None])[:-1, :, 0]
    cosine = np.sum(here.orientation * there.orientation, axis=-1)[:-1]
    size = np.linalg.norm(sine, axis=1)
    angle = 2.0 * np.arctan2(size, np.abs(cosine)) * np.where(cosine < 0.0, -1.0, 1.0)
    turn = sine * (angle / np.where(size > 0.0, size, 1.0))[:, None]
    return np.concatenate([shift, turn], axis=1).ravel()
