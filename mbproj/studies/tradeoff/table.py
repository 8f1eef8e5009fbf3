"""A trade-off as an HDF5 file."""

from __future__ import annotations

from math import nan
from pathlib import Path

import h5py
import numpy as np

from mbproj.outputs import hdf5, replacing
from mbproj.studies.tradeoff.front import Tradeoff
from mbproj.version import __version__

#: Descriptions of the columns, for the HDF5 file. The other columns are options and counters of a run.
MEANING = {
    "setting": "options of mbproj run",
    "formulation": "coordinates of the run; empty where it failed",
    "error": "largest error of the points that count, m; infinite where the run failed",
    "position_violation": "largest |C|, m or rad",
    "velocity_violation": "largest |C'|, per s",
    "energy_drift": "largest |E - W + D|, J",
    "warned": "whether the run notes that its energy tells of a wrong motion",
    "cpu_seconds": "processor time of the steps of one run, median of the timings, s; NaN where it was not timed",
    "cpu_seconds_lowest": "the smallest of the timings, s",
    "cpu_seconds_highest": "the largest of the timings, s",
    "first_cpu_seconds": "processor time of the first run, beside others, s",
    "on_front": "whether no other timed setting is both cheaper and more accurate",
    "on_violation_front": "whether no other timed setting is both cheaper and better closed",
    "failure": "why the run did not get to its end",
}


FORMAT = "mbproj tradeoff"
KIND = hdf5(FORMAT)


def write_hdf5(path: Path, found: Tradeoff, *, force: bool = False) -> Path:
    """Write a trade-off: /trials has an array for each column of its table, /reference has times, positions and
    uncertainty."""
    with replacing(path, KIND, force=force) as draft, h5py.File(draft, "w") as file:
        file.attrs.update(
            {
                "format": FORMAT,
                "mbproj_version": __version__,
                "title": found.title,
                "points": list(found.points),
                "notes": list(found.notes),
            }
        )
        table = found.table
        for name, column in zip(table.headings, zip(*table.rows, strict=True), strict=True):
            values = [nan if value is None else value for value in column]
            text = isinstance(values[0], str)
            data = np.array(values, dtype=h5py.string_dtype() if text else None)
            dataset = file.create_dataset(f"trials/{name}", data=data)
            dataset.attrs["description"] = MEANING.get(name, name.replace("_", " "))
        truth = found.reference
        for name, array, unit in (
            ("time", truth.times, "s"),
            ("position", truth.position, "m"),
            ("uncertainty", truth.uncertainty, "m"),
        ):
            file.create_dataset(f"reference/{name}", data=array).attrs["units"] = unit
        file["reference"].attrs.update({"points": list(truth.points), "method": truth.method, "check": truth.check})
    return path
