"""The stages of an implicit step in the full formulation, by a simplified Newton method.

Of stages y_i = known_i + Σ w_ij y'_j the unknowns are the accelerations a_i and the multipliers λ_i: with weights W, v
= known_v + W a and q = known_q + W v,

    M_i a_i + Σ_j (W_ij JᵀcJ + (W²)_ij JᵀkJ) (a_j - before_j) + C_qᵀ λ_i = Q_i,    C_q a_i = γ_i,


where M, C_q, Q and γ are those of the stages before the change, and J, k and c those of the stiff forces alone (see
`mbproj.dynamics.stiff_forces`). Nothing else is differentiated: the changes of gyroscopic terms and of constraints'
curvature within a step are small wherever the error is. States of elements, x_i = known_i + Σ w_ij x'_j, are
eliminated; channels are in `mbproj.integrate.formulations.stage_crossing`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.forces import state_rates
from mbproj.dynamics.stiff_forces import StiffForces, stiff_forces
from mbproj.errors import SimulationError
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.formulations.stage_crossing import Crossing, StageCrossing
from mbproj.integrate.formulations.terms import Accelerations, Terms
from mbproj.integrate.reporting.failures import unsolved_stages
from mbproj.integrate.steppers.stages import Stages, StagesUnsolved
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class StageEquations:
    """The equations of a formulation for implicit steps. `watched`: whether its policy records the poses of the
    stages."""

    formulation: FullFormulation
    watched: bool = False

    def __call__(self, t: float, y: Array) -> Array:
        """Return y' at a state."""
        return self.formulation.watched_derivative(t, y) if self.watched else self.formulation.derivative(t, y)

    def of_step(self, t: float, y: Array, h: float) -> StepStages:
        """Return the equations for the stages of a step from (t, y) over h."""
        return StepStages(self.formulation, h, self.watched)


#: The stiff forces and the derivatives through channels of each stage; None where nothing is stiff, and [] without
#: channels.
_Matrix: TypeAlias = "tuple[list[StiffForces] | None, list[StageCrossing]]"
_NOTHING: _Matrix = (None, [])


