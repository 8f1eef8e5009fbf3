"""State events: where a switch changes its branch within a step, the step is repeated so that it ends there. Fixed
steps pass over a switch from which the motion is pushed back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers
from mbproj.errors import SimulationError
from mbproj.integrate.events.crossing import Crossing, first_crossing
from mbproj.integrate.events.law_switches import LawSwitches
from mbproj.integrate.formulations.stage_equations import StageEquations
from mbproj.integrate.loop.passes import Passes
from mbproj.integrate.loop.run import Run
from mbproj.integrate.point import Point
from mbproj.integrate.reporting.failures import pushed_back
from mbproj.integrate.steppers.implicit_runge_kutta import ImplicitRungeKutta
from mbproj.integrate.steppers.runge_kutta import Step, cubic
from mbproj.thresholds import THRESHOLDS

#: A switch that changes its branch this often at one time is pushed back from both sides.
MOST_AT_ONCE = 3


class StateEvents:
    """Scratch of a run: its switches, the branches that are held, and how often each switch has changed its branch at
    one time."""

    def __init__(self, run: Run, switches: LawSwitches, tolerance: float = 0.0, passes: Passes | None = None) -> None:
        self.run, self.switches, self.held = run, switches, switches.free
        self._tolerance, self._passes = tolerance, passes
        self._last = np.full(switches.size, -np.inf)
        self._at_once, self._in_a_row = np.zeros((2, switches.size), dtype=int)

    def slack(self, t: float, h: float) -> float:
        """Return the tolerance within which a step of size h to t ends at an event, in s."""
        return max(THRESHOLDS.located * self._tolerance * h, 4.0 * self.run.grain(t))

    def first(self, step: Step, *, estimated: bool = True) -> Crossing | None:
        """Return the first crossing in a step. A crossing at which no step can end is at its start. Where no error was
        `estimated`, the path is the cubic through both ends."""
        run, h = self.run, step.h
        if estimated or isinstance(run.stepper, ImplicitRungeKutta):
            run.tally.count_evaluations(run.stepper.extend_cost)
            extension = run.stepper.extend(StageEquations(run.inside), step)
        else:
            run.tally.count_evaluations(1)
            extension = cubic(step, run.inside.derivative(step.t + h, step.y_new))

        def path(theta: float) -> Array:
            return self._arguments(step.t + theta * h, extension.at(theta))

        grain = run.grain(step.t + h)
        return first_crossing(path, self.switches.bounds(self.held), self.slack(step.t + h, h) / h, 16.0 * grain / h)

    def excess(self, crossing: Crossing, t: float, y: Array) -> float:
        """Return the excess of a crossing's leader beyond its interval."""
        return float(self.switches.bounds(self.held).excess(self._arguments(t, y))[crossing.leader])

    def cross(self, point: Point, crossing: Crossing, h: float) -> Point:
        """Return the point with the branches beyond a crossing. Raises SimulationError where these lead back."""
        for k in np.flatnonzero(crossing.leaving):
            if self._gives_up(point.t, int(k)):
                continue
            self.run.tally.met.append(self.switches.event(point.t, int(k), int(crossing.direction[k])))
        held = self.switches.crossed(self.held, crossing.leaving, crossing.direction)
        return self._passed_to(held, point, h, crossing.leaving * crossing.direction)

    def next_try(self, crossing: Crossing, step: Step, at: float, whole: float, end: float) -> float | None:
        """Return when a step over `whole` to `end`, repeated to `at`, should end, by Newton's method; None where it
        ends at the crossing already, or where the method does not lead there."""
        rate = crossing.rate / whole
        excess = self.excess(crossing, at, step.y_new)
        if not rate * self.slack(end, whole) < abs(excess) < THRESHOLDS.widest_polishing * rate * whole:
            return None
        return min(at - excess / rate, end)

    def cross_break(self, point: Point, h: float) -> Point:
        """Return the point after a break, where functions of time are evaluated from the other side. Arguments that
        jump there move to the branch at their new value; at the start of a run all arguments do."""
        before, seen = self._arguments(point.t, point.y), self.run.exact
        self.run.pass_break(point.t)
        was, point = point, self.run.acted(point)
        after = self._arguments(point.t, point.y)
        outside = self.switches.bounds(self.held).excess(after) > 0.0
        self._hold(self._settled(self.switches.freed(self.held, outside & (after != before)), after))
        return self._turned(self.run.renewed(point, seen, was), h)

    def tell(self, point: Point) -> None:
        """Decide signs that were open before a step, for arguments that have moved in it."""
        if self._untold().any():
            self._hold(self._settled(self.held, self._arguments(point.t, point.y)))

    def save(self) -> dict[str, Any]:
        """Return the data on which the next step depends, as plain data."""
        counts = {"at_once": self._at_once.tolist(), "in_a_row": self._in_a_row.tolist()}
        return {"held": self.held.tolist(), "last": self._last.tolist(), **counts}

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Continue from saved data."""
        self._last = np.array(saved["last"], dtype=float)
        self._at_once, self._in_a_row = (np.array(saved[name], dtype=int) for name in ("at_once", "in_a_row"))
        self._hold(np.array(saved["held"], dtype=float))

    def _turned(self, point: Point, h: float) -> Point:
        """Return the point with the sign held, of two at an edge, to which the motion turns."""
        free = self._untold()
        if not free.any():
            return point
        direction = np.where(free, np.sign(self._moves(point, h)), 0.0)
        return self._passed_to(self.switches.turned_to(self.held, direction != 0.0, direction), point, h, direction)

    def _passed_to(self, held: Array, point: Point, h: float, direction: Integers | Array) -> Point:
        """Return a point with other branches. Raises SimulationError where a switch moved in a direction before and is
        pushed back after."""
        before, seen = self._moves(point, h), self.run.inside
        while True:
            direction = direction * ~self._given_up
            self._hold(self.switches.freed(held, self._given_up))
            found = self.run.renewed(point, seen)
            back = np.flatnonzero((direction * before > 0.0) & (direction * self._moves(found, h) < 0.0))
            if not len(back):
                return found
            if self._passes is None:
                raise self._pushed_back(point.t, int(back[0]))
            self._passes.give_up(int(back[0]), point.t)

    def _gives_up(self, t: float, k: int) -> bool:
        """Count a change of a switch's branch. Return whether it is passed over from now on, because it changes too
        often. Raises SimulationError where none can be passed over."""
        since, run = t - self._last[k], self.run
        self._at_once[k] = self._at_once[k] + 1 if since <= 4.0 * run.grain(t) else 1
        self._in_a_row[k] = self._in_a_row[k] + 1 if since <= THRESHOLDS.chatter * run.interval else 1
        self._last[k] = t
        if self._at_once[k] < MOST_AT_ONCE and self._in_a_row[k] < THRESHOLDS.most_chatter:
            return False
        if self._passes is None:
            raise self._pushed_back(t, k)
        self._passes.give_up(k, t)
        return True

    @property
    def _given_up(self) -> npt.NDArray[np.bool_]:
        return np.zeros(self.switches.size, dtype=bool) if self._passes is None else self._passes.which

    def _untold(self) -> npt.NDArray[np.bool_]:
        """Whether each switch has no branch yet, but will have one."""
        found: npt.NDArray[np.bool_] = self.switches.is_free(self.held) & ~self._given_up
        return found

    def _settled(self, held: Array, x: Array) -> Array:
        """Return the branches with those at x for switches that are free and not passed over."""
        return self.switches.freed(self.switches.settled(held, x), self._given_up)

    def _moves(self, point: Point, h: float) -> Array:
        """Return the change of the arguments along the slope of a point, over a small part of a step, (K,)."""
        y = point.y + THRESHOLDS.glance * h * point.slope(self.run.inside)
        return self._arguments(point.t, y) - self._arguments(point.t, point.y)

    def _pushed_back(self, t: float, k: int) -> SimulationError:
        return pushed_back(t, self.switches.owner(k), self.switches.what(k), jumps=self.switches.jumps(k))

    def _hold(self, held: Array) -> None:
        self.held = held
        self.run.hold(held)

    def _arguments(self, t: float, y: Array) -> Array:
        return self.run.inside.arguments(self.switches, self.held, t, y)
