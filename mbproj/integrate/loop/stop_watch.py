"""Looks for stops that a step of the full formulation has met: gaps that are closed within it, or that open again, and
contacts that would pull. The run halts before such a step; `mbproj.integrate.stops` finds the time, and what happens
then."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.turning import turns_of
from mbproj.integrate.events.halts import Halted, HaltedAt, Watched, least, watched_gaps
from mbproj.integrate.point import Point
from mbproj.model.system import System


class StopWatch:
    """Looks at the steps of a run in the full formulation."""

    def __init__(self, system: System, watched: Watched) -> None:
        self._system, self._watched = system, watched

    def take(self, before: Point, point: Point) -> None:
        """A step was made. Raises Halted where it has met something."""
        h, first, last = point.t - before.t, self._look(before), self._look(point)
        slack = np.array([each.slack for each in self._watched.gaps])
        met = bool((least(first, last, h) < -slack).any())
        λ = point.found.multipliers[self._system.bodies :]
        if met or any(each.sign * λ[each.row] < -each.slack for each in self._watched.rows):
            n = 14 * self._system.bodies
            work = before.y[n : n + 2] if len(before.found.power) else np.zeros(2)
            raise Halted(HaltedAt(self._state(before), h, work))

    def _state(self, point: Point) -> State:
        system, n = self._system, 7 * self._system.bodies
        turns = turns_of(system, point.turning.coordinate, point.coordinate)
        return State(point.t, point.y[:n], point.y[n : 2 * n], turns)

    def _look(self, point: Point) -> tuple[Array, Array]:
        """The watched gaps with their signs, and their rates."""
        return watched_gaps(self._system, self._watched, self._state(point))
