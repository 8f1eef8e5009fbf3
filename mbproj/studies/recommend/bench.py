"""A bench: it measures the error and the cost of settings against a reference, each setting once."""

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
    """A mechanism and its reference. `goal` is the largest error (m) allowed at the points with the numbers `columns`.
    `kept` stores all measurements. With `by_energy`, a run whose energy `mbproj run` would warn of misses the goal."""

    mechanism: Mechanism
    reference: Reference
    goal: float
    columns: tuple[int, ...]
    kept: ValueCache = field(default_factory=ValueCache)
    by_energy: bool = True

    def missed(self, tried: Measurement) -> float:
        """The error over the goal, or the energy's doubt where that is larger; at most 1 where the goal is kept."""
        doubt = tried.doubt if self.by_energy and tried.doubt > 1.0 else 0.0
        return max(tried.at() / self.goal, doubt)

    @property
    def until(self) -> float:
        """The end of the runs, s."""
        return float(self.reference.times[-1])

    @property
    def uncertainty(self) -> Array:
        """A bound on the reference's error at these points up to each time, (T,) m."""
        worst: Array = self.reference.uncertainty[:, self.columns].max(axis=1)
        return worst

    def shortened(self, until: float) -> Bench:
        """The bench with a reference that ends at an earlier sample time `until`, s."""
        kept, whole = self.reference.times <= until * (1.0 + 1e-9), self.reference
        arrays = {name: getattr(whole, name)[kept] for name in ("times", "position", "velocity", "uncertainty")}
        return replace(self, reference=replace(whole, **arrays))

    @property
    def points(self) -> tuple[str, ...]:
        """The names of the points whose error counts."""
        return tuple(self.reference.points[column] for column in self.columns)

    def measure(self, setting: Setting) -> Measurement:
        """Measure a setting at these points, unless its measurement is stored."""
        key = f"{setting.command_line()} --duration {self.until!r}"
        if key not in self.kept:
            self.kept.add(key, self.fresh(setting, self.mechanism))
        found: Measurement = self.kept[key]
        return found

    def fresh(self, setting: Setting, mechanism: Mechanism) -> Measurement:
        """Measure a setting at these points with `mechanism`, of the same scene, whether or not a measurement is
        stored."""
        return measured(solve(mechanism, setting, self.reference.times), self.reference).of(self.points)

    def kept_until(self, setting: Setting) -> float:
        """The last time (s) up to which a run with this setting keeps the goal."""
        distance = error(solve(self.mechanism, setting, self.reference.times), self.reference)
        beyond = np.flatnonzero(distance[:, self.columns].max(axis=1) > self.goal)
        times = self.reference.times
        return float(times[max(beyond[0] - 1, 0)]) if len(beyond) else float(times[-1])
