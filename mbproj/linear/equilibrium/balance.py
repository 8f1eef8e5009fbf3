"""The forces of a mechanism at rest, or in a steady turn, at one pose: the part that the constraints do not balance,
and its derivative along the tangent space."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Protocol

import numpy as np

from mbproj.base.arrays import Array, Numbers, cross
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import SimulationError
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import coordinate_values, nearest
from mbproj.equations.blocks import Rows, added, stacked
from mbproj.equations.constraints import EPSILON
from mbproj.equations.derivatives import (
    LinearEquations,
    MotionAtTime,
    constraint_rows,
    force_derivative,
    linear_equations,
    row_motion,
    rows_at,
    tangent_force,
)
from mbproj.equations.kinematics import pose_of
from mbproj.equations.motions import Drive
from mbproj.equations.tangent_space import TangentSpace, moved, velocities
from mbproj.equations.turning import near
from mbproj.linear.bordered import tangent_space_of
from mbproj.linear.reduction import in_axes
from mbproj.linear.reference import largest_force
from mbproj.model.system import Conditions, System

AT_REST = np.zeros(3)


@dataclass(frozen=True, eq=False)
class SteadyTurn:
    """A steady turn: Ω (3,) in rad/s about an axis through `point` (3,) in m. Every body turns with it."""

    rate: Array
    point: Array

    def motion(self, t: float, q: Array, expected: Array, x: Array) -> MotionAtTime:
        """Return the bodies' velocities and accelerations in the turn, with the states x of elements."""
        pose = pose_of(q)
        velocity = cross(self.rate, pose.position[:-1] - self.point)
        spin = (np.swapaxes(pose.rotation[:-1], -1, -2) @ self.rate[:, None])[..., 0]
        change = np.concatenate([cross(self.rate, velocity), np.zeros_like(velocity)], axis=1)
        return MotionAtTime(t, q, np.concatenate([velocity, spin], axis=1).ravel(), change.ravel(), expected, x)


REST = SteadyTurn(AT_REST, AT_REST)


@dataclass(frozen=True, eq=False)
class EquilibriumProblem:
    """A problem of equilibrium: a system at time `t`, whose motions are held at `drive`.

    Joint coordinates that are `held` are additional rows. `x` (K,) are the states of elements, `turning` the steady
    turn. `reach` (m) is the extent of the mechanism, by which shifts are scaled. In units of the link lengths of a long
    chain, shifts would be so large that each step had to be small."""

    system: System
    t: float
    drive: Drive
    held: Conditions
    x: Array
    reach: float
    turning: SteadyTurn = REST

    @classmethod
    def of(
        cls,
        system: System,
        t: float,
        q: Array,
        drive: Drive,
        held: Conditions,
        x: Array,
        turning: SteadyTurn = REST,
    ) -> EquilibriumProblem:
        """Return the problem with the extent of the mechanism at a pose."""
        reach = max(system.length, float(np.ptp(pose_of(q).position[:-1], axis=0).max()))
        return cls(system, t, drive, held, x, reach, turning)

    @property
    def lengths(self) -> Array:
        """The units of tangent coordinates, (6n,)."""
        return np.tile([self.reach] * 3 + [1.0] * 3, self.system.bodies)

    def at(self, q: Array, expected: Array) -> EquilibriumBalance:
        """Return the forces at a closed pose. `expected` (nc,): the joints' coordinates near there, with turns."""
        system, pose = self.system, pose_of(q)
        counted = np.asarray(near(system, coordinate_values(system, pose), expected), dtype=float)
        motion = self.turning.motion(self.t, q, counted, self.x)
        force = tangent_force(system, motion)
        held = row_motion(system.coordinates, motion.carried()).G.chosen(self.held.index)
        space = tangent_space_of(system, pose, *self._scaled(constraint_rows(system, motion), held), self.lengths)
        return EquilibriumBalance(self, motion, force, space, space.pseudoinverse.T @ force)

    def moved(self, q: Array, ξ: Array) -> Array:
        """Return the pose after a displacement (6n,) that the rows allow at q.

        With rolling the displacement is a path without slip, by short steps in its direction less the part that rows
        resist. One long step would slip by its square."""
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
        """Return the part of a displacement (6n,) that the rows allow at q, as a change of q."""
        pose = pose_of(q)
        rows, held = rows_at(self.system.rows, pose), rows_at(self.system.coordinates, pose).chosen(self.held.index)
        N = tangent_space_of(self.system, pose, *self._scaled(rows, held), self.lengths).N
        return velocities(pose, N @ (N.T @ (ξ / self.lengths**2)))

    def _scaled(self, rows: Rows, held: Rows) -> tuple[Rows, Array]:
        """Return the rows of joints and motions, and of held coordinates, with the scale of each."""
        system = self.system
        scale = np.where(system.coordinates.is_length, system.length, 1.0)[self.held.index]
        return stacked(system.bodies, [rows, held]), np.concatenate([system.row_scale[system.bodies :], scale])

    def closed_pose(self, q: Array) -> Array | None:
        """Return the closed pose next to q; None where it cannot be closed."""
        pose, left = nearest(self.system.at_positions, q, self.held, self.drive, THRESHOLDS.closed_grains * EPSILON)
        return pose if np.abs(left).max(initial=0.0) <= THRESHOLDS.assembled else None


