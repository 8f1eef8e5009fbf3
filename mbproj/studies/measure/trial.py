"""A trial: what one setting achieved on a mechanism, in numbers that a line of JSON holds."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.studies.measure.measures import error, largest_error
from mbproj.studies.measure.reference import Reference
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Solution


@dataclass(frozen=True)
class Trial:
    """A setting with its largest error (m) by point, its largest violations (m or rad, and per s), its energy drift (J,
    and relative), its counters, the seconds its steps took (of processor time, on a machine that others used too), its
    formulation; errors are infinite and `failure` is the cause where it did not get to the end."""

    setting: Setting
    error: Mapping[str, float]
    position_violation: float
    velocity_violation: float
    energy_drift: float
    energy_drift_relative: float
    counters: Mapping[str, int]
    seconds: float
    formulation: str
    failure: str | None = None

    def as_json(self) -> dict[str, Any]:
        """By name."""
        return asdict(self)

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> Trial:
        """What `as_json` gave."""
        setting = dict(values["setting"])
        setting["gains"] = None if setting["gains"] is None else tuple(setting["gains"])
        return cls(**{**values, "setting": Setting(**setting)})

    def at(self, points: tuple[str, ...] | None = None) -> float:
        """The largest error of these points, or of all, m."""
        return max(self.error[name] for name in points or tuple(self.error))

    def timed(self, seconds: float) -> Trial:
        """The same with another time."""
        return replace(self, seconds=seconds)


def trial(solution: Solution, reference: Reference, until: float | None = None) -> Trial:
    """The trial that a solution was, its error taken up to the time `until` in s."""
    largest = largest_error(error(solution, reference), reference.times, until)
    report = solution.report
    if report is None:
        return Trial(
            solution.setting,
            _by_name(reference, np.full(len(largest), np.inf)),
            np.inf,
            np.inf,
            np.inf,
            np.inf,
            {},
            np.inf,
            "",
            str(solution.failure),
        )
    return Trial(
        setting=solution.setting,
        error=_by_name(reference, largest),
        position_violation=report.position_violation.value,
        velocity_violation=report.velocity_violation.value,
        energy_drift=report.energy_drift,
        energy_drift_relative=report.energy_drift_relative,
        counters=report.counters,
        seconds=report.integration_cpu_seconds,
        formulation=report.formulation,
    )


def _by_name(reference: Reference, values: Array) -> dict[str, float]:
    return dict(zip(reference.points, values.tolist(), strict=True))
