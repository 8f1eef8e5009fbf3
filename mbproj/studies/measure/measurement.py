"""A measurement: the errors and the cost of one setting on a mechanism, as numbers that fit in a line of JSON."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from math import inf, nan
from statistics import median
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.results.report_schema.studies import CPU_SECONDS
from mbproj.scene.scene import Scene
from mbproj.studies.measure.reference import Reference, error, stride_for
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Mechanism, Solution, sample_times, solve
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import TIMING, Tell, silent
from mbproj.studies.study import Study


@dataclass(frozen=True)
class Measurement:
    """The errors and the cost of one setting.

    `error` is the largest error of each point (m), `when` the time of it (s). Violations are the largest in m or rad,
    and per s. The energy drift is in J, and relative. `seconds` is the processor time of the steps, on a machine that
    others may use too.

    Where the run stopped early, `failure` is the cause, errors are infinite and counters empty. `doubt` is the energy
    drift over the limit from which `mbproj run` warns that the motion may be wrong."""

    setting: Setting
    error: Mapping[str, float]
    when: Mapping[str, float]
    position_violation: float = inf
    velocity_violation: float = inf
    energy_drift: float = inf
    energy_drift_relative: float = inf
    counters: Mapping[str, int] = field(default_factory=dict)
    seconds: float = inf
    formulation: str = ""
    failure: str | None = None
    doubt: float = 0.0

    def at(self, points: tuple[str, ...] | None = None) -> float:
        """The largest error (m) of the given points, or of all points."""
        return self.error[self.worst(points)]

    def worst(self, points: tuple[str, ...] | None = None) -> str:
        """The name of the point with the largest error, among the given points or all."""
        return max(points or tuple(self.error), key=self.error.__getitem__)

    @property
    def evaluations(self) -> float:
        """The number of evaluations of the accelerations; infinite where the run failed."""
        return self.counters.get("evaluations", inf)

    def of(self, points: tuple[str, ...]) -> Measurement:
        """Return this measurement with the errors of the given points only."""
        error, when = ({name: values[name] for name in points} for values in (self.error, self.when))
        return replace(self, error=error, when=when)

    def timed(self, seconds: float) -> Measurement:
        """Return this measurement with other `seconds`."""
        return replace(self, seconds=seconds)


def measured(solution: Solution, reference: Reference) -> Measurement:
    """Measure the errors of a solution against the reference at all its times."""
    distance, report = error(solution, reference), solution.report
    largest, rows = distance.max(axis=0), np.argmax(distance, axis=0)
    by_point = dict(zip(reference.points, largest.tolist(), strict=True))
    when = dict(zip(reference.points, reference.times[rows].tolist(), strict=True))
    if report is None:
        return Measurement(solution.setting, dict.fromkeys(by_point, inf), when, failure=str(solution.failure))
    return Measurement(
        setting=solution.setting,
        error=by_point,
        when=when,
        position_violation=report.position_violation.value,
        velocity_violation=report.velocity_violation.value,
        energy_drift=report.energy_drift,
        energy_drift_relative=report.energy_drift_relative,
        counters=report.counters,
        seconds=report.integration_cpu_seconds,
        formulation=report.formulation,
        doubt=report.doubt,
    )


# --- The cost of settings ---------------------------------------------------------------------------------------------
# Processor time of the thread, each setting in turn, several rounds.


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


# --- A study of settings: their errors against one reference, in parallel, and their timings --------------------------


@dataclass
class Yardstick:
    """A scene and the reference for the errors of all measurements. It can be sent to another process."""

    scene: Scene
    reference: Reference

    @cached_property
    def mechanism(self) -> Mechanism:
        """The mechanism, compiled and assembled once in each process."""
        return Mechanism.of(self.scene)

    def measure(self, setting: Setting) -> Measurement:
        """Measure one setting at the times of the reference, or at those of them that its fixed steps meet.

        With error control, its counters and seconds come from a second run without samples between the steps, as these
        cost evaluations."""
        times = self.reference.times
        stride = 1 if setting.step is None else stride_for(times, setting.step) or 1
        measurement = measured(solve(self.mechanism, setting, times[::stride]), self.reference.at_every(stride))
        if setting.tolerance is None or measurement.failure:
            return measurement
        report = solve(self.mechanism, setting, sample_times(float(times[-1]), 1)).report
        if report is None:
            return measurement
        return replace(measurement, counters=report.counters, seconds=report.integration_cpu_seconds)


class SettingsStudy(Study):
    """A study of settings on a mechanism, whose errors are measured against one reference. Its results are
    measurements, timings, and values of another `kind`. `facts` are those that its results depend on besides."""

    def __init__(
        self,
        name: str,
        mechanism: Mechanism,
        reference: Reference,
        where: Where = 1,
        fresh: bool = False,
        tell: Tell = silent,
        kind: Any = Measurement,
        **facts: Any,
    ) -> None:
        truth = [reference.method, reference.check, reference.times.tolist()]
        what = {"study": name, **mechanism.identity, "reference": truth, **facts}
        super().__init__(what, kind | Measurement | list[Timing], where, fresh, tell, T=len(reference.times))
        self.mechanism, self.reference = mechanism, reference
        self.yardstick = Yardstick(mechanism.scene, reference)

    def of_settings(self, function: Callable[[Yardstick, Setting], Any], settings: Sequence[Setting]) -> list[Any]:
        """The results function(yardstick, setting), in the order of the settings."""
        self.each(function, self.yardstick, {setting.command_line(): setting for setting in settings}, "runs")
        return [self.results[setting.command_line()] for setting in settings]

    def measured(self, settings: Sequence[Setting]) -> list[Measurement]:
        """The measurements of the settings, in their order."""
        return self.of_settings(Yardstick.measure, settings)

    def timed(self, settings: Sequence[Setting], repetitions: int) -> dict[Setting, Timing]:
        """The timings of runs that record only their end. They are taken together, because settings are timed in
        turn."""
        ends = sample_times(float(self.reference.times[-1]), 1)
        name = " ".join([f"{repetitions} timings", *(setting.command_line() for setting in settings)])
        timings = self.one(name, lambda: time_settings(self.mechanism, settings, ends, repetitions, self.tell))
        return dict(zip(settings, timings, strict=True))
