"""What settings cost: timed alone, in turn, several times over, by the thread's own clock."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import sample_times, solve
from mbproj.studies.parallel.progress import TIMING, Tell, silent
from mbproj.studies.store import ValueCache

#: A run that is shorter is repeated until it has taken this long, s.
SHORTEST = 15e-3
#: A first run that is longer, and so not the time of what is done only once, counts as a repetition, s.
LONG = 0.1
REPETITIONS = 5


@dataclass(frozen=True)
class Timing:
    """Seconds of processor time of the steps of one run, as each repetition found them (assembly and recording are not
    among them)."""

    samples: tuple[float, ...]

    @property
    def median(self) -> float:
        """The middle one."""
        return median(self.samples)

    @property
    def spread(self) -> tuple[float, float]:
        """The smallest and the largest."""
        return min(self.samples), max(self.samples)


def run_seconds(mechanism: Mechanism, setting: Setting, times: Array) -> float:
    """Seconds of processor time of one run with these samples; infinite where it fails."""
    report = solve(mechanism, setting, times).report
    return float("inf") if report is None else report.integration_cpu_seconds


def time_settings(
    mechanism: Mechanism,
    settings: Sequence[Setting],
    times: Array,
    repetitions: int = REPETITIONS,
    tell: Tell = silent,
) -> list[Timing]:
    """A Timing for each setting, of runs with samples at `times` (T,), s. All are timed in turn, `repetitions` times
    over, so that a slow spell of the machine meets all of them alike. `tell` counts the rounds."""
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
    """The timings of runs that record their end alone, at `until` s: those that are kept, or taken now, all of them
    together because they are taken in turn."""
    key = " ".join(["timings", *(setting.command_line() for setting in settings)])
    if key not in kept:
        taken = time_settings(mechanism, settings, sample_times(until, 1), repetitions, tell)
        kept.add(key, [timing.samples for timing in taken])
    return [Timing(tuple(samples)) for samples in kept[key]]
