"""Steps by error control; they end at breaks."""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from mbproj.arrays import Array, may_overflow
from mbproj.dynamics.assembly.assemble import coordinates
from mbproj.dynamics.equations.motions import drive_at
from mbproj.dynamics.equations.teeth import near
from mbproj.dynamics.equations.turning import Turning
from mbproj.dynamics.observe.samples import Sample
from mbproj.errors import SimulationError
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.loop.run import Run
from mbproj.integrate.loop.step_end import is_closed, left_open_at
from mbproj.integrate.loop.step_size import StepSizeController, error_norm, first_step
from mbproj.integrate.point import Point, Slopes, attempted, point_at
from mbproj.integrate.reporting.failures import TurnsUntold, not_finite, step_vanished
from mbproj.integrate.reporting.marks import Mark, resuming
from mbproj.integrate.steppers.runge_kutta import Step
from mbproj.thresholds import THRESHOLDS


class _Attempt(NamedTuple):
    """A step and the norm of its error."""

    step: Step
    error: float


#: A step, or the error that its equations have no solution.
_Tried: TypeAlias = _Attempt | SimulationError


class ErrorControl:
    """One run with error control."""

    def __init__(self, run: Run) -> None:
        tolerance = run.exact.settings.tolerance
        assert tolerance is not None
        self.run, self.tolerance, self.scale = run, tolerance, run.exact.layout.scale

    def samples(self, point: Point) -> Iterator[Sample]:
        """Yield samples from a point to the end; samples within a step come from the continuous extension."""
        run = self.run
        h = self.first_step(run.exact, point, self.way_left(point.t))
        yield point.sample(run.exact, h, run.tally)
        if run.breaks.passed:
            point, h = self.go_on(point)
        yield from self.steps(point, h, self.forgetful)

    def resumed(self, mark: Mark) -> Iterator[Sample]:
        """Yield samples from a mark on. Raises InputError where it is not of this scene."""
        with resuming():
            point, h = self.run.resume(mark), float(mark["h"])
            control = StepSizeController(
                self.run.stepper.error_order, float(mark["previous_error"]), bool(mark["rejected"])
            )
        yield from self.steps(point, h, control)

    def steps(self, point: Point, h: float, control: StepSizeController) -> Iterator[Sample]:
        """Yield the samples after a point, from which the next step has the size h."""
        run, times, lost = self.run, self.run.leg.times, None
        assert times is not None
        done = bisect_right(times, point.t)
        while done < len(times):
            if not h >= self.shortest(point.t):
                raise lost or step_vanished(point.t)
            run.mark(point, h=h, previous_error=control.previous_error, rejected=control.rejected)
            h, t = self.target(h, point.t)
            tried = self.attempt(point, h, t)
            if isinstance(tried, SimulationError) or not tried.error <= 1.0:
                run.tally.rejected_steps += 1
                lost = tried if isinstance(tried, SimulationError) else None
                error = np.nan if isinstance(tried, SimulationError) else tried.error
                h, control = control.after_rejected(error, h)
                continue
            try:
                before, point = point, run.accept(point, t, tried.step)
            except TurnsUntold as untold:
                run.tally.reject_accepted()
                h = untold.step
                continue
            last = bisect_left(times, t, done)
            if last > done:
                yield from self.in_between(before, point, tried.step, times[done:last])
            if last < len(times) and times[last] == t:
                yield point.sample(run.exact, tried.step.h, run.tally)
                last += 1
            done = last
            h, control = control.after_accepted(tried.error, tried.step.h)
            if run.breaks.is_at(t) and t < run.end:
                (point, h), control = self.go_on(point), self.forgetful

    def shortest(self, t: float) -> float:
        """Return the shortest step from t that is tried. Kinematic steps become ever shorter towards a turning point.
        They end here at a small part of the interval of samples; the kernel follows them further."""
        if self.run.exact.settings.kinematic is True:
            return max(THRESHOLDS.fewest_grains * self.run.grain(t), THRESHOLDS.turning_step * self.run.interval)
        return THRESHOLDS.fewest_grains * self.run.grain(t)

    @property
    def forgetful(self) -> StepSizeController:
        """A controller without memory, for a first step."""
        return StepSizeController(self.run.stepper.error_order)

    def go_on(self, point: Point) -> tuple[Point, float]:
        """Return the point evaluated from the right side of a break, and a new step size."""
        point = self.run.cross_break(point)
        return point, self.first_step(self.run.inside, point, self.way_left(point.t))

    def way_left(self, t: float) -> float:
        """Return the time from t to where steps must end."""
        return min(self.run.breaks.next, self.run.end) - t

    def target(self, h: float, t: float) -> tuple[float, float]:
        """Return the size of the next step from t, at most h, and its end."""
        left = self.way_left(t)
        self.run.shaped = self.run.shaped or (self.run.is_before_end and 2.0 * h > left)
        size = _fitted(h, left)
        return size, min(self.run.breaks.next, self.run.end) if size == left else t + size

    def first_step(self, formulation: FullFormulation, point: Point, longest: float) -> float:
        """Return an initial step size at a point."""
        self.run.tally.count_evaluations(1)
        f, order = formulation.watched_derivative, self.run.stepper.order
        h, limited = first_step(
            f, order, point.t, point.y, point.slope(formulation), self.tolerance, self.scale, longest
        )
        self.run.shaped = self.run.shaped or (limited and self.run.is_before_end)
        return max(h, THRESHOLDS.fewest_grains * self.run.grain(point.t))  # round-off of y may require a shorter one

    def attempt(self, point: Point, h: float, t: float) -> _Tried:
        """Return a step from a point over h to t, or the error that its equations have no solution. A step that is too
        large may lead to where a function has no value, or to overflow."""
        run, stepper = self.run, self.run.stepper
        run.inside.policy.begin()
        run.tally.count_evaluations(stepper.attempt_cost + stepper.error_cost)
        try:
            with may_overflow():
                step = attempted(stepper, run.inside, point, h, watched=True)
                step, estimates = stepper.error(Slopes(run.inside, watched=True), t, step)
                error = self.norm(step, estimates)
        except SimulationError as lost:
            return lost
        return _Attempt(step, error) if np.isfinite(error) else not_finite(t)

    def norm(self, step: Step, estimates: Array) -> float:
        """Return the norm of estimates of a step's error: 1 is just acceptable. Estimates of a kinematic step are
        relative already."""
        if step.stages is not None:
            return error_norm(estimates, np.zeros(1), np.zeros(1), self.tolerance, np.ones(1))
        return error_norm(estimates, step.y, step.y_new, self.tolerance, self.scale)

    def in_between(self, before: Point, after: Point, step: Step, times: Sequence[float]) -> Iterator[Sample]:
        """Yield samples inside a step: values of the extension, projected. The integration goes on from values that are
        not projected."""
        self.run.tally.count_evaluations(self.run.stepper.extend_cost + len(times))
        formulation, system, stepper = self.run.inside, self.run.inside.system, self.run.stepper
        extension = stepper.extend(Slopes(formulation), step)
        for t in times:
            y, projected = formulation.project_copy(t, formulation.lead(t, extension.at((t - step.t) / step.h)))
            q, v, expected = formulation.split(y)
            position, _ = formulation.violations(t, q, v, expected)
            if not is_closed(formulation, position, projected):
                raise left_open_at(formulation, t, position, projected)
            coordinate, speed = coordinates(system, q, v)
            if not len(expected):
                expected = before.turning.between(system, after.turning, t, drive_at(system, t))
            turning = Turning(t, near(system, coordinate, expected), speed, after.turning.prescribed)
            yield point_at(formulation, y, coordinate, turning).sample(formulation, step.h, self.run.tally)


def _fitted(h: float, left: float) -> float:
    """Return h, or the rest `left` to where steps must end, or half of the rest where one more step would be tiny."""
    if h >= left:
        return left
    return 0.5 * left if 2.0 * h > left > 1.01 * h else h
