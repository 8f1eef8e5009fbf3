"""Short runs with the scene's own settings and 2, 3, 4, 6, 8, 12 .. steps, from which the order is determined."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.integrate.events.splits import splits_of
from mbproj.registry import PROJECTIONS, with_fixed_steps
from mbproj.scene.records import ProjectionSettings
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Failure, Solution, sample_times, solve
from mbproj.studies.verify.rounded import EPS
from mbproj.thresholds import THRESHOLDS

#: Length of a run, in the time that the fastest part of the mechanism takes for 1 rad. The second is tried where runs
#: of the first fail, pass over an edge of a law, or show no order.
SPANS = (2.0, 0.5)
#: Numbers of steps. The full formulation, a thousand times slower, uses only the first `FEWER` of them.
STEPS, FEWER = tuple(sorted([*(2**power for power in range(1, 10)), *(3 * 2**power for power in range(8))])), 11
#: An error tells of the order only where it is this many times above its round-off.
ABOVE = 10.0
#: Errors that differ by less than this part do not fall: doubling the steps of a method of order 1 halves its error.
LEVEL = 0.1
#: An order is fitted to the last `FITTED` runs. From `BENT` runs on the fitted line may bend. Only runs with `COARSER`
#: times fewer steps than the finest are measured against it.
FITTED, BENT, COARSER = 6, 5, 4
#: A run tells of the order only where its steps are more than this many times its events.
CROWDED = 2


@dataclass(frozen=True)
class Order:
    """An observed order, and twice its standard error."""

    value: float
    uncertainty: float


@dataclass(frozen=True, eq=False)
class ShortRuns:
    """The runs of a mechanism that came to their end, by increasing number of `steps`. `failure` is that of a run that
    did not, or None.

    `length` (m) and `span` (s) are the units of errors. `floor` is the error that round-off and the projection's stop
    test leave in any run. `split` names a short movement for which steps are split; "" where there is none."""

    steps: Array
    solutions: tuple[Solution, ...]
    failure: Failure | None
    length: float
    span: float
    floor: float
    split: str = ""

    @property
    def passed(self) -> str:
        """An edge of a law that the steps of a run passed over, so that no method keeps its order; "" where there is
        none."""
        return next((each.report.passed for each in self.solutions if each.report and each.report.passed), "")

    @property
    def errors(self) -> Array:
        """The largest difference at the end between each of the coarser runs and the finest: in orientations, positions
        and velocities of bodies and markers."""
        if not self.solutions:
            return np.zeros(0)
        ends = np.array([self._end(each) for each in self.solutions])
        return np.abs(ends - ends[-1]).max(axis=1)[COARSER * self.steps <= self.steps[-1]]

    @property
    def events(self) -> Integers:
        """The number of times at which each run met events. Steps end there."""
        return np.array([0 if each.report is None else each.report.events for each in self.solutions], dtype=np.intp)

    @property
    def is_level(self) -> bool:
        """Whether events occur and the coarser half of the errors is constant: then something else decides the length
        of the steps."""
        coarse = self.errors[: len(self.errors) // 2]
        return (
            bool(self.events.any())
            and len(coarse) > 1
            and bool(coarse.min() > ABOVE * self.floor and np.ptp(coarse) < LEVEL * coarse.min())
        )

    def _end(self, solution: Solution) -> Array:
        places, rates = ("body_position", "marker_position"), ("body_velocity", "marker_velocity")
        turned = solution.body_orientation[-1]
        return np.concatenate(
            [
                np.einsum("ni,nj->nij", turned, turned).ravel(),  # Λ and -Λ are one orientation
                *(getattr(solution, name)[-1].ravel() / self.length for name in places),
                *(getattr(solution, name)[-1].ravel() * self.span / self.length for name in rates),
            ]
        )

    def order(self, values: Array) -> Order | None:
        """The power of the step with which `values`, one for each of the first runs, fall. A line is fitted to the
        logarithms of the last values above round-off. Runs whose steps mostly end at events do not count: such steps do
        not shorten. None where fewer than three runs are left."""
        low = np.flatnonzero(~(values > ABOVE * self.floor))
        above = values[: low[0]] if len(low) else values
        own = self.steps[: len(above)] > CROWDED * self.events[: len(above)]
        return order_of(self.steps[: len(above)][own][-FITTED:], above[own][-FITTED:])


def order_of(steps: Array, values: Array) -> Order | None:
    """Fit the power of the step with which values fall; None for fewer than three values.

    Coarse steps may hide it. So from `BENT` values on the next power of the step enters: log |c hᵖ (1 + a h)| ≈ log c +
    p log h + a h. Its slope at the finest step is taken where it is higher and less uncertain than the straight line's.
    Fewer values would bend any line downwards."""
    x, y = np.log2(steps), np.log2(values)
    if len(x) < 3:
        return None
    straight = _slope(y, np.column_stack([-x, np.ones(len(x))]))
    if len(x) < BENT:
        return straight
    h = steps[0] / steps
    # the last column has no slope at the finest step
    bent = _slope(y, np.column_stack([-x, np.ones(len(x)), h + h[-1] * np.log(2.0) * x]))
    return bent if bent.value > straight.value and bent.uncertainty < straight.uncertainty else straight


def _slope(y: Array, columns: Array) -> Order:
    """The coefficient of the first column in the least-squares fit of y, and twice its standard error."""
    solution = np.linalg.lstsq(columns, y, rcond=None)[0]
    residual = y - columns @ solution
    spread = residual @ residual / (len(y) - columns.shape[1]) * np.linalg.inv(columns.T @ columns)[0, 0]
    return Order(float(solution[0]), 2.0 * float(np.sqrt(spread)))


def short_runs(mechanism: Mechanism, rate: float, slow: bool) -> ShortRuns:
    """The runs of a mechanism that turns at up to `rate` (rad/s). `slow` says that steps are expensive."""
    longer, shorter = SPANS
    runs = _runs_over(mechanism, longer / rate, slow)
    if runs.failure is None and not runs.passed and runs.order(runs.errors) is not None:
        return runs
    again = _runs_over(mechanism, shorter / rate, slow)
    if runs.passed or again.passed:
        return runs if again.passed else again
    return again if again.order(again.errors) is not None or runs.failure is not None else runs


def _runs_over(mechanism: Mechanism, span: float, slow: bool) -> ShortRuns:
    """The runs over a span in s, with each number of steps."""
    own, times = Setting.of(mechanism.scene.settings), sample_times(span, 1)
    own = replace(own, integrator=with_fixed_steps(own.integrator))
    done, solutions, failure = [], [], None
    for steps in STEPS[:FEWER] if slow else STEPS:
        solution = solve(mechanism, replace(own, step=span / steps, tolerance=None), times)
        if solution.failure is None:
            done.append(steps)
            solutions.append(solution)
        else:
            failure = solution.failure
    projection = mechanism.scene.settings.projection
    floor = max(_left_open(projection) / mechanism.system.length, STEPS[-1] * EPS)
    coarsest = mechanism.settings(replace(own, step=span / STEPS[0], tolerance=None), span, span)
    splits = splits_of(mechanism.system, mechanism.state.t, coarsest)
    split = splits[0].owner if splits else ""
    return ShortRuns(np.array(done), tuple(solutions), failure, mechanism.system.length, span, floor, split)


def _left_open(projection: ProjectionSettings) -> float:
    """The largest violation that a projection may leave, m."""
    if not PROJECTIONS[projection.method].corrects or not projection.position:
        return 0.0
    stop = THRESHOLDS.paper_tolerance**0.75 if projection.test == "paper" else THRESHOLDS.closed_to
    return max(projection.tolerance or stop, projection.threshold or 0.0)
