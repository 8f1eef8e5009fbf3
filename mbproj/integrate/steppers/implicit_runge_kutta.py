"""Implicit Runge-Kutta steps for stiff mechanisms, their filtered error estimates and continuous extensions.

Accelerations and multipliers are the unknowns of the stages, which meet the constraints at the level of accelerations.
The first stage is the slope at the end of the last step. A new evaluation at the projected state would turn the
projection's correction of the positions into a force: the stiffer the forces, the larger. For the same reason a point
takes its accelerations and multipliers from the last stage. Between two points they follow from the slope of the
extension by one more step of Newton's method.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.arrays import Array, may_overflow
from mbproj.dataclass import dataclass
from mbproj.integrate.steppers.implicit_tableau import ImplicitTableau
from mbproj.integrate.steppers.runge_kutta import Extension, Step
from mbproj.integrate.steppers.stages import Equations


@dataclass(frozen=True, eq=False)
class ImplicitRungeKutta:
    """An implicit method with its tableau. It counts its evaluations itself."""

    tableau: ImplicitTableau
    attempt_cost = 0
    error_cost = 0
    extend_cost = 0

    @property
    def order(self) -> int:
        return self.tableau.order

    @property
    def error_order(self) -> int:
        return self.tableau.error_order

    def attempt(self, f: Equations, t: float, y: Array, h: float, first: Array, multipliers: Array) -> Step:
        """Return a step of size h; `first` is the slope at its start, with `multipliers` (m,). Raises
        StagesUnsolved."""
        tableau = self.tableau
        step, k = f.of_step(t, y, h), np.zeros((tableau.stages, len(y)))
        found = np.zeros((tableau.stages, len(multipliers)))
        k[0], found[0], evaluations = first, multipliers, 0
        with may_overflow():
            for group in self._groups():
                weights = h * tableau.a[group]
                known = y + weights[:, : group.start] @ k[: group.start]
                stages = step.solve(t + h * tableau.c[group], known, weights[:, group], k[group.start - 1])
                k[group], found[group] = stages.k, stages.multipliers
                evaluations += stages.evaluations

            def filtered(estimate: Array) -> Array:
                return stages.filtered(estimate, h * tableau.gamma)

            return Step(
                t,
                h,
                y,
                y + h * (tableau.b @ k),
                k,
                multipliers=found,
                nearness=stages.nearness,
                evaluations=evaluations,
                estimate=filtered(h * (tableau.error @ k)),
                filtered=filtered,
            )

    def _groups(self) -> list[slice]:
        """Return the groups of stages that are solved together, without the first stage."""
        stages = self.tableau.stages
        return [slice(1, stages)] if self.tableau.is_coupled else [slice(i, i + 1) for i in range(1, stages)]

    def error(self, f: Equations, t: float, step: Step) -> tuple[Step, Array]:
        """Return the step, and the estimate of its local error, (1, N)."""
        assert step.estimate is not None
        return step, step.estimate[None]

    def extend(self, f: Equations, step: Step) -> Extension:
        """Return the continuous extension of a step."""
        return Extension(step, self.tableau.dense.T @ step.k)

    def quadrature(self, step: Step) -> Iterator[tuple[float, Array]]:
        """The points at which a step has evaluated f, with the weights of its quadrature."""
        a, b = self.tableau.a, self.tableau.b
        for stage in np.flatnonzero(b):
            yield float(b[stage]), step.y + step.h * (a[stage] @ step.k)

    def within(self, step: Step, theta: float) -> Array:
        """Return the slope (N,) at t + θh: the derivative of the extension."""
        dense = self.tableau.dense
        powers = np.arange(1, dense.shape[1] + 1)
        weights = dense @ (powers * theta ** (powers - 1))
        return np.asarray(weights @ step.k)
