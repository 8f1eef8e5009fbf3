"""One short run with the scene's own settings and 2, 3, 4, 6, 8, 12 .. steps: what its order is read from."""

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

#: The run takes so many times as long as the fastest part of the mechanism needs for 1 rad; the second where the first
#: does not get to its end, passes over an edge of a law, or shows no order.
SPANS = (2.0, 0.5)
#: Numbers of steps; only the first in the full formulation, which is a thousand times slower.
STEPS, FEWER = tuple(sorted([*(2**power for power in range(1, 10)), *(3 * 2**power for power in range(8))])), 11
#: An error that is not so many times above its round-off says nothing of the order.
ABOVE = 10.0
#: Errors that differ by less than this part do not fall: a method of order 1 has a half.
LEVEL = 0.1
#: Runs from which an order is taken, and from which a line may bend; runs so many times coarser than the finest can be
#: measured against that.
FITTED, BENT, COARSER = 6, 5, 4
#: A run tells of the order where it has more steps than so many times its events.
CROWDED = 2


@dataclass(frozen=True)
class Order:
    """An observed order, and twice its standard error."""

    value: float
    uncertainty: float


@dataclass(frozen=True, eq=False)
class Halved:
    """The runs that came to an end, by increasing number of `steps`; `failure` of one that did not, None where all did.
    `length` (m) and `span` (s) are what errors are measured in; `floor`: what round-off and the stop test of the
    projection leave of any error. `split`: whose short moves steps are split for; "" where for none."""

    steps: Array
    solutions: tuple[Solution, ...]
    failure: Failure | None
    length: float
    span: float
    floor: float
    split: str = ""

    @property
    def passed(self) -> str:
        """What the steps of one of them have passed over, where no method keeps its order; "" where that is nothing."""
        return next((each.report.passed for each in self.solutions if each.report and each.report.passed), "")

    @property
    def errors(self) -> Array:
        """How far runs end from the finest, in orientations, and in positions and velocities of bodies and markers; of
        the coarser ones."""
        if not self.solutions:
            return np.zeros(0)
        ends = np.array([self._end(each) for each in self.solutions])
        return np.abs(ends - ends[-1]).max(axis=1)[COARSER * self.steps <= self.steps[-1]]

    @property
    def events(self) -> Integers:
        """At how many times each run has met events, where its steps end."""
        return np.array([0 if each.report is None else each.report.events for each in self.solutions], dtype=np.intp)

    @property
    def is_level(self) -> bool:
        """Whether steps end at events, and half of the errors do not fall at all: something else makes the steps."""
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
        """The power of the step with which values, one for each of the first runs, fall: a line through the last of
        them above round-off, logarithms over logarithms. Runs tell nothing whose steps end at events more than on their
        own: those do not become shorter. None where fewer than three are left."""
        low = np.flatnonzero(~(values > ABOVE * self.floor))
        above = values[: low[0]] if len(low) else values
        own = self.steps[: len(above)] > CROWDED * self.events[: len(above)]
        return order_of(self.steps[: len(above)][own][-FITTED:], above[own][-FITTED:])


def order_of(steps: Array, values: Array) -> Order | None:
    """The power with which values fall with the step; None of fewer than three values. Coarse steps may hide it. Then
    the line bends by the next power of the step: log |c hᵖ (1 + a h)| ≈ log c + p log h + a h. The power is its slope
    at the finest step, where that is higher and surer. Few values bend any line downwards."""
    x, y = np.log2(steps), np.log2(values)
    if len(x) < 3:
        return None
    straight = _slope(y, np.column_stack([-x, np.ones(len(x))]))
    if len(x) < BENT:
        return straight
    h = steps[0] / steps
    bent = _slope(y, np.column_stack([-x, np.ones(len(x)), h + h[-1] * np.log(2.0) * x]))  # level at the finest step
    return bent if bent.value > straight.value and bent.uncertainty < straight.uncertainty else straight


def _slope(y: Array, columns: Array) -> Order:
    """The coefficient of the first column where columns fit y best."""
    found = np.linalg.lstsq(columns, y, rcond=None)[0]
    residual = y - columns @ found
    spread = residual @ residual / (len(y) - columns.shape[1]) * np.linalg.inv(columns.T @ columns)[0, 0]
    return Order(float(found[0]), 2.0 * float(np.sqrt(spread)))


def halved(mechanism: Mechanism, rate: float, slow: bool) -> Halved:
    """The runs of a mechanism that turns at up to `rate` (rad/s); `slow`: whether steps are expensive."""
    longer, shorter = SPANS
    found = _over(mechanism, longer / rate, slow)
    if found.failure is None and not found.passed and found.order(found.errors) is not None:
        return found
    again = _over(mechanism, shorter / rate, slow)
    if found.passed or again.passed:
        return found if again.passed else again
    return again if again.order(again.errors) is not None or found.failure is not None else found


def _over(mechanism: Mechanism, span: float, slow: bool) -> Halved:
    """The runs over a span in s."""
    own, times = Setting.of(mechanism.scene.settings), sample_times(span, 1)
    own = replace(own, integrator=with_fixed_steps(own.integrator))
    done, solutions, failure = [], [], None
    for steps in STEPS[:FEWER] if slow else STEPS:
        found = solve(mechanism, replace(own, step=span / steps, tolerance=None), times)
        if found.failure is None:
            done.append(steps)
            solutions.append(found)
        else:
            failure = found.failure
    projection = mechanism.scene.settings.projection
    floor = max(_left(projection) / mechanism.system.length, STEPS[-1] * EPS)
    coarsest = mechanism.settings(replace(own, step=span / STEPS[0], tolerance=None), span, span)
    splits = splits_of(mechanism.system, mechanism.state.t, coarsest)
    split = splits[0].owner if splits else ""
    return Halved(np.array(done), tuple(solutions), failure, mechanism.system.length, span, floor, split)


def _left(projection: ProjectionSettings) -> float:
    """What a projection leaves open: m."""
    if not PROJECTIONS[projection.method].corrects or not projection.position:
        return 0.0
    stop = THRESHOLDS.paper_tolerance**0.75 if projection.test == "paper" else THRESHOLDS.closed_to
    return max(projection.tolerance or stop, projection.threshold or 0.0)
