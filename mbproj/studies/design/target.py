"""What a design is to match: a quantity of the run, and the numbers that it is held against."""

from __future__ import annotations

import numpy as np

from mbproj.analysis.expectations import components
from mbproj.analysis.observed import SampleSource, series
from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.results.loads.between_samples import between
from mbproj.scene.blocks.coordinates import COORDINATES
from mbproj.scene.records import Expectation

TIME, PATH = "time", "path"
#: Between samples a curve is looked at in so many places for the one next to a point. From there Newton's method takes
#: so many steps, with differences over this part of the distance of two places.
FINER, NEWTON, ASIDE = 8, 6, 1e-3
#: A span in which a coordinate has a value is halved so often.
SHRINKS = 45
TURN = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class Target:
    """N points `values` (N, k) of k `measures` in `unit`, over `abscissa` (N,): times in s, or values of the joint
    coordinate `over`. Over a "path" they are points of no particular time. A residual is in parts of `deviation`, and
    counts `weight` times."""

    name: str
    measures: tuple[Expectation, ...]
    unit: str
    over: str
    abscissa: Array
    values: Array
    deviation: float
    weight: float
    source: str

    @property
    def watched(self) -> tuple[Expectation, ...]:
        """What a run has to record for it."""
        if self.over in (TIME, PATH):
            return self.measures
        joint, _, coordinate = self.over.partition(".")
        along = Expectation(self.over, "joint", joint, coordinate, COORDINATES[coordinate], "", "end", "")
        return (*self.measures, along)

    def reached(self, samples: SampleSource) -> Array | None:
        """What the run has in the place of each value, (N, k); None where the coordinate never gets there."""
        time, events = samples["time"], samples.event_times
        curve = np.concatenate([components(each, series(each, samples)) for each in self.measures], axis=1)
        if self.over == TIME:
            return between(time, curve, events, np.minimum(self.abscissa, time[-1]))
        if self.over == PATH:
            return _nearest(time, curve, events, self.values)
        when = _passages(time, series(self.watched[-1], samples)[:, 0], events, self.abscissa, self.watched[-1].unit)
        return None if when is None else between(time, curve, events, when)

    def residuals(self, samples: SampleSource) -> Array | None:
        """How far the run is from the values, (k N,), in parts of the deviation, times the root of the weight: those of
        one measure after those of another."""
        reached = self.reached(samples)
        if reached is None:
            return None
        return np.asarray((reached - self.values).T.ravel() * (self.weight**0.5 / self.deviation))


def _nearest(time: Array, curve: Array, events: Array, points: Array) -> Array:
    """The points (N, k) of a curve (T, k) that are nearest to given ones."""
    fine = np.linspace(time[0], time[-1], FINER * (len(time) - 1) + 1)
    there = between(time, curve, events, fine)
    best = np.argmin(np.sum((there[None] - points[:, None]) ** 2, axis=2), axis=1)
    low, high = fine[np.maximum(best - 1, 0)], fine[np.minimum(best + 1, len(fine) - 1)]
    when, aside = fine[best], ASIDE * (fine[1] - fine[0])
    for _ in range(NEWTON):
        before, after = np.maximum(when - aside, time[0]), np.minimum(when + aside, time[-1])
        places = between(time, curve, events, np.concatenate([before, 0.5 * (before + after), after]))
        first, middle, last = places.reshape(3, *points.shape)
        rate, off = (last - first) / (after - before)[:, None], middle - points
        bend = (first - 2.0 * middle + last) / (0.5 * (after - before))[:, None] ** 2
        square = np.sum(rate**2, axis=1)
        slope = square + np.sum(off * bend, axis=1)
        step = np.sum(off * rate, axis=1) / np.where(slope > 0.1 * square, slope, np.maximum(square, 1e-300))
        when = np.clip(0.5 * (before + after) - step, low, high)
    nearest = between(time, curve, events, when)
    nearer = np.sum((nearest - points) ** 2, axis=1) <= np.sum((there[best] - points) ** 2, axis=1)
    return np.where(nearer[:, None], nearest, there[best])


def _passages(time: Array, coordinate: Array, events: Array, wanted: Array, unit: str) -> Array | None:
    """When the coordinate (T,) first passes values (N,), angles modulo a turn; None where it never passes one."""
    values = wanted
    if unit == "rad":
        low, high = coordinate.min(), coordinate.max()
        values = wanted + TURN * (np.ceil((low - wanted) / TURN) if coordinate[-1] >= coordinate[0] else 0.0)
        if coordinate[-1] < coordinate[0]:
            values = wanted + TURN * np.floor((high - wanted) / TURN)
    apart = coordinate[None] - values[:, None]
    crosses = (apart[:, 1:] >= 0.0) != (apart[:, :-1] >= 0.0)
    met = np.isclose(apart, 0.0, rtol=0.0, atol=1e-12 * max(float(np.abs(coordinate).max()), 1.0))
    first_cross = np.where(crosses.any(axis=1), np.argmax(crosses, axis=1), len(time))
    first_met = np.where(met.any(axis=1), np.argmax(met, axis=1), len(time))
    if np.any(np.minimum(first_cross, first_met) == len(time)):
        return None
    cross = np.minimum(first_cross, len(time) - 2)
    low, high = time[cross], time[cross + 1]
    rising = apart[np.arange(len(values)), cross] < 0.0
    for _ in range(SHRINKS):
        middle = 0.5 * (low + high)
        below = between(time, coordinate[:, None], events, middle)[:, 0] < values
        low, high = np.where(below == rising, middle, low), np.where(below == rising, high, middle)
    at_sample = first_met <= first_cross
    return np.where(at_sample, time[np.minimum(first_met, len(time) - 1)], 0.5 * (low + high))
