"""Checks the steps of the full formulation for conditions that halt a run: gaps that are closed within a step, or open
again, contacts that would pull, sliding that comes to rest, sticking friction that gives way. The run halts before such
a step; `mbproj.integrate.stops` finds the time, and continues from there."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import State
from mbproj.integrate.events.halts import (
    Ends,
    Halted,
    HaltedAt,
    Watched,
    closed_inside,
    least_watched,
    resting,
    watched_gaps,
    watched_rows,
)
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.point import Point


class StopWatch:
    """Checks the steps of a run in the full formulation for conditions that halt it."""

    def __init__(self, formulation: FullFormulation, watched: Watched) -> None:
        self._formulation, self._system, self._watched = formulation, formulation.system, watched

    def take(self, before: Point, point: Point, *, shaped: bool) -> None:
        """Check a step, which the run's end has influenced (`shaped`) or not. Raises Halted where a condition is
        met."""
        h, first, last = point.t - before.t, self._look(before), self._look(point)
        watched, λ = self._watched, point.found.multipliers[self._system.bodies :]
        slack = np.array([each.slack + each.idle for each in watched.gaps])
        met = bool((least_watched(watched, first, last, h) < -slack).any())
        met = met or resting(watched, first, last, h) is not None or self._closes_inside(before, point, first, last)
        if met or self._gives_way(point.state(self._formulation), λ) or self._gives_way_inside(before, point):
            work = before.y[self._formulation.layout["quadratures"]]
            raise Halted(HaltedAt(before.state(self._formulation), h, work, shaped))

    def _gives_way(self, state: State, multipliers: Array) -> bool:
        """Return whether a force is beyond its bound at a state."""
        force = watched_rows(self._system, self._watched, state, multipliers)
        return bool((force < -np.array([each.slack for each in self._watched.rows])).any())

    def _closes_inside(self, before: Point, point: Point, first: Ends, last: Ends) -> bool:
        """Return whether a gap closes and opens again within a step."""
        formulation, h, stops = self._formulation, point.t - before.t, self._system.stops
        turns = before.turns(formulation)
        which = [each.stop for each in self._watched.gaps if not each.of_rate]
        if stops is None or not which:
            return False
        turning = np.array([not each.of_rate and stops.counts_turns[each.stop] for each in self._watched.gaps])

        def at(x: float) -> Ends:
            y = self._inside(before, point, x)
            value, rate = watched_gaps(self._system, self._watched, formulation.state(before.t + x * h, y, turns))
            a = x * x * (3.0 - 2.0 * x)
            expected = (1.0 - a) * first[0] + a * last[0] + h * x * (1.0 - x) * ((1.0 - x) * first[1] - x * last[1])
            return value + 2.0 * np.pi * turning * np.round((expected - value) / (2.0 * np.pi)), rate

        return any(True for _ in closed_inside(self._watched, at, first, last, h))

    def _inside(self, before: Point, point: Point, x: float) -> Array:
        """Return y on the cubic through both ends of a step."""
        first, last = (each.slope(self._formulation) for each in (before, point))
        a = x * x * (3.0 - 2.0 * x)
        slopes = (point.t - before.t) * x * (1.0 - x) * ((1.0 - x) * first - x * last)
        return np.asarray((1.0 - a) * before.y + a * point.y + slopes)

    def _gives_way_inside(self, before: Point, point: Point) -> bool:
        """Return whether a force is beyond its bound within a step, at states on the cubic through both ends."""
        formulation, h = self._formulation, point.t - before.t
        turns = before.turns(formulation)
        for x in self._watched.looks(h):
            a, y = x * x * (3.0 - 2.0 * x), self._inside(before, point, x)
            coordinate = before.turning.coordinate + a * (point.turning.coordinate - before.turning.coordinate)
            found = formulation.accelerations(before.t + x * h, y, coordinate)
            if self._gives_way(formulation.state(before.t + x * h, y, turns), found.multipliers[self._system.bodies :]):
                return True
        return False

    def _look(self, point: Point) -> tuple[Array, Array]:
        """Return the watched gaps with their signs, and their rates."""
        return watched_gaps(self._system, self._watched, point.state(self._formulation))