@dataclass(frozen=True, eq=False)
class StepStages:
    """The stages of a step of size h."""

    formulation: FullFormulation
    h: float
    watched: bool

    def solve(self, times: Array, known: Array, weights: Array, first: Array) -> Stages:
        """Return the stages at `times`; see `mbproj.integrate.steppers.stages`. Raises StagesUnsolved."""
        count, layout = len(times), self.formulation.layout
        positions, velocities = layout["positions"], layout["velocities"]
        newton, k = Newton(self.formulation, known, weights), np.tile(first, (count, 1))
        evaluations, matrix = 0, _NOTHING
        while True:
            y = known + weights @ k
            y[:, positions] = known[:, positions] + weights @ y[:, velocities]
            if newton.is_slow:
                matrix = self._matrix_at(times, y)
            evaluations += count
            try:
                terms = [self.formulation.terms(float(t), each) for t, each in zip(times, y, strict=True)]
                before, k, found = k, *self._changed(times, terms, matrix, weights, y, k)
            except (np.linalg.LinAlgError, SimulationError) as error:  # of a singular mechanism, or of states far off
                if newton.has_begun:
                    raise self._unsolved(float(times[-1]), newton, terms, matrix, evaluations) from error
                if isinstance(error, SimulationError):
                    raise
                raise self.formulation.singular(float(times[-1]), *self.formulation.parts(y[-1])[:2]) from error
            if newton.takes(y, k - before):
                break
            if newton.has_failed:
                raise self._unsolved(float(times[-1]), newton, terms, matrix, evaluations)
        if self.watched:
            for each in found:
                self.formulation.policy.see(each.nearness)
        multipliers = np.array([each.multipliers for each in found])

        def filtered(estimate: Array, h_gamma: float) -> Array:
            stiff, crossings = matrix
            if stiff is None and not crossings:
                return estimate
            return self._filtered(terms[-1], (stiff or [])[-1:], crossings[-1:], estimate, h_gamma)

        return Stages(k, multipliers, found[-1].nearness, evaluations, filtered)

    def beside(self, t: float, y: Array, g: float, slope: Array) -> Accelerations:
        """Return the accelerations of a state within the step, by one Newton step from a slope that is nearly right.
        The state is y = known + g y'."""
        times, states = np.array([t]), y[np.newaxis]
        terms, matrix = [self.formulation.terms(t, y)], self._matrix_at(times, states)
        _, (found,) = self._changed(times, terms, matrix, np.array([[g]]), states, slope[np.newaxis])
        return found

    def _matrix_at(self, times: Array, y: Array) -> _Matrix:
        """Return the parts of Newton's matrix at the stages: the forces that are stiff for the step, where all stages
        have some, and the derivatives through channels."""
        instants = [self.formulation.instant(float(t), each) for t, each in zip(times, y, strict=True)]
        stiff = [found for each in instants if (found := stiff_forces(each, self.h)) is not None]
        named = instants if self.formulation.system.channels.size else []
        crossings = [StageCrossing.at(at, self.formulation.parts(each)[1]) for at, each in zip(named, y, strict=False)]
        return stiff if len(stiff) == len(instants) else None, crossings

    def _unsolved(
        self, t: float, newton: Newton, terms: list[Terms], matrix: _Matrix, evaluations: int
    ) -> StagesUnsolved:
        """Return the error of stages that were not solved."""
        worst = None if matrix[0] is None else matrix[0][-1]
        is_near = min(each.held.nearness for each in terms) < THRESHOLDS.near_singular
        system = self.formulation.system
        return unsolved_stages(system, t, *newton.change, newton.state, worst, evaluations, is_near=is_near)

    def _changed(
        self,
        times: Array,
        terms: list[Terms],
        matrix: _Matrix,
        weights: Array,
        y: Array,
        k: Array,
    ) -> tuple[Array, list[Accelerations]]:
        """Return the slopes of the stages after one Newton step, with their accelerations."""
        layout, (stiff, crossings) = self.formulation.layout, matrix
        before = np.zeros((len(terms), len(terms[0].M)))
        before[:, layout["positions"]] = k[:, layout["velocities"]]
        terms = [self._stabilised(each, *row) for each, *row in zip(terms, np.diagonal(weights), before, strict=True)]
        states = layout["states"]
        crossing = Crossing.of(crossings, weights, before.shape[1]) if crossings else None
        slope = self.formulation.slope
        if stiff is None and crossing is None:
            found = [each.solved(*self.formulation.solve(each.M, each.C_q, each.Q, each.gamma)) for each in terms]
            slopes = np.array([slope(t, state, each) for t, state, each in zip(times, y, found, strict=True)])
        else:
            off = np.array([self._rates(t, each) for t, each in zip(times, y, strict=True)]) - k[:, states]
            found = self._coupled(terms, weights, before, matrix, crossing, off)
            slopes = np.array([slope(t, state, each) for t, state, each in zip(times, y, found, strict=True)])
            if crossing is not None:
                change = np.zeros_like(before)
                change[:, layout["positions"]] = slopes[:, layout["velocities"]] - before[:, layout["positions"]]
                slopes[:, states] = k[:, states] + crossing.changes(off.ravel(), change.ravel()).reshape(off.shape)
        slopes[:, layout["positions"]] = (y + weights @ (slopes - k))[:, layout["velocities"]]
        return slopes, found

    def _rates(self, t: float, y: Array) -> Array:
        """Return x' of the states of elements, (K,)."""
        at = self.formulation
        return state_rates(at.instant(t, y), at.held) if at.system.states.size else np.zeros(0)

    def _stabilised(self, terms: Terms, weight: float, before: Array) -> Terms:
        """Return the terms with Baumgarte's terms implicit: C_q a + (2α w + β² w²) C_q (a - before) = γ."""
        gains = self.formulation.settings.projection.gains
        if gains is None:
            return terms
        more, held = 2.0 * gains[0] * weight + (gains[1] * weight) ** 2, terms.held.C_q
        gamma = terms.gamma.copy()
        gamma[: len(held)] = (gamma[: len(held)] + more * held @ before[: held.shape[1]]) / (1.0 + more)
        return replace(terms, gamma=gamma)

    def _coupled(
        self,
        terms: list[Terms],
        weights: Array,
        before: Array,
        matrix: _Matrix,
        crossing: Crossing | None,
        off: Array,
    ) -> list[Accelerations]:
        """Return the accelerations of stages that stiff forces and channels couple.

        `before` (s, 7n + reflected inertias) are those before the change; `off` (s, K) the rates of states less those
        before."""
        positions, (count, size) = self.formulation.layout["positions"], before.shape
        rows = [len(each.C_q) for each in terms]
        added = np.zeros((count, size, count, size))
        both: list[Sequence[StiffForces | StageCrossing]] = [part for part in matrix if part]
        for each in both:
            for stage, (at, once, twice) in enumerate(zip(each, weights, weights @ weights, strict=True)):
                added[stage, positions, :, positions] += (
                    once[:, None] * at.viscous[:, None] + twice[:, None] * at.elastic[:, None]
                )
        whole = added.reshape(count * size, count * size)
        Q, gamma = (np.concatenate([getattr(each, name) for each in terms]) for name in ("Q", "gamma"))
        if crossing is not None:
            whole, Q = whole + crossing.added, Q + crossing.pushed(off.ravel())
        M, C_q = (_on_diagonal([getattr(each, name) for each in terms]) for name in ("M", "C_q"))
        acceleration, multipliers = self.formulation.solve(M + whole, C_q, Q + whole @ before.ravel(), gamma)
        parts = zip(terms, acceleration.reshape(count, size), np.split(multipliers, np.cumsum(rows)[:-1]), strict=True)
        return [each.solved(*part) for each, *part in parts]

    def _filtered(
        self, terms: Terms, stiff: list[StiffForces], crossings: list[StageCrossing], estimate: Array, h_gamma: float
    ) -> Array:
        """Return an estimate e filtered by stiff forces and states, (1 - hγ ∂f/∂y)⁻¹ e.

        It is ε_v by M + hγ JᵀcJ + (hγ)² JᵀkJ, ε_q = e_q + hγ ε_v, and ε_x = (1 - hγ f_x)⁻¹ (e_x + hγ (f_q e_q + B
        ε_v))."""
        layout, size = self.formulation.layout, len(terms.M)
        of_q, of_v, _ = self.formulation.parts(estimate)
        n, x = len(of_q), estimate[layout["states"]]
        added, pull = np.zeros((size, size)), np.zeros(size)
        for each in (stiff, crossings):
            for at in each:
                added[:n, :n] += h_gamma * at.viscous + h_gamma**2 * at.elastic
                pull[:n] -= h_gamma * at.elastic @ of_q
        weight = np.array([[h_gamma]])
        crossing = Crossing.of(crossings, weight, size) if crossings else None
        if crossing is not None:
            x = x + h_gamma * crossings[0].by_position @ of_q
            added, pull = added + crossing.added, pull + crossing.pushed(x)
        turned, found = of_v, estimate.copy()
        if stiff or crossings[0].pushes:
            pull -= added[:, :n] @ of_v
            turned = of_v + self.formulation.solve(terms.M + added, terms.C_q, pull, np.zeros(len(terms.C_q)))[0][:n]
            found = layout.changed(estimate, {"positions": of_q + h_gamma * turned, "velocities": turned})
        if crossing is not None:
            found[layout["states"]] = crossing.changes(x, np.append(turned, np.zeros(size - n)))
        return found


