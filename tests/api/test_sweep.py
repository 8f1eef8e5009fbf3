"""`mbproj.sweep`: its table is that of the command, and nothing is computed twice."""

from __future__ import annotations

import csv
import sys

import numpy as np
import pytest

import mbproj
from tests.studies.sweep.specs import write

pytestmark = pytest.mark.usefixtures("sweeps_here")

MEASURES = "  drop: {marker: end, quantity: position, component: z, at: end}\n"


def test_the_table_is_that_of_the_file(tmp_path):
    spec = write(tmp_path, "  length: 0.8:1.2:3\n", MEASURES)
    told = []
    table = mbproj.sweep(spec, jobs=1, progress=told.append)
    with (table.folder / "summary.csv").open(encoding="utf-8", newline="") as file:
        heading, *rows = list(csv.reader(file))
    assert list(table.headings) == heading
    np.testing.assert_allclose(table["length"], [0.8, 1.0, 1.2], rtol=1e-12)
    np.testing.assert_array_equal(table["drop"], [float(row[heading.index("drop (m)")]) for row in rows])
    assert (table["drop"] < 0).all()
    assert list(table["status"]) == ["done"] * 3
    assert told[-1] == table.progress
    again = mbproj.sweep(spec)
    assert (again.progress.computed, again.progress.reused, again.rows) == (0, 3, table.rows)


def test_what_is_wrong_is_said(tmp_path, monkeypatch):
    table = mbproj.sweep(write(tmp_path, "  length: 0.8:1.2:2\n", MEASURES), output=tmp_path / "there")
    with pytest.raises(KeyError, match="no column 'dorp'; did you mean 'drop'"):
        table["dorp"]
    assert table._repr_html_().count("<tr>") == 3
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="pip install"):
        table.to_pandas()
    with pytest.raises(mbproj.InputError, match="no-sweep"):
        mbproj.sweep(tmp_path / "no-sweep.yaml")


def test_pandas(tmp_path):
    pytest.importorskip("pandas")
    table = mbproj.sweep(write(tmp_path, "  length: 0.8:1.2:2\n", MEASURES))
    assert list(table.to_pandas()["drop (m)"]) == list(table["drop"])
