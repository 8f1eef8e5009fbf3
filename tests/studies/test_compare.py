"""A comparison: what each entry is, one formulation for all, and failures as entries."""

from __future__ import annotations

import numpy as np
import pytest

from mbproj.base.errors import InputError
from mbproj.studies.compare import compare


def test_compare(slider_crank):
    found = compare(
        slider_crank.scene, projections=("none", "gpopm"), steps=(0.01, 0.005), until=1.0, repetitions=1, processes=1
    )
    labels = [entry.label for entry in found.entries]
    assert labels == [f"{method}, h = {h} s" for method in ("none", "gpopm") for h in (0.01, 0.005)]
    numbers = {entry.label: entry.numbers for entry in found.entries}
    assert found.cost_in_time
    for entry in found.entries:
        row = numbers[entry.label]
        assert row["energy_drift"] == pytest.approx(entry.solution.energy_balance[-1], abs=1e-11)
        assert 0.0 < row["cpu_seconds"] < np.inf
        assert row["acceleration_violation"] < 1e-9
    coarse, fine = (numbers[f"gpopm, h = {h} s"] for h in (0.01, 0.005))
    assert coarse["error"] / fine["error"] > 8.0
    assert fine["position_violation"] <= 1e-13 < 1e-3 < numbers["none, h = 0.01 s"]["position_violation"]


def test_several_formulations_are_not_compared_in_time(pendulum):
    found = compare(
        pendulum.scene, projections=("gpopm",), formulations=("full", "reduced"), until=0.1, repetitions=1, processes=1
    )
    assert [entry.solution.report.formulation for entry in found.entries] == ["full", "reduced"]
    assert not found.cost_in_time
    assert all(entry.timing is None for entry in found.entries)
    assert any("cost is compared in factorisations and iterations" in note for note in found.notes)


def test_one_formulation_for_all_and_failures_are_entries(pendulum):
    found = compare(pendulum.scene, projections=("gpopm", "gpopm-pinv", "popm"), until=0.1, repetitions=1, processes=1)
    first, second, refused = found.entries
    assert first.solution.report.formulation == second.solution.report.formulation == "full"
    assert "all in the full formulation: 'gpopm-pinv' exists there only" in found.notes
    assert refused.split is None
    assert refused.numbers["failure"].startswith("'popm' needs a positive definite mass matrix")
    assert np.isnan(refused.numbers["cpu_seconds"])


def test_names_that_are_not_there(pendulum):
    with pytest.raises(InputError, match="unknown projection method 'gpom'; did you mean 'gpopm'"):
        compare(pendulum.scene, projections=("gpom",))
    with pytest.raises(InputError, match="unknown integrator 'rk5'"):
        compare(pendulum.scene, integrators=("rk5",))


def test_runs_of_a_comparison_are_not_run_again(pendulum, monkeypatch):
    options = {"projections": ("gpopm",), "until": 0.1, "repetitions": 1, "processes": 1}
    first = compare(pendulum.scene, **options)
    monkeypatch.setattr("mbproj.studies.measure.solve.solve", None)
    again = compare(pendulum.scene, **options)
    np.testing.assert_array_equal(again.entries[0].error, first.entries[0].error)
    with pytest.raises(TypeError):
        compare(pendulum.scene, **{**options, "until": 0.2})


def test_a_row_has_its_numbers_under_their_headings(pendulum):
    """The row of a setting with the energy row was longer than the first, and its times stood under other headings."""
    options = {"projections": ("gpopm",), "energy_rows": (False, True), "until": 0.1, "repetitions": 1, "processes": 1}
    found = compare(pendulum.scene, **options)
    without, kept = found.table.records
    assert np.isnan(without["energy_row_given"]) and np.isfinite(kept["energy_row_given"])
    for record, entry in zip((without, kept), found.entries, strict=True):
        assert record["cpu_seconds"] == entry.timing.median
        assert record["failure"] == ""
