"""Settings held against a reference, each once: the error at the points that matter, and what it cost."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace

import numpy as np

from mbproj.arrays import Array
from mbproj.studies.measure.measures import error
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.reference import Reference
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import solve
from mbproj.studies.store import Kept

NO_END = float("inf")


@dataclass(frozen=True)
class Outcome:
    """What a setting did: its largest error in m, where (a point's name) and when (s); infinite where it failed. The
    time in s up to which it kept the error asked for, and its evaluations of the accelerations."""

    setting: Setting
    error: float
    point: str
    time: float
    kept_until: float
    evaluations: float
    seconds: float = float("nan")


@dataclass(eq=False)
class Bench:
    """A mechanism and its reference; `goal` is the error asked for, m, at the points number `columns`. What was
    measured is in `kept`."""

    mechanism: Mechanism
    reference: Reference
    goal: float
    columns: tuple[int, ...]
    kept: Kept = field(default_factory=Kept)

    @property
    def until(self) -> float:
        """The end of the runs, s."""
        return float(self.reference.times[-1])

    @property
    def uncertainty(self) -> Array:
        """By how much the reference is uncertain at most up to each time, (T,) m."""
        worst: Array = self.reference.uncertainty[:, self.columns].max(axis=1)
        return worst

    def shortened(self, until: float) -> Bench:
        """The same up to another sample time, in s."""
        kept, whole = self.reference.times <= until * (1.0 + 1e-9), self.reference
        arrays = {name: getattr(whole, name)[kept] for name in ("times", "position", "velocity", "uncertainty")}
        return Bench(self.mechanism, replace(whole, **arrays), self.goal, self.columns, self.kept)

    def measure(self, setting: Setting) -> Outcome:
        """Its outcome, computed where it is not among what is kept."""
        key = f"{setting.command_line()} --duration {self.until!r}"
        if key not in self.kept:
            self.kept.add(key, asdict(self.fresh(setting, self.mechanism)))
        return Outcome(**{**self.kept[key], "setting": setting})

    def fresh(self, setting: Setting, mechanism: Mechanism) -> Outcome:
        """The outcome on a mechanism of the same scene."""
        solution, times = solve(mechanism, setting, self.reference.times), self.reference.times
        distance = error(solution, self.reference)[:, self.columns]
        row, column = np.unravel_index(int(np.argmax(distance)), distance.shape)
        beyond = np.flatnonzero(distance.max(axis=1) > self.goal)
        return Outcome(
            setting=setting,
            error=float(distance[row, column]),
            point=self.reference.points[self.columns[int(column)]],
            time=float(times[row]),
            kept_until=float(times[max(beyond[0] - 1, 0)]) if len(beyond) else float(times[-1]),
            evaluations=NO_END if solution.report is None else solution.report.counters["evaluations"],
            seconds=NO_END if solution.report is None else solution.report.integration_cpu_seconds,
        )
