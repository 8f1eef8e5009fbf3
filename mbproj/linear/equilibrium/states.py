"""Equilibria of mechanisms whose elements have states: x' = 0 beside the balance of forces.

First the states come to rest while the bodies stay. Where states depend on the pose and push bodies, Newton's steps
then bring both to rest together. Where that equilibrium is not nearby, bodies go downhill with constant states. Where
states then move bodies, or bodies states, damped steps reduce both residuals. States that count, as heat does, change
at equilibrium, too.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import SimulationError
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.derivatives import state_slopes
from mbproj.equations.forces import state_rates
from mbproj.equations.instant import Instant
from mbproj.equations.tangent_space import TangentSpace
from mbproj.linear.equilibrium.balance import EquilibriumBalance, EquilibriumProblem
from mbproj.linear.equilibrium.solve import (
    NoEquilibrium,
    Solved,
    by_residual,
    falls_for_ever,
    is_nearly_balanced,
    of_limited_length,
    solve,
)


@dataclass(frozen=True, eq=False)
class BalanceWithStates:
    """Forces `at` a pose, and the rates of states there. Residuals are relative to `torque` and `speed` (K,), the rate
    of each state for a change of states by their scales."""

    at: EquilibriumBalance
    torque: float
    speed: Array

    @classmethod
    def of(cls, at: EquilibriumBalance) -> BalanceWithStates:
        """Return the forces and rates with the scales at this pose."""
        first = cls(at, at.largest or _pushed(at) or 1.0, np.ones(len(at.problem.x)))
        speed = np.linalg.norm(first.stiffness[0][at.space.freedom :], axis=1)
        return replace(first, speed=np.where(speed > 0.0, speed, np.maximum(np.abs(first.rates), 1.0)))

    @property
    def space(self) -> TangentSpace:
        """The tangent space of the bodies."""
        return self.at.space

    @property
    def is_held(self) -> bool:
        """Whether nothing can move."""
        return False

    @cached_property
    def rates(self) -> Array:
        """x' in scales, (K,), 1/s."""
        return scaled_rates(self.at.motion.instant(self.at.problem.system))

    @property
    def residual(self) -> Array:
        """The residuals of the bodies and of the states, (f + K,)."""
        return np.concatenate([self.at.residual / self.torque, self.rates / self.speed])

    @cached_property
    def drift(self) -> Array:
        """The rates relative to the sum of their terms' absolute values, (K,)."""
        f, x = self.space.freedom, self.at.motion.x / self.at.problem.system.states.scale
        terms = np.abs(self.stiffness[0][f:]) @ np.concatenate([np.ones(f), 1.0 + np.abs(x)])
        return np.asarray(np.abs(self.rates / self.speed) / np.maximum(terms, np.finfo(float).tiny))

    @property
    def relative(self) -> float:
        """The larger of both residuals, relative to the current forces or to those at the beginning, because no force
        may act at rest."""
        forces = 0.0 if self.at.is_held else float(np.linalg.norm(self.at.residual)) / max(self.at.largest, self.torque)
        return max(forces, float(self.drift.max(initial=0.0)))

    @cached_property
    def stiffness(self) -> tuple[Array, Array]:
        """The derivative by which the residual falls with steps along the tangent space and with steps of the states by
        their scales, (f + K, f + K). Then the sum of its terms' absolute values."""
        (equations, N), scale = self.at.linear, self.at.problem.system.states.scale
        K, sizes = self.at.stiffness
        states, unit = equations.states, 1.0 / (scale * self.speed)[:, None]
        pushed = -states.push.times(N).T * scale / self.torque
        unit = unit * self.at.problem.system.states.rests[:, None]
        of_states = -unit * states.by_displacement.times(N), -unit * states.by_states * scale
        matrix = np.block([[K / self.torque, pushed], [*of_states]])
        return matrix, np.block([[sizes / self.torque, np.abs(pushed)], [*map(np.abs, of_states)]])

    def after(self, step: Array) -> BalanceWithStates | None:
        """Return the forces and rates after a step of limited length; None where constraints do not close, or a
        function has no value.

        Combinations of residuals that no motion changes, uᵀη with uᵀK = 0, stay as they are: the step has no part along
        them."""
        f, problem = self.space.freedom, self.at.problem
        U, σ, V = np.linalg.svd(self.stiffness[0])
        none = σ <= THRESHOLDS.rounding * σ.max(initial=0.0)
        conserved, free = U[:, none].T, V[none].T
        step = step - free @ np.linalg.lstsq(conserved @ free, conserved @ step, rcond=None)[0]
        step = of_limited_length(step, f)
        there = self.at.after(step[:f], problem.x + problem.system.states.scale * step[f:])
        return None if there is None else replace(self, at=there)


def _pushed(at: EquilibriumBalance) -> float:
    """Return the largest push of states by their scales, where all forces are 0."""
    equations, N = at.linear
    return float(np.abs(equations.states.push.times(N).T * at.problem.system.states.scale).max(initial=0.0))


