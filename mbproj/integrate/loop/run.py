"""The common part of stepping with fixed steps and with error control: the run's data, and the end of a step."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from mbproj.errors import SimulationError
from mbproj.integrate.events.breaks import BreakCursor
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.loop.interruption import look
from mbproj.integrate.loop.step_end import accept
from mbproj.integrate.point import Point, acted
from mbproj.integrate.reporting.failures import of_a_rope
from mbproj.integrate.reporting.marks import Mark, Marks, restore_tally, saved_tally
from mbproj.integrate.reporting.tally import RowsKept, Tally
from mbproj.integrate.steppers.runge_kutta import Step
from mbproj.integrate.steppers.tableau import stepper_of


class Run:
    """The data of one run from `start`, some of which change from step to step. `exact` evaluates functions of time at
    the time itself, `inside` within the window of the current step."""

    def __init__(self, formulation: FullFormulation, leg: Leg, tally: Tally, marks: Marks) -> None:
        self.leg, self.start, self.end, self.tally = leg, leg.start, leg.end, tally
        self.stepper = stepper_of(formulation.settings.integrator, kinematic=formulation.settings.kinematic is True)
        #: The time between two samples, in s.
        self.interval = leg.interval
        self.breaks = BreakCursor(leg.breaks, leg.start, self.interval)
        self.exact, self.inside = formulation, formulation.seen_within(self.breaks.window)
        #: Whether the run's end has influenced a step: a longer run might make another one.
        self.shaped = False
        self.newest: Point | None = None
        self._marks, self._mark = marks, marks.resumed
        marks.newest = lambda: self._mark

    def mark(self, point: Point, **rest: Any) -> None:
        """Record the mark before a step, from which a longer run can continue, unless the run's end has influenced the
        way here. `rest` is the caller's part of it."""
        if self._marks.wanted and not self.shaped:
            policy, balance = self.exact.policy.save(), self.exact.balance
            kept = {} if balance is None else {"kept": balance.kept.save()}
            self._mark = {**point.save(), **saved_tally(self.tally), "policy": policy, **kept, **rest}

    def resume(self, mark: Mark) -> Point:
        """Return the point from which a run continues. Raises ValueError for a mark of another system."""
        point, system = Point.restore(mark), self.exact.system
        layout, coordinates = self.exact.layout, system.coordinates.size
        fits = (
            (point.y, layout.size),
            (point.found.acceleration, layout.size_of("velocities")),
            (point.found.multipliers, system.constraints),
            (point.found.power, layout.size_of("quadratures")),
            (point.coordinate, coordinates),
            (point.turning.coordinate, coordinates),
            (point.turning.speed, coordinates),
            (point.turning.prescribed, system.driven),
        )
        for array, size in fits:
            if array.shape != (size,) or not np.isfinite(array).all():
                raise ValueError(f"an array of {size} numbers is not there")
        restore_tally(self.tally, mark)
        self.exact.policy.restore(mark["policy"])
        if self.exact.balance is not None:
            self.exact.balance.kept.restore(mark["kept"])
        self.pass_break(point.t)
        self.breaks.take_actions()  # these were done before the mark
        return point

    def grain(self, t: float) -> float:
        """Return the resolution of times near t, and near the next sample."""
        return float(np.finfo(float).eps * max(abs(t), self.interval))

    @property
    def is_before_end(self) -> bool:
        """Whether the next end of steps is the run's end."""
        return not self.breaks.next < self.end

    def accept(self, before: Point, t: float, step: Step) -> Point:
        """Return the point after a step. At a break it is evaluated at the time itself, as it is recorded."""
        look()
        self.newest = before
        at_end = self.exact if self.breaks.is_at(t) else self.inside
        point = accept(self.inside, at_end, self.stepper, self.tally, before, t, step)
        if self.exact.balance is not None:
            self.tally.rows = RowsKept.of(self.exact.balance.kept.save())
        self.newest = point
        return point

    def why(self, failure: SimulationError) -> SimulationError:
        """Return the error for which the run cannot go on from its newest point."""
        if self.newest is None:
            return failure
        return of_a_rope(self.exact.system, self.newest.state(self.exact), self.leg.step or 0.0, failure)

    def pass_break(self, t: float) -> None:
        """Pass a break: functions of time are evaluated from its other side from here on."""
        self.breaks.pass_break(t)
        self.inside = self.exact.seen_within(self.breaks.window)

    def cross_break(self, point: Point) -> Point:
        """Return the point at a break as it is evaluated from the other side."""
        self.pass_break(point.t)
        point = acted(self.inside, self.breaks.take_actions(), point)
        if self.exact.balance is not None:
            self.exact.balance.begin(self.inside, point.t, point.y)
        self.tally.count_evaluations(1)
        accelerations = self.inside.accelerations(point.t, point.y, point.turning.coordinate)
        self.inside.policy.keep(accelerations.multipliers)
        return replace(point, found=accelerations)
