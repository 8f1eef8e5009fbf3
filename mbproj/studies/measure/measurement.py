"""A measurement: the errors and the cost of one setting on a mechanism, as numbers that fit in a line of JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field, replace
from math import inf

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.studies.measure.reference import Reference, error
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Solution


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


#: The classes of a measurement and its parts, which the store has to know.
MEASUREMENT_RECORDS = (Measurement, Setting)


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
