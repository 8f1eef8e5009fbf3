"""A measurement: what one setting achieved on a mechanism, in numbers that a line of JSON holds. Every study has it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, field, replace
from math import inf
from typing import Any

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.studies.measure.reference import Reference, error
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Solution


@dataclass(frozen=True)
class Measurement:
    """A setting; its largest error by point (m), and when it was that large (s); its largest violations (m or rad, and
    per s); its energy drift (J, and relative); its counters; its formulation. `seconds` its steps took, of processor
    time, on a machine that others used too. Where it did not get to the end, `failure` is the cause, what was measured
    is infinite, and nothing was counted. `doubt`: how far its energy is beyond what goes without a note of `mbproj run`
    that the motion may be wrong: at most 1 without one."""

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

    def as_json(self) -> dict[str, Any]:
        """By name."""
        return asdict(self)

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> Measurement:
        """What `as_json` gave."""
        setting = dict(values["setting"])
        setting["gains"] = None if setting["gains"] is None else tuple(setting["gains"])
        return cls(**{**values, "setting": Setting(**setting)})

    def at(self, points: tuple[str, ...] | None = None) -> float:
        """The largest error of these points, or of all, m."""
        return self.error[self.worst(points)]

    def worst(self, points: tuple[str, ...] | None = None) -> str:
        """The name of the point with the largest error, of these or of all."""
        return max(points or tuple(self.error), key=self.error.__getitem__)

    @property
    def evaluations(self) -> float:
        """Evaluations of the accelerations; infinite where it failed."""
        return self.counters.get("evaluations", inf)

    def of(self, points: tuple[str, ...]) -> Measurement:
        """The same with the errors of these points alone."""
        error, when = ({name: values[name] for name in points} for values in (self.error, self.when))
        return replace(self, error=error, when=when)

    def timed(self, seconds: float) -> Measurement:
        """The same with another time."""
        return replace(self, seconds=seconds)


def measured(solution: Solution, reference: Reference) -> Measurement:
    """What a solution was worth, held against the reference at all its times."""
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
