"""The target of a match: a quantity of the run, and the values with which it is compared."""

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
#: The search for the point of a curve nearest to a given one: the number of places for each interval of samples, the
#: number of Newton's steps from the best place, and their differences as a part of the distance of two places.
FINER, NEWTON, ASIDE = 8, 6, 1e-3
#: The number of halvings of an interval in which a coordinate passes a value.
SHRINKS = 45
TURN = 2.0 * np.pi


@dataclass(frozen=True, eq=False)
class Target:
    """N points `values` (N, k) of k `measures` in `unit`, over `abscissa` (N,): times in s, or values of the joint
    coordinate `over`. Over a "path" the points belong to no particular time. A residual is divided by `deviation`, and
    its square has the weight `weight`."""

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
    def needed(self) -> tuple[Expectation, ...]:
        """The measures that a run must record for this target."""
        if self.over in (TIME, PATH):
            return self.measures
        joint, _, coordinate = self.over.partition(".")
        along = Expectation(self.over, "joint", joint, coordinate, COORDINATES[coordinate], "", "end", "")
        return (*self.measures, along)

    def reached(self, samples: SampleSource) -> Array | None:
        """Return the run's values at the abscissa, (N, k); None where the coordinate does not pass all of it."""
        time, events = samples["time"], samples.event_times
        curve = np.concatenate([components(each, series(each, samples)) for each in self.measures], axis=1)
        if self.over == TIME:
            return between(time, curve, events, np.minimum(self.abscissa, time[-1]))
        if self.over == PATH:
            return _nearest(time, curve, events, self.values)
        when = _passages(time, series(self.needed[-1], samples)[:, 0], events, self.abscissa, self.needed[-1].unit)
        return None if when is None else between(time, curve, events, when)

    def residuals(self, samples: SampleSource) -> Array | None:
        """Return (run - values) / deviation × √weight, (k N,), measure by measure; None where the coordinate does not
        pass all values."""
        reached = self.reached(samples)
        if reached is None:
            return None
        return np.asarray((reached - self.values).T.ravel() * (self.weight**0.5 / self.deviation))


def _nearest(time: Array, curve: Array, events: Array, points: Array) -> Array:
    """Return the points (N, k) of a curve (T, k) nearest to given points."""
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
    """Return the times at which the coordinate (T,) first passes the values (N,), angles modulo a turn; None where it
    does not pass all."""
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
