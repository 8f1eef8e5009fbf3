"""The expectations of a scene, checked on the results of its run.

The time at which a joint coordinate first passes a value is that of a polynomial through neighbouring samples. So are
the values of curves there. These polynomials do not cross an event.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from math import inf
from typing import Any, NamedTuple

import numpy as np

from mbproj.analysis.observed import SampleSource, is_unique, ratio_of, series, speeds
from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.results import Results
from mbproj.results.loads.between_samples import between
from mbproj.scene.records import Expectation, Passage
from mbproj.scene.sampling import SAME_TIME

BISECTIONS = 60
#: A sample counts as at the value where it differs by at most this part of the largest value.
AT = 1e-12
TURN = 2.0 * np.pi


def passed(passage: Passage, time: Array, coordinate: Array, events: Array) -> float | None:
    """The time at which the coordinate (T,) first has the value, angles modulo a turn; None where it never has it."""
    turn = TURN if passage.unit == "rad" else np.inf
    apart = coordinate - passage.value
    whole = np.zeros_like(apart) if np.isinf(turn) else turn * np.round(apart / turn)
    size = max(float(np.abs(coordinate).max(initial=0.0)), abs(passage.value), 1e-300)
    met = np.flatnonzero(np.abs(apart - whole) <= AT * size)
    side = (apart > 0.0).astype(float) if np.isinf(turn) else np.floor(apart / turn)
    crossed = np.flatnonzero(side[1:] != side[:-1])
    first = [int(met[0])] if len(met) else []
    if len(crossed) and (not first or crossed[0] + 1 < first[0]):
        before = int(crossed[0])
        target = passage.value + (0.0 if np.isinf(turn) else turn * max(side[before], side[before + 1]))
        return _root(time, coordinate - target, before, events)
    return float(time[first[0]]) if first else None


def _root(time: Array, values: Array, before: int, events: Array) -> float:
    """The time of the sign change after the sample `before`, on the polynomial through neighbouring samples."""
    low, high = float(time[before]), float(time[before + 1])
    sign = values[before] > 0.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if (curves_at(time, values[:, None], middle, events)[0] > 0.0) == sign:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def curves_at(time: Array, values: Array, when: float, events: Array) -> Array:
    """The values (k,) of curves (T, k) at a time `when` between two samples."""
    return between(time, values, events, np.array([when]))[0]


@dataclass(frozen=True)
class Outcome:
    """An expectation and the measured value, in the unit of the expectation. `measured` holds its components, at the
    time `time` (s); both are None where the run has no such sample. `error` is the largest deviation of a component; a
    bound has none. `unique` is False for a reaction that redundant joints share arbitrarily."""

    expectation: Expectation
    measured: tuple[float, ...] | None = None
    time: float | None = None
    error: float | None = None
    unique: bool = True

    @property
    def checked(self) -> bool:
        """Whether there was a sample to check."""
        return self.measured is not None

    @property
    def holds(self) -> bool:
        """Whether the expectation is met. NaN and a missing sample never meet one."""
        return self.share <= 1.0

    @property
    def share(self) -> float:
        """The part of the allowed error that is used: above 1 where the expectation is not met, infinite without a
        sample. For a bound, it is the value over the bound where both have one sign."""
        expected, measured = self.expectation, self.measured
        if measured is None:
            return inf
        if expected.tolerance is not None:
            assert self.error is not None
            return self.error / expected.tolerance
        if expected.below is not None:
            return _share_of_bound(measured[0], expected.below)
        assert expected.above is not None
        return _share_of_bound(-measured[0], -expected.above)


def _share_of_bound(number: float, bound: float) -> float:
    """The part of a bound that a number reaches: above 1 where the number is beyond the bound or NaN."""
    share = number / bound if bound > 0.0 else 0.0
    if number <= bound:
        return max(share, 0.0)
    return share if share > 1.0 else inf


def outcomes(expectations: Iterable[Expectation], results: Results) -> list[Outcome]:
    """The outcomes of all expectations, in their order."""
    duration = results.settings.duration
    return [_outcome(expectation, results, duration) for expectation in expectations]


def _outcome(expectation: Expectation, results: Results, duration: float | None) -> Outcome:
    measurement = measured(expectation, results, duration)
    if measurement is None:
        return Outcome(expectation)
    values, time, unique = measurement.values, measurement.time, is_unique(expectation, results)
    if expectation.value is None:
        return Outcome(expectation, _plain(values), time, unique=unique)
    exact = np.array(expectation.value)
    if expectation.quantity == "orientation" and values @ exact < 0.0:  # q and -q are the same orientation
        values = -values
    return Outcome(expectation, _plain(values), time, float(np.abs(values - exact).max()), unique)


class MeasuredValue(NamedTuple):
    """The measured components (k,), and the time (s) of their sample."""

    values: Array
    time: float


def measured(expectation: Expectation, samples: SampleSource, duration: float | None) -> MeasuredValue | None:
    """Measure what an expectation names in the samples of a run over `duration` (s); None where they have no sample at
    its time."""
    time = samples["time"]
    if not len(time):
        return None
    values = components(expectation, series(expectation, samples))
    if isinstance(expectation.at, Passage):
        return _at_passage(expectation, expectation.at, samples, values)
    row = _row(expectation, time, values, duration)
    return None if row is None else MeasuredValue(values[row], float(time[row]))


def _at_passage(
    expectation: Expectation, passage: Passage, samples: SampleSource, values: Array
) -> MeasuredValue | None:
    """Measure between samples, where a coordinate first passes its value; None where it never does. A ratio has poles,
    so its two speeds are interpolated."""
    time, column = samples["time"], list(samples.names("coordinates")).index(passage.coordinate)
    coordinate = samples["joints/coordinate"][:, column]
    events = samples.event_times
    when = passed(passage, time, coordinate, events)
    if when is None:
        return None
    if expectation.over:
        pair = curves_at(time, speeds(expectation, samples), when, events)
        return MeasuredValue(ratio_of(expectation, pair[None]), when)
    return MeasuredValue(curves_at(time, values, when, events), when)


def components(expectation: Expectation, values: Array) -> Array:
    """The columns (T, k) that the expectation names. They are absolute values for the largest magnitude, and
    differences from the least value for the range."""
    if expectation.component == "norm":
        return np.linalg.norm(values, axis=1, keepdims=True)
    chosen = values[:, ["xyz".index(expectation.component)]] if expectation.component else values
    if expectation.at == "range":
        return np.asarray(chosen - chosen.min(axis=0))
    return np.abs(chosen) if expectation.at == "largest" else chosen


def _row(expectation: Expectation, time: Array, values: Array, duration: float | None) -> int | None:
    """The number of the sample to measure; None where there is none at that time. A NaN counts as the largest and the
    smallest number."""
    moment = expectation.at
    assert not isinstance(moment, Passage)
    if isinstance(moment, str):
        pick: Mapping[str, Callable[[], Any]] = {
            "end": lambda: len(time) - 1,
            "maximum": lambda: np.argmax(values[:, 0]),
            "minimum": lambda: np.argmin(values[:, 0]),
            "largest": lambda: np.argmax(values[:, 0]),
            "range": lambda: np.argmax(values[:, 0]),
        }
        return int(pick[moment]())
    nearest = int(np.argmin(np.abs(time - moment)))
    return nearest if abs(time[nearest] - moment) <= SAME_TIME * (duration or time[-1]) else None


def _plain(values: Array) -> tuple[float, ...]:
    return tuple(float(value) for value in values)