class Newton:
    """Scratch of Newton's method: the sizes of its changes to the stages, in parts of the tolerated error."""

    def __init__(self, formulation: FullFormulation, known: Array, weights: Array) -> None:
        tolerance = formulation.settings.tolerance
        self._layout, self._weights = formulation.layout, weights
        self._scale = self._layout.scale[self._layout.controlled]
        left = THRESHOLDS.newton_fixed if tolerance is None else THRESHOLDS.newton_part * tolerance
        self._least = max(left, THRESHOLDS.newton_fixed)
        self._sizes: list[float] = []
        #: The last change of q and v of the last stage.
        self.change = (np.zeros(self._layout.size_of("positions")),) * 2
        #: The state of an element that this change moved most; -1 where a body moved more.
        self.state = -1

    def takes(self, y: Array, change: Array) -> bool:
        """Return whether stages at y have converged with this change of their slopes."""
        layout = self._layout
        dv, dx = (self._weights @ change[:, layout[name]] for name in ("velocities", "states"))
        dq = self._weights @ dv
        self.change = dq[-1], dv[-1]
        moved = np.concatenate([dq, dv, dx], axis=1) / (self._scale + np.abs(y[:, layout.controlled]))
        self.state = max(int(np.argmax(moved[-1] ** 2)) - layout["states"].start, -1)
        size = float(np.sqrt(np.mean(moved * moved, axis=1)).max())
        self._sizes.append(size)
        if len(self._sizes) == 1:
            return size <= 1e-3 * self._least
        ratio = max(self.ratio, THRESHOLDS.least_contraction)
        return (ratio < 1.0 and size * ratio / (1.0 - ratio) <= self._least) or (
            ratio > 0.5 and size <= max(self._least, THRESHOLDS.newton_floor)
        )

    @property
    def ratio(self) -> float:
        """The size of the last change over that of the one before."""
        before = self._sizes[-2]
        return self._sizes[-1] / before if before > 0.0 else 0.0

    @property
    def has_begun(self) -> bool:
        """Whether a change was made."""
        return bool(self._sizes)

    @property
    def is_slow(self) -> bool:
        """Whether the matrix has to be computed: at first, and where changes shrink too slowly."""
        return not self._sizes or (len(self._sizes) > 1 and self.ratio > THRESHOLDS.first_contraction)

    @property
    def has_failed(self) -> bool:
        """Whether further changes are useless."""
        return not np.isfinite(self._sizes[-1]) or len(self._sizes) >= THRESHOLDS.most_newton


def _on_diagonal(blocks: list[Array]) -> Array:
    """Return a matrix with these blocks on its diagonal."""
    if len(blocks) == 1:
        return blocks[0]
    heights, widths = (np.cumsum([0, *(block.shape[axis] for block in blocks)]) for axis in (0, 1))
    whole = np.zeros((heights[-1], widths[-1]))
    for block, row, column in zip(blocks, heights, widths, strict=False):
        whole[row : row + block.shape[0], column : column + block.shape[1]] = block
    return whole
