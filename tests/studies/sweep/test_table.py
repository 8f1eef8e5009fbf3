"""The summary of a sweep is read as it was written; what is not one is said."""

from __future__ import annotations

import h5py
import numpy as np
import pytest

from mbproj.errors import InputError
from mbproj.results.sweep.table import read_table
from mbproj.studies.sweep.arrays import write_arrays
from mbproj.studies.sweep.folder import Folder
from mbproj.studies.sweep.run import run_sweep
from mbproj.studies.sweep.spec import read_spec
from tests.studies.sweep.specs import write


def summarised(tmp_path, vary, more=""):
    spec = read_spec(write(tmp_path, vary, more=more))
    folder = Folder(tmp_path / "made-sweep", spec, fresh=False)
    with folder.store:
        run_sweep(spec, folder, 1)
        write_arrays(spec, folder)
    return tmp_path / "made-sweep"


def test_a_grid_comes_back_as_rows(tmp_path):
    found = read_table(
        summarised(tmp_path, "  length: [1, 2]\n  fails: [0, 1]\n  simulation.projection: [gopm, mmopm]\n")
    )
    assert (found.name, found.combine, found.shape) == ("made-sweep", "grid", (2, 2, 2))
    length, fails, method = found.varied
    assert (length.name, length.unit, length.values.tolist()) == ("length", "m", [1.0] * 4 + [2.0] * 4)
    assert fails.values.tolist() == [0.0, 0.0, 1.0, 1.0] * 2
    assert (method.is_number, method.values.tolist()) == (False, ["gopm", "mmopm"] * 4)
    assert found.failed.tolist() == [False, False, True, True] * 2
    (drop,) = found.measured
    assert np.isnan(drop.values).tolist() == found.failed.tolist()
    assert (drop.name, drop.unit) == ("drop", "m")


def test_samples_come_back_with_what_the_design_was_asked_for(tmp_path):
    more = "combine: saltelli\nsamples: 2\n"
    found = read_table(
        summarised(tmp_path, "  length: {uniform: [1, 2]}\n  bodies.bar.mass: {uniform: [1, 2]}\n", more)
    )
    assert (found.combine, found.samples, found.shape) == ("saltelli", 2, (8,))
    assert found.varied[0].values[:2].tolist() == found.varied[0].values[6:].tolist()


def test_what_is_no_summary(tmp_path):
    with pytest.raises(InputError, match=r"is not the folder of a sweep: it has no 'summary.h5'"):
        read_table(tmp_path)
    made = summarised(tmp_path / "there", "  length: [1, 2]\n")
    with h5py.File(made / "summary.h5", "r+") as file:
        del file["drop"]
        file["drop"] = np.zeros(3)
    with pytest.raises(InputError, match=r"'drop' has the wrong shape or type"):
        read_table(made)
    with h5py.File(made / "summary.h5", "r+") as file:
        file.attrs["format"] = "another"
    with pytest.raises(InputError, match=r"is not the summary of a sweep"):
        read_table(made / "summary.h5")
