"""Equilibria of large mechanisms, by sparse matrices: Levenberg-Marquardt steps on the tangent space.

σ limits the step of K + σ W, W the metric of the tangent space. The step leads downhill where K + σ W is definite on
the tangent space. σ grows until that is so. It vanishes near the equilibrium, so that the last steps are Newton's.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, final

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import SimulationError
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import coordinate_values
from mbproj.equations.constraints import EPSILON, constraint
from mbproj.equations.derivatives import MotionAtTime, constraint_rows, linear_equations, tangent_force
from mbproj.equations.kinematics import pose_of
from mbproj.equations.tangent_space import moved
from mbproj.equations.turning import near
from mbproj.linear.bordered import Proximal, is_definite
from mbproj.linear.equilibrium.balance import EquilibriumProblem, largest_acting
from mbproj.linear.equilibrium.solve import (
    Fall,
    Solved,
    falls_for_ever,
    goes_down,
    is_balanced,
    is_far,
    is_nearly_balanced,
)

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix


@final
@dataclass(frozen=True, eq=False)
class LargeBalance:
    """The forces (6n,) at a pose of a large mechanism at rest, and the multipliers that balance them as far as they
    can. `unbalanced` (6n,): the displacement along which they are unbalanced, with the size of the rest."""

    problem: EquilibriumProblem
    motion: MotionAtTime
    force: Array
    metric: Proximal
    multipliers: Array
    unbalanced: Array

    @classmethod
    def at(cls, problem: EquilibriumProblem, q: Array, expected: Array) -> LargeBalance:
        """Return the forces at a closed pose."""
        system = problem.system
        counted = np.asarray(near(system, coordinate_values(system, pose_of(q)), expected), dtype=float)
        motion = problem.turning.motion(problem.t, q, counted, problem.x)
        force = tangent_force(system, motion)
        metric = Proximal(system, _metric(problem), constraint_rows(system, motion))
        unbalanced, multipliers = metric.solve(force)
        return cls(problem, motion, force, metric, multipliers, unbalanced)

    @property
    def lengths(self) -> Array:
        """The units of tangent coordinates, (6n,)."""
        return self.problem.lengths

    @cached_property
    def largest(self) -> float:
        """The largest torque, or force times the length, that acts."""
        return largest_acting(self)

    @property
    def relative(self) -> float:
        """The unbalanced part relative to the largest force."""
        return float(np.linalg.norm(self.unbalanced / self.lengths)) / max(self.largest, float(np.finfo(float).tiny))

    @property
    def is_held(self) -> bool:
        """Whether nothing can move. This is not known for large mechanisms; a locked one has a residual of
        round-off."""
        return False

    def stiffness(self) -> csr_matrix:
        """Return K (6n, 6n)."""
        return linear_equations(self.problem.system, self.motion, self.multipliers).K.sparse()

    def after(self, ξ: Array) -> LargeBalance | None:
        """Return the forces after a displacement and back to the constraints; None where these do not close, or a force
        has no value."""
        closed = self._closed_pose(moved(self.motion.q, ξ))
        if closed is None:
            return None
        try:
            there = LargeBalance.at(self.problem, closed, self.motion.expected)
        except SimulationError:
            return None
        return there if np.all(np.isfinite(there.force)) else None

    def _closed_pose(self, q: Array) -> Array | None:
        """Return the closed pose next to q by Newton's steps, three with one factor; None where it cannot be closed."""
        problem, system = self.problem, self.problem.system
        metric, scale = self.metric, system.row_scale[system.bodies :]
        before, closed = np.inf, THRESHOLDS.closed_grains * EPSILON
        for step in range(THRESHOLDS.most_passes):
            open_by = constraint(system, pose_of(q), problem.drive)[system.bodies :]
            size = float(np.abs(open_by / scale).max(initial=0.0))
            if size <= closed or (size <= 1e3 * closed and size > 0.5 * before):
                return q
            if not size <= 1.0:
                return None
            if step % 3 == 2:
                rows = constraint_rows(system, problem.turning.motion(problem.t, q, self.motion.expected, problem.x))
                metric = Proximal(system, _metric(problem), rows)
            before = size
            q = moved(q, metric.solve(np.zeros(len(self.force)), -open_by)[0])
        return q if size <= THRESHOLDS.assembled else None


def solve_large(problem: EquilibriumProblem, q: Array, expected: Array) -> Solved:
    """Return the equilibrium downhill from a closed pose. Raises NoEquilibrium, in words, where there is none."""
    here = start = LargeBalance.at(problem, q, expected)
    radius, σ, steps, fall = THRESHOLDS.long_way, 0.0, 0, Fall()
    while steps < THRESHOLDS.most_passes and not is_balanced(here):
        steps += 1
        K = here.stiffness()
        step, σ = _downhill(here, K, 0.1 * σ, radius)
        size = float(np.abs(step / here.lengths).max())
        there = here.after(step)
        gain = float(here.force @ step - 0.5 * step @ (K @ step))
        if there is None or not goes_down(here, there, gain):
            if is_nearly_balanced(here):
                break
            radius = 0.25 * min(radius, size)
            continue
        fall = fall.after(there, 2.0 * size)
        if fall.is_endless or is_far(there, start):
            raise falls_for_ever(there)
        if size > 0.3 * radius:
            radius = min(2.0 * radius, THRESHOLDS.largest_radius)
        here = there
    if not is_nearly_balanced(here):
        raise falls_for_ever(here)
    return Solved(here, steps, _is_lowest(here))


def _is_lowest(here: LargeBalance) -> bool:
    """Return whether the energy grows in all directions but neutral ones."""
    K, system = here.stiffness(), here.problem.system
    return is_definite(system, 0.5 * (K + K.T) + _least(here, K) * _metric(here.problem), here.metric.G)


def _least(here: LargeBalance, K: csr_matrix) -> float:
    """Return the least σ, which is the round-off of K."""
    largest = float(np.abs(K.diagonal() * here.lengths**2).max(initial=0.0))
    return THRESHOLDS.proximal * max(largest, here.largest)


def _downhill(here: LargeBalance, K: csr_matrix, σ: float, radius: float) -> tuple[Array, float]:
    """Return the step with the smallest σ, from the given one upwards, that leads downhill and stays within the radius;
    and σ."""
    system, W, G = here.problem.system, _metric(here.problem), here.metric.G
    σ = max(σ, _least(here, K))
    while True:
        A, grow = K + σ * W, 10.0
        if is_definite(system, 0.5 * (A + A.T), G):
            step = Proximal(system, A, G).solve(here.force)[0]
            size = float(np.abs(step / here.lengths).max(initial=0.0))
            if size <= radius:
                return step, σ
            grow = min(2.0 * size / radius, grow)
        σ *= grow


def _metric(problem: EquilibriumProblem) -> csr_matrix:
    from scipy.sparse import diags

    return diags(problem.lengths**-2.0, format="csr")