class Unbalanced(Protocol):
    """Interface of the unbalanced part of forces."""

    @property
    def relative(self) -> float:
        """The unbalanced part relative to the largest force."""

    @property
    def is_held(self) -> bool:
        """Whether nothing can move."""


class AnyBalance(Unbalanced, Protocol):
    """Interface of the forces at a pose, for small and large mechanisms."""

    @property
    def problem(self) -> EquilibriumProblem:
        """The problem of equilibrium."""

    @property
    def motion(self) -> MotionAtTime:
        """The pose, and its motion."""

    @property
    def force(self) -> Array:
        """The forces (6n,)."""

    @property
    def multipliers(self) -> Array:
        """The multipliers that balance the forces as far as they can."""

    @property
    def unbalanced(self) -> Array:
        """The displacement (6n,) along which the forces are unbalanced, with their size."""

    @property
    def lengths(self) -> Array:
        """The units of tangent coordinates, (6n,)."""

    @property
    def largest(self) -> float:
        """The largest torque, or force times the length, that acts."""


def largest_acting(at: AnyBalance) -> float:
    """Return the largest torque, or force times the length, that acts at a pose."""
    acts = largest_force(at.problem.system, at.motion, at.force)
    return max(acts, float(np.abs(at.force * at.lengths).max(initial=0.0)))


@dataclass(frozen=True, eq=False)
class EquilibriumBalance:
    """The forces (6n,) at a pose and the tangent space there. `multipliers` balance the forces as far as they can:
    first those of the rows of joints and motions, then those of held coordinates."""

    problem: EquilibriumProblem
    motion: MotionAtTime
    force: Array
    space: TangentSpace
    multipliers: Array

    @property
    def residual(self) -> Array:
        """The forces along the tangent space, (f,), in units of a torque: forces times the length."""
        return self.space.N.T @ self.force

    @property
    def unbalanced(self) -> Array:
        """The displacement (6n,) along which the forces are unbalanced, as large as the residual."""
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
        """The residual relative to the largest force."""
        return float(np.linalg.norm(self.residual)) / max(self.largest, float(np.finfo(float).tiny))

    @cached_property
    def stiffness(self) -> tuple[Array, Array]:
        """K on the tangent space, (f, f), and the sum of its terms' absolute values."""
        equations, in_global = self.linear
        size, K = np.abs(in_global), equations.K.matrix()
        return in_global.T @ (K @ in_global), size.T @ (np.abs(K) @ size)

    @cached_property
    def linear(self) -> tuple[LinearEquations, Array]:
        """The linear equations in the axes of the turn, and the tangent space in these axes, (6n, f)."""
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

    def after(self, step: Array, x: Array | None = None) -> EquilibriumBalance | None:
        """Return the forces after a step (f,) along the tangent space and back to the constraints, with states x of
        elements if given. Return None where the constraints do not close, or a function has no value."""
        problem = self.problem if x is None else replace(self.problem, x=x)
        closed = problem.closed_pose(problem.moved(self.motion.q, self.space.N @ step))
        if closed is None:
            return None
        try:
            there = problem.at(closed, self.motion.expected)
        except SimulationError:
            return None
        return there if np.all(np.isfinite(there.force)) else None


def _in_global(N: Array, turn: Array) -> Array:
    """Return N with small turns in global axes in place of body axes."""
    rows = N.reshape(len(turn), 6, -1).copy()
    rows[:, 3:] = turn @ rows[:, 3:]
    return rows.reshape(N.shape)


def displacement_between(first: MotionAtTime, last: MotionAtTime) -> Numbers:
    """Return the shift and the turn of each body between two poses, in the axes of the first, (6n,)."""
    here, there = first.pose, last.pose
    shift = there.position[:-1] - here.position[:-1]
    sine = (here.L @ there.orientation[..., None])[:-1, :, 0]
    cosine = np.sum(here.orientation * there.orientation, axis=-1)[:-1]
    size = np.linalg.norm(sine, axis=1)
    angle = 2.0 * np.arctan2(size, np.abs(cosine)) * np.where(cosine < 0.0, -1.0, 1.0)
    turn = sine * (angle / np.where(size > 0.0, size, 1.0))[:, None]
    return np.concatenate([shift, turn], axis=1).ravel()