def solve_with_states(problem: EquilibriumProblem, q: Array, expected: Array) -> Solved:
    """Return the equilibrium from a closed pose and the states of the problem. Raises NoEquilibrium, in words, where
    there is none."""
    problem = replace(problem, x=at_rest(problem, q, expected))
    at, steps = problem.at(q, expected), 0
    at_once = _solve_together(at)
    if at_once is not None:
        return at_once
    try:
        solved = solve(problem, q, expected)
        at, steps = solved.balance, solved.steps  # type: ignore[assignment]
    except NoEquilibrium:
        if not at.linear[0].states.push.value.any():
            raise
    balanced, more = by_residual(BalanceWithStates.of(at))
    if not is_nearly_balanced(balanced):
        raise drifts(BalanceWithStates.of(at)) if is_nearly_balanced(at) else falls_for_ever(balanced.at)
    return Solved(balanced.at, steps + more)


def _solve_together(at: EquilibriumBalance) -> Solved | None:
    """Return the equilibrium by steps that move bodies and states together. Return None where it is not nearby, or
    where no state that pushes depends on the pose. Return None, too, where the bodies are unstable while the states
    follow them."""
    states, start = at.linear[0].states, BalanceWithStates.of(at)
    go_by_pose = at.problem.system.states.rests[:, None] * states.by_displacement.dense()
    if not (states.push.value.any() and go_by_pose.any()) or _followed(start) is None:
        return None
    solved, steps = by_residual(start)
    K = _followed(solved) if is_nearly_balanced(solved) else None
    if K is None:
        return None
    κ = np.linalg.eigvalsh(0.5 * (K + K.T))
    return Solved(solved.at, steps) if np.all(κ >= -THRESHOLDS.rounding * np.abs(κ).max(initial=0.0)) else None


def _followed(balance: BalanceWithStates) -> Array | None:
    """Return K (f, f) of the bodies while all states stay at rest; None where some states have no rest nearby."""
    K, f = balance.stiffness[0], balance.space.freedom
    rests = f + np.flatnonzero(balance.at.problem.system.states.rests)
    K_states = K[np.ix_(rests, rests)]
    σ = np.linalg.svd(K_states, compute_uv=False)
    if np.any(σ <= THRESHOLDS.rounding * σ.max(initial=0.0)):
        return None
    return np.asarray(K[:f, :f] - K[:f, rests] @ np.linalg.solve(K_states, K[rests, :f]))


def at_rest(problem: EquilibriumProblem, q: Array, expected: Array) -> Array:
    """Return the states (K,) at rest, reached from those of the problem while the bodies stay. Where they do not come
    to rest, return those of the problem. Implicit steps lead there, and grow as the rates fall (Kelley and Keyes
    1998)."""
    scale, x, damping = problem.system.states.scale, problem.x, np.inf

    def instant() -> Instant:
        return problem.turning.motion(problem.t, q, expected, x).instant(problem.system)

    rates = scaled_rates(instant())
    for _ in range(THRESHOLDS.most_passes):
        size, J = float(np.linalg.norm(rates)), state_slopes(instant()) * scale / scale[:, None]
        J = J * problem.system.states.rests[:, None]
        fastest, growth = float(np.linalg.norm(J)), float(np.linalg.eigvals(J).real.max())
        if np.all(np.abs(rates) <= THRESHOLDS.no_digits * (np.abs(J) @ (1.0 + np.abs(x / scale)))):
            return x
        damping = min(damping, fastest)
        try:
            x = x + scale * np.linalg.solve(max(damping, 2.0 * growth) * np.eye(len(x)) - J, rates)
            rates = scaled_rates(instant())
        except (np.linalg.LinAlgError, SimulationError):
            break
        grown = float(np.linalg.norm(rates)) / size
        damping *= grown if grown > 1.0 else max(min(grown, 0.5), THRESHOLDS.smallest_change)
    return problem.x


def scaled_rates(instant: Instant) -> Array:
    """Return x' in scales, (K,), 1/s; 0 for states that count."""
    states = instant.system.states
    return np.asarray(states.rests * state_rates(instant) / states.scale)


def drifts(balance: BalanceWithStates) -> NoEquilibrium:
    """Return the error, in words, of a state that nothing brings to rest."""
    system, f = balance.at.problem.system, balance.space.freedom
    U, σ, _ = np.linalg.svd(balance.stiffness[0][f:, f:])
    held = U[:, σ <= THRESHOLDS.rounding * σ.max(initial=0.0)]  # combinations of rates that no state changes
    rates = balance.rates / balance.speed
    k = int(np.argmax(np.abs(held @ (held.T @ rates)) if held.size else balance.drift))
    rate = float(balance.rates[k] * system.states.scale[k])
    name, unit = system.names.states[k], system.names.state_units[k]
    return NoEquilibrium(
        f"there is no equilibrium: state '{name}' drifts by {rate:.4g} {unit}/s, and nothing brings that to 0; let "
        "what it integrates come to rest, or give it a leak",
        balance.at,
    )
