"""The cost of settings: processor time of the thread, each setting in turn, several rounds."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from statistics import median

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.report_schema.studies import CPU_SECONDS
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import sample_times, solve
from mbproj.studies.parallel.progress import TIMING, Tell, silent
from mbproj.studies.store import ValueCache

#: A shorter run is repeated until this time (s) has passed.
SHORTEST = 15e-3
#: A first run counts as a repetition where it takes longer than this (s). In a shorter one, work that is done only once
#: would weigh too much.
LONG = 0.1
REPETITIONS = 5


@dataclass(frozen=True)
class Timing:
    """The processor time (s) of the steps of one run, from each repetition. Assembly and recording are not included."""

    samples: tuple[float, ...]

    @property
    def median(self) -> float:
        """The median of the repetitions, s."""
        return median(self.samples)

    @property
    def spread(self) -> tuple[float, float]:
        """The shortest and the longest repetition, s."""
        return min(self.samples), max(self.samples)


def timing_columns(timing: Timing | None) -> dict[str, float]:
    """The columns of a table for the median, the shortest and the longest repetition, s; NaN where nothing was
    timed."""
    seconds = (nan, nan, nan) if timing is None else (timing.median, *timing.spread)
    return dict(zip((fact.key for fact in CPU_SECONDS), seconds, strict=True))


def run_seconds(mechanism: Mechanism, setting: Setting, times: Array) -> float:
    """The processor time (s) of the steps of one run with samples at `times`; infinite where it fails."""
    report = solve(mechanism, setting, times).report
    return float("inf") if report is None else report.integration_cpu_seconds


def time_settings(
    mechanism: Mechanism,
    settings: Sequence[Setting],
    times: Array,
    repetitions: int = REPETITIONS,
    tell: Tell = silent,
) -> list[Timing]:
    """Time each setting in runs with samples at `times` (T,), s.

    Each of the `repetitions` rounds runs all settings in turn, so that a slow spell of the machine affects all alike.
    `tell` counts the rounds."""
    tell(TIMING, 0, repetitions)
    pilots = [run_seconds(mechanism, setting, times) for setting in settings]
    tell(TIMING, 0, repetitions)
    samples: list[list[float]] = [[pilot] if pilot > LONG else [] for pilot in pilots]
    for repetition in range(repetitions):
        for number, setting in enumerate(settings):
            if len(samples[number]) < repetitions:
                runs = max(1, round(SHORTEST / max(pilots[number], 1e-6)))
                samples[number].append(median(run_seconds(mechanism, setting, times) for _ in range(runs)))
        tell(TIMING, repetition + 1, repetitions)
    return [Timing(tuple(each)) for each in samples]


def kept_timings(
    kept: ValueCache, mechanism: Mechanism, settings: Sequence[Setting], until: float, repetitions: int, tell: Tell
) -> list[Timing]:
    """The timings of runs to `until` (s) that record only their end. They come from the store, or are taken together,
    because settings are timed in turn."""
    key = " ".join([f"{repetitions} timings", *(setting.command_line() for setting in settings)])
    if key not in kept:
        kept.add(key, time_settings(mechanism, settings, sample_times(until, 1), repetitions, tell))
    timings: list[Timing] = kept[key]
    return timings
