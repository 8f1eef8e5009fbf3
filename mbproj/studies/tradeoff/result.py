"""`Tradeoff`: the trials of a grid of settings, with their Pareto fronts, as a table and as an HDF5 file."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from math import inf, nan
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.output_files import hdf5, replacing
from mbproj.report_schema import report_of
from mbproj.report_schema.studies import COUNTED, OF_POINT, TRIALS, VARIED
from mbproj.results.views.table import Table, Tabled
from mbproj.studies.measure.measurement import Measurement
from mbproj.studies.measure.reference import Reference
from mbproj.studies.measure.timing import Timing, timing_columns
from mbproj.studies.tradeoff.fronts import cheapest, front
from mbproj.version import __version__

#: Columns of the table: options of a setting, and counters of its run.


@dataclass(frozen=True, eq=False)
class Tradeoff(Tabled):
    """The trials of a grid of settings on a mechanism of `size` (m). The largest error of `points` counts.

    `timings` are those of the trials that were timed, by their index. `own` is the index of the scene's own setting, or
    None. `compared` are the indices of settings that differ only in their projection. `notes` are for the reader."""

    title: str
    size: float
    points: tuple[str, ...]
    trials: tuple[Measurement, ...]
    timings: Mapping[int, Timing]
    own: int | None
    compared: tuple[int, ...]
    reference: Reference
    notes: tuple[str, ...]

    @cached_property
    def error(self) -> Array:
        """The largest error of the points, (N,) in m."""
        return np.array([trial.at(self.points) for trial in self.trials])

    @cached_property
    def violation(self) -> Array:
        """The largest |C|, (N,) in m or rad."""
        return np.array([trial.position_violation for trial in self.trials])

    @cached_property
    def seconds(self) -> Array:
        """The processor time of settings that were timed alone, (N,) in s; infinite for the others."""
        timed = np.full(len(self.trials), inf)
        for index, timing in self.timings.items():
            timed[index] = timing.median
        return timed

    @cached_property
    def front(self) -> tuple[int, ...]:
        """Indices of the Pareto front, the cheapest setting first: no other setting is both cheaper and more
        accurate."""
        return tuple(front(self.seconds, np.maximum(self.error, self.floor)).tolist())

    @cached_property
    def violation_front(self) -> tuple[int, ...]:
        """Indices of the Pareto front with |C| in place of the error, the cheapest setting first."""
        return tuple(front(self.seconds, self.violation).tolist())

    def cheapest(self, limit: float, closed: float = inf) -> int | None:
        """The index of the cheapest setting with an error (m) of at most `limit` and |C| (m or rad) of at most
        `closed`."""
        return cheapest(self.seconds, np.where(self.violation <= closed, self.error, inf), limit)

    def most_accurate(self, seconds: float) -> int | None:
        """The index of the most accurate setting that takes at most `seconds`."""
        return cheapest(self.error, self.seconds, seconds)

    @property
    def floor(self) -> float:
        """The uncertainty of the reference over the whole span, m."""
        columns = [self.reference.points.index(name) for name in self.points]
        return float(self.reference.uncertainty[-1, columns].max())

    @property
    def table(self) -> Table:
        """A table with a row for each setting. `TRIALS` describes its columns."""
        return Table.of(map(self._row, range(len(self.trials))))

    @property
    def line(self) -> str:
        """A line with the number of settings, the duration, and the number of failures."""
        failed = sum(trial.failure is not None for trial in self.trials)
        until = self.reference.times[-1]
        return (
            f"{self.title or 'The mechanism'}: {len(self.trials)} settings up to {until:g} s, of which {failed} failed"
        )

    __repr__ = Tabled.__repr__

    def _row(self, index: int) -> dict[str, Any]:
        trial = self.trials[index]
        return {
            "setting": trial.setting.command_line(),
            **report_of(VARIED, trial.setting),
            "formulation": trial.formulation,
            "error": float(self.error[index]),
            **{f"error_{name}": trial.error[name] for name in self.reference.points},
            "position_violation": trial.position_violation,
            "velocity_violation": trial.velocity_violation,
            "energy_drift": trial.energy_drift,
            "warned": trial.doubt > 1.0,
            **{fact.key: trial.counters.get(fact.key, 0) for fact in COUNTED},
            **timing_columns(self.timings.get(index)),
            "first_cpu_seconds": trial.seconds,
            "on_front": index in self.front,
            "on_violation_front": index in self.violation_front,
            "failure": trial.failure or "",
        }


FORMAT = "mbproj tradeoff"
KIND = hdf5(FORMAT)


def write_hdf5(path: Path, result: Tradeoff, *, force: bool = False) -> Path:
    """Write a trade-off: /trials has an array for each column of its table, /reference has times, positions and
    uncertainty."""
    with replacing(path, KIND, force=force) as draft, h5py.File(draft, "w") as file:
        file.attrs.update(
            {
                "format": FORMAT,
                "mbproj_version": __version__,
                "title": result.title,
                "points": list(result.points),
                "notes": list(result.notes),
            }
        )
        table, trials = result.table, {fact.key: fact for fact in TRIALS}
        for name, column in zip(table.headings, zip(*table.rows, strict=True), strict=True):
            values = [nan if value is None else value for value in column]
            text = isinstance(values[0], str)
            data = np.array(values, dtype=h5py.string_dtype() if text else None)
            dataset = file.create_dataset(f"trials/{name}", data=data)
            fact = trials.get(name, trials[OF_POINT])
            dataset.attrs.update({"description": fact.words.partition("; null")[0], "units": fact.unit})
        truth = result.reference
        for name, array, unit in (
            ("time", truth.times, "s"),
            ("position", truth.position, "m"),
            ("uncertainty", truth.uncertainty, "m"),
        ):
            file.create_dataset(f"reference/{name}", data=array).attrs["units"] = unit
        file["reference"].attrs.update({"points": list(truth.points), "method": truth.method, "check": truth.check})
    return path
