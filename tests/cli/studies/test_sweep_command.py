"""`mbproj sweep` as a shell sees it: what it prints and writes, exit codes, and what a kill leaves."""

from __future__ import annotations

import csv
import json
import os
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from xml.etree import ElementTree

import h5py
import numpy as np
import pytest

from tests.cli.commands import mbproj
from tests.studies.sweep.specs import write
from tests.support import ROOT

#: Two values of each, half of which fail.
VARY = "  parameters.length: [0.8 m, 1.2 m]\n  bodies.bar.mass: [1, 2]\n  fails: [0, 1]\n"


def test_it_writes_a_table_and_arrays_and_says_what_failed(tmp_path):
    write(tmp_path, VARY)
    done = mbproj("sweep", "spec.yaml", "--junit", "cases.xml", folder=tmp_path)
    assert done.returncode == 3, done.stderr
    first, second, table, arrays = done.stdout.splitlines()
    assert first == "8 cases: 8 computed, 0 reused, 4 failed"
    assert second.startswith("  4 failed, the first is case 1: ")
    assert (table, arrays) == ("spec-sweep/summary.csv", "spec-sweep/summary.h5")
    with (tmp_path / table).open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0])[:6] == ["case", "length (m)", "bodies.bar.mass (kg)", "fails", "drop (m)", "status"]
    assert [row["status"] for row in rows] == ["done", "failed"] * 4
    assert [row["drop (m)"] == "" for row in rows] == [False, True] * 4
    root = ElementTree.parse(tmp_path / "cases.xml").getroot()
    assert (root.get("tests"), root.get("errors")) == ("8", "4")
    assert root[0][1].get("name") == "1: parameters.length=0.8, bodies.bar.mass=1, fails=1"
    again = json.loads(mbproj("sweep", "spec.yaml", "--json", folder=tmp_path).stdout)
    assert (again["computed"], again["reused"], again["failed"], again["left"]) == (0, 8, 4, 0)


def test_the_arrays_are_netcdf(tmp_path):
    """Dimension scales carry the values of what varies; each variable has its unit."""
    write(tmp_path, "  length: [0.8, 1.2, 1.6]\n  simulation.projection: [gopm, gpopm]\n")
    assert mbproj("sweep", "spec.yaml", "-q", folder=tmp_path).returncode == 0
    with h5py.File(tmp_path / "spec-sweep" / "summary.h5") as file:
        drop = file["drop"]
        assert drop.shape == (3, 2)
        assert [axis[0].name for axis in drop.dims] == ["/length", "/simulation.projection"]
        assert (drop.attrs["units"], file["length"].attrs["units"]) == ("m", "m")
        assert file["length"][()].tolist() == [0.8, 1.2, 1.6]
        assert file["simulation.projection"].asstr()[()].tolist() == ["gopm", "gpopm"]
        assert np.all(np.diff(drop[:, 0]) < 0.0)  # the longer the arm, the farther its end falls
        assert file.attrs["combine"] == "grid"


def test_samples_stand_along_one_dimension(tmp_path):
    vary = "  length: {normal: {mean: 1 m, deviation: 1 mm}}\n  bodies.bar.mass: {uniform: [1, 2]}\n"
    write(tmp_path, vary, more="combine: saltelli\nsamples: 4\nseed: 3\n")
    assert mbproj("sweep", "spec.yaml", "-q", folder=tmp_path).returncode == 0
    with h5py.File(tmp_path / "spec-sweep" / "summary.h5") as file:
        assert file["drop"].shape == (16,)
        assert [axis[0].name for axis in file["length"].dims] == ["/case"]
        assert file.attrs["coordinates"] == "length bodies.bar.mass"
        lengths, masses = file["length"][()].reshape(4, 4), file["bodies.bar.mass"][()].reshape(4, 4)
    assert np.array_equal(lengths[2], lengths[1])  # A with the first column of B
    assert np.array_equal(lengths[3], lengths[0])
    assert np.array_equal(masses[2], masses[0])
    assert np.array_equal(masses[3], masses[1])


def test_a_dry_run_counts_and_shows_the_first_cases(tmp_path):
    write(tmp_path, "  length: 0.8 m:1.2 m:41\n  bodies.bar.mass: [1, 2]\n")
    done = mbproj("sweep", "spec.yaml", "--dry-run", folder=tmp_path)
    lines = done.stdout.splitlines()
    assert lines[0] == "82 cases (grid)"
    assert lines[2].split() == ["case", "length", "(m)", "bodies.bar.mass", "(kg)"]
    assert lines[4].split() == ["1", "0.8", "2"]
    assert lines[-1] == "measured: drop (m)"
    assert not (tmp_path / "spec-sweep").exists()


def test_a_thousand_million_cases_are_not_meant(tmp_path):
    write(tmp_path, "  length: 1:2:100000\n  bodies.bar.mass: 1:2:10000\n")
    done = mbproj("sweep", "spec.yaml", folder=tmp_path)
    assert done.returncode == 2
    assert "spec.yaml:3:1: error: this makes 1000000000 cases; add --yes if you mean it, or vary less" in done.stderr


@pytest.mark.skipif(os.name != "posix", reason="sends SIGKILL")
def test_what_a_killed_sweep_had_done_is_not_done_again(tmp_path):
    """The leading process is killed in the middle; started again, it computes the rest and no case twice."""
    write(tmp_path, "  length: 1:2:60\n  simulation.duration: 0.9\n  simulation.step: 1e-4\n")
    program = [sys.executable, "-c", "from mbproj.cli import main; main()", "sweep", "spec.yaml", "-j", "1"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    running = subprocess.Popen(program, cwd=tmp_path, env=environment, stderr=subprocess.DEVNULL)
    store = tmp_path / "spec-sweep" / "store.sqlite-wal"
    deadline = time.monotonic() + 30.0
    while time.monotonic() < deadline and not (store.exists() and store.stat().st_size > 120_000):
        time.sleep(0.01)
    running.send_signal(signal.SIGKILL)
    assert running.wait() == -signal.SIGKILL
    with closing(sqlite3.connect(tmp_path / "spec-sweep" / "store.sqlite")) as database:
        (kept,) = database.execute("SELECT count(*) FROM cases").fetchone()
    assert 0 < kept < 60
    done = json.loads(mbproj("sweep", "spec.yaml", "--json", folder=tmp_path).stdout)
    assert (done["reused"], done["computed"], done["failed"]) == (kept, 60 - kept, 0)


def test_its_folder_is_drawn(tmp_path):
    write(tmp_path, "  length: [1, 2, 3]\n  fails: [0, 1]\n")
    assert mbproj("sweep", "spec.yaml", "-q", folder=tmp_path).returncode == 3
    done = mbproj("plot", "spec-sweep", "-o", "pictures", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.split() == ["pictures/spec-sweep-lines.png", "pictures/spec-sweep-map.png"]
    wrong = {
        ("--kind", "maps"): "--kind: unknown kind 'maps' of a sweep; did you mean 'map'?",
        ("--kind", "sobol"): "--kind sobol: the sweep combines by 'grid'",
        ("--over", "lenght"): "--over: the sweep has no quantity that varies 'lenght'; did you mean 'length'?",
        ("--marker", "end"): "--marker is for results of runs, and 'spec-sweep' is a sweep",
        ("spec-sweep",): "sweeps are drawn one at a time",
    }
    for options, message in wrong.items():
        done = mbproj("plot", "spec-sweep", *options, folder=tmp_path)
        assert (done.returncode, message in done.stderr) == (2, True), done.stderr
