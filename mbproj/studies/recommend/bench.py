"""Settings held against a reference, each once: the error at the points that matter, and what it cost."""

from __future__ import annotations

from dataclasses import field, replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.studies.measure.measurement import Measurement, measured
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.reference import Reference, error
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import solve
from mbproj.studies.store import ValueCache


@dataclass(eq=False)
class Bench:
    """A mechanism and its reference; `goal` is the error asked for, m, at the points number `columns`. What was
    measured is in `kept`. `by_energy`: whether a run of whose energy `mbproj run` would warn misses the goal."""

    mechanism: Mechanism
    reference: Reference
    goal: float
    columns: tuple[int, ...]
    kept: ValueCache = field(default_factory=ValueCache)
    by_energy: bool = True

    def missed(self, tried: Measurement) -> float:
        """The error over the goal, or how far the energy is beyond what goes without a note: at most 1 where the goal
        is kept."""
        doubt = tried.doubt if self.by_energy and tried.doubt > 1.0 else 0.0
        return max(tried.at() / self.goal, doubt)

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
        return replace(self, reference=replace(whole, **arrays))

    @property
    def points(self) -> tuple[str, ...]:
        """The names of the points that count."""
        return tuple(self.reference.points[column] for column in self.columns)

    def measure(self, setting: Setting) -> Measurement:
        """What the setting achieves at the points that count, computed where it is not among what is kept."""
        key = f"{setting.command_line()} --duration {self.until!r}"
        if key not in self.kept:
            self.kept.add(key, self.fresh(setting, self.mechanism).as_json())
        return Measurement.from_json(self.kept[key])

    def fresh(self, setting: Setting, mechanism: Mechanism) -> Measurement:
        """The same on a mechanism of the same scene, computed in any case."""
        return measured(solve(mechanism, setting, self.reference.times), self.reference).of(self.points)

    def kept_until(self, setting: Setting) -> float:
        """The last time (s) up to which a run with the setting keeps the goal."""
        distance = error(solve(self.mechanism, setting, self.reference.times), self.reference)
        beyond = np.flatnonzero(distance[:, self.columns].max(axis=1) > self.goal)
        times = self.reference.times
        return float(times[max(beyond[0] - 1, 0)]) if len(beyond) else float(times[-1])
