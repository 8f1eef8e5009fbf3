"""The time loop: step, project, check, record; with a fixed step, or with the step that the error allows. Steps end at
the breaks of a run."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array, may_overflow
from mbproj.dynamics.assembly.assemble import State, coordinates
from mbproj.dynamics.equations.motions import drive_at
from mbproj.dynamics.equations.teeth import near
from mbproj.dynamics.equations.turning import Turning
from mbproj.dynamics.observe.samples import Sample
from mbproj.errors import SimulationError
from mbproj.integrate.events.breaks import BreakCursor, breaks_of
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.loop.interruption import look
from mbproj.integrate.loop.step_end import accept, first_point, is_closed, left_open_at, point_at
from mbproj.integrate.loop.step_size import Controller, error_norm, first_step
from mbproj.integrate.outcome.failures import TurnsUntold, not_finite, step_vanished
from mbproj.integrate.outcome.tally import Tally
from mbproj.integrate.point import Point
from mbproj.integrate.steppers.runge_kutta import ExplicitRungeKutta, Step
from mbproj.integrate.steppers.tableau import load_tableau
from mbproj.scene.sampling import output_every, output_times, whole_steps
from mbproj.thresholds import THRESHOLDS


def march(formulation: FullFormulation, state: State, tally: Tally) -> Iterator[Sample]:
    """Samples from the start to the end of the duration. Raises SimulationError where the run cannot go on."""
    settings = formulation.settings
    end = state.t + _required(settings.duration)
    breaks = BreakCursor(breaks_of(formulation.system, state.t, settings), state.t, end)
    stepper = ExplicitRungeKutta(load_tableau(settings.integrator))
    run = _Run(formulation, stepper, tally, breaks, end)
    start = first_point(formulation, state, tally)
    yield from (run.fixed if settings.tolerance is None else run.by_error)(start)


class _Attempt(NamedTuple):
    """A step and the norm of its error."""

    step: Step
    error: float


class _Run:
    """Scratch of a run: its parts, and the formulation with the window that the step at hand sees."""

    def __init__(
        self, formulation: FullFormulation, stepper: ExplicitRungeKutta, tally: Tally, breaks: BreakCursor, end: float
    ) -> None:
        self.exact, self.stepper, self.tally, self.breaks, self.end = formulation, stepper, tally, breaks, end
        self.inside = formulation.seen_within(breaks.window)
        settings = formulation.settings
        self.tolerance, self.scale = settings.tolerance or np.inf, _absolute_scale(formulation)

    def fixed(self, point: Point) -> Iterator[Sample]:
        """Steps of one size; the time of step k is t0 + k h, so that it does not drift. The last step may be shorter,
        and one with a break in it is split."""
        settings, start = self.exact.settings, point.t
        h, steps, every = _required(settings.step), whole_steps(settings), output_every(settings)
        yield point.sample(self.exact, h, self.tally)
        point = self.cross_break(point) if self.breaks.passed else point
        for k in range(1, steps + 1):
            grid = self.end if k == steps else start + k * h
            while point.t != grid:
                t = self.breaks.next if self.breaks.cuts(grid) else grid
                step = self.stepper.attempt(self.inside.watched_derivative, point.t, point.y, t - point.t, point.slope)
                self.tally.count_evaluations(self.stepper.attempt_cost)
                point = self.accept(point, t, step)
                if t == grid and (k % every == 0 or k == steps):
                    yield point.sample(self.exact, step.h, self.tally)
                if self.breaks.is_at(t) and t < self.end:
                    point = self.cross_break(point)

    def by_error(self, point: Point) -> Iterator[Sample]:
        """Steps as large as the error estimate allows; outputs in between by the continuous extension."""
        times, done = output_times(self.exact.settings, point.t), 1
        h = self.first_step(self.exact, point, self.breaks_left(point.t))
        control, lost = Controller(self.stepper.error_order), None
        yield point.sample(self.exact, h, self.tally)
        if self.breaks.passed:
            point = self.cross_break(point)
            h = self.first_step(self.inside, point, THRESHOLDS.part_after_break * self.breaks_left(point.t))
        while done < len(times):
            if _vanishes(h, point.t, self.end):
                raise lost or step_vanished(point.t)
            h, t = self.target(h, point.t)
            tried = self.attempt(point, h, t)
            if isinstance(tried, SimulationError) or not tried.error <= 1.0:
                self.tally.rejected_steps += 1
                lost = tried if isinstance(tried, SimulationError) else None
                h, control = control.after_rejected(np.nan if isinstance(tried, SimulationError) else tried.error, h)
                continue
            try:
                before, point = point, self.accept(point, t, tried.step)
            except TurnsUntold as untold:
                self.tally.reject_accepted()
                h = untold.step
                continue
            between = times[done : bisect_left(times, t, done)]
            if between:
                yield from self.in_between(before, point, tried.step, between)
            done += len(between)
            if done < len(times) and times[done] == t:
                yield point.sample(self.exact, h, self.tally)
                done += 1
            h, control = control.after_accepted(tried.error, h)
            if self.breaks.is_at(t) and t < self.end:
                point, control = self.cross_break(point), Controller(self.stepper.error_order)
                h = self.first_step(self.inside, point, THRESHOLDS.part_after_break * self.breaks_left(point.t))

    def breaks_left(self, t: float) -> float:
        """How far it is from t to where steps must end."""
        return min(self.breaks.next, self.end) - t

    def target(self, h: float, t: float) -> tuple[float, float]:
        """The size of the next step from t, h or less, and where it ends."""
        left = self.breaks_left(t)
        size = _fitted(h, left)
        return size, min(self.breaks.next, self.end) if size == left else t + size

    def first_step(self, formulation: FullFormulation, point: Point, longest: float) -> float:
        """A step size to begin with at a point."""
        self.tally.count_evaluations(1)
        f, order = formulation.watched_derivative, self.stepper.order
        return first_step(f, order, point.t, point.y, point.slope, self.tolerance, self.scale, longest)

    def attempt(self, point: Point, h: float, t: float) -> _Attempt | SimulationError:
        """A step from a point over h to t, or why its equations have no solution: a step that is too large may lead to
        where a function has no value, or beyond what numbers can hold."""
        f = self.inside.watched_derivative
        self.inside.policy.begin()
        self.tally.count_evaluations(self.stepper.attempt_cost + 1)
        try:
            with may_overflow():
                step, estimates = self.stepper.error(f, t, self.stepper.attempt(f, point.t, point.y, h, point.slope))
                error = error_norm(estimates, step.y, step.y_new, self.tolerance, self.scale)
        except SimulationError as lost:
            return lost
        return _Attempt(step, error) if np.isfinite(error) else not_finite(t)

    def accept(self, before: Point, t: float, step: Step) -> Point:
        """The point after a step; what is recorded at a break belongs to that time itself."""
        look()
        return accept(
            self.inside, self.exact if self.breaks.is_at(t) else self.inside, self.stepper, self.tally, before, t, step
        )

    def cross_break(self, point: Point) -> Point:
        """From a break on functions of time are seen from its other side."""
        self.breaks.pass_break(point.t)
        self.inside = self.exact.seen_within(self.breaks.window)
        self.tally.count_evaluations(1)
        q, v, *_ = self.inside.parts(point.y)
        found = self.inside.accelerations(point.t, q, v, point.turning.coordinate)
        self.inside.policy.keep(found.multipliers)
        return replace(point, found=found)

    def in_between(self, before: Point, after: Point, step: Step, times: list[float]) -> Iterator[Sample]:
        """Samples inside a step: the extension's value, of which a copy is projected; the integration goes on without
        it."""
        self.tally.count_evaluations(self.stepper.extend_cost + len(times))
        formulation, system = self.inside, self.inside.system
        extension = self.stepper.extend(formulation.derivative, step)
        for t in times:
            y, projected = formulation.project_copy(t, formulation.lead(t, extension.at((t - step.t) / step.h)))
            q, v, _, expected = formulation.parts(y)
            position, _ = formulation.violations(t, q, v, expected)
            if not is_closed(formulation, position, projected):
                raise left_open_at(formulation, t, position, projected)
            coordinate, speed = coordinates(system, q, v)
            if not formulation.followed:
                expected = before.turning.between(system, after.turning, t, drive_at(system, t))
            turning = Turning(t, near(system, coordinate, expected), speed, after.turning.prescribed)
            yield point_at(formulation, y, coordinate, turning).sample(formulation, step.h, self.tally)


def _absolute_scale(formulation: FullFormulation) -> Array:
    """What the absolute tolerance is relative to, (14n + integrals,): the system's length (per s) for r (r'), 1 (per s)
    for Λ; without bound for work and dissipation, which do not steer the step."""
    scale = np.tile([formulation.system.length] * 3 + [1.0] * 4, 2 * formulation.system.bodies)
    return np.concatenate([scale, np.full(formulation.quadratures + formulation.followed, np.inf)])


def _vanishes(h: float, t: float, end: float) -> bool:
    """Whether time cannot resolve steps of this size."""
    return not h >= 16.0 * np.finfo(float).eps * max(abs(t), abs(end))


def _fitted(h: float, left: float) -> float:
    """h, or what is left to where steps must end, or half of that where one step more would be tiny."""
    if h >= left:
        return left
    return 0.5 * left if 2.0 * h > left > 1.01 * h else h


def _required(value: float | None) -> float:
    assert value is not None  # settings_to_run has seen to it
    return value
