"""`mbproj sweep` as a shell sees it: what it prints and writes, exit codes, and what a kill leaves."""

from __future__ import annotations

import csv
import json
import os
import shutil
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
from matplotlib.pyplot import imread

from mbproj.studies.sweep.store import CASES as STORED_CASES
from tests.cli.commands import begun, mbproj, succeeds
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


@pytest.mark.full
def test_it_draws_what_it_has_measured(tmp_path):
    """The first picture that suits the design, as `mbproj plot` draws it; a note where no case has a number."""
    write(tmp_path, "  length: [0.8, 1.2, 1.6]\n")
    done = mbproj("sweep", "spec.yaml", "--plot", "drop.png", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "drop.png\n")
    assert mbproj("plot", "spec-sweep", folder=tmp_path).stdout == "spec-sweep-lines.png\n"
    np.testing.assert_array_equal(imread(tmp_path / "drop.png"), imread(tmp_path / "spec-sweep-lines.png"))
    done = mbproj("sweep", "spec.yaml", "--plot", "drop.png", "--write-table", "t.csv", "--json", folder=tmp_path)
    tables = ["spec-sweep/summary.csv", "spec-sweep/summary.h5"]
    assert json.loads(done.stdout)["files"] == [*tables, "drop.png", "t.csv"]
    refused = mbproj("sweep", "spec.yaml", "--plot", "drop.doc", folder=tmp_path)
    assert refused.returncode == 2 and "'drop.doc'" in refused.stderr
    write(tmp_path, "  fails: [1]\n")
    none = mbproj("sweep", "spec.yaml", "--plot", "none.png", folder=tmp_path)
    assert none.returncode == 3 and "note: no picture: " in none.stderr


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
    store = tmp_path / "spec-sweep" / "store.sqlite-wal"
    filled = lambda: store.exists() and store.stat().st_size > 120_000  # noqa: E731
    running = begun("sweep", "spec.yaml", "-j", "1", folder=tmp_path, when=filled)
    running.send_signal(signal.SIGKILL)
    assert running.wait() == -signal.SIGKILL
    with closing(sqlite3.connect(tmp_path / "spec-sweep" / "store.sqlite")) as database:
        (kept,) = database.execute("SELECT count(*) FROM kept WHERE study = 'cases'").fetchone()
    assert 0 < kept < 60
    done = json.loads(mbproj("sweep", "spec.yaml", "--json", folder=tmp_path).stdout)
    assert (done["reused"], done["computed"], done["failed"]) == (kept, 60 - kept, 0)


FULL_DISK = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (120_000, 120_000))
from mbproj.commands.main import main
sys.argv = ["mbproj", "sweep", "spec.yaml", "-j", "2", "--json"]
main()
"""


@pytest.mark.full
@pytest.mark.skipif(os.name != "posix", reason="limits the size of files")
@pytest.mark.parametrize("keep", ["none", "all"])
def test_a_full_disk_ends_a_sweep_and_what_wanted_room_runs_again(tmp_path, keep):
    """Files of at most 120 kB: of rows there is room for some, of results files for none."""
    write(tmp_path, f"  length: 1:2:{40 if keep == 'none' else 3}\n", more=f"keep: {keep}\n")
    program = [sys.executable, "-c", FULL_DISK]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(program, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert (done.returncode, "Traceback" in done.stderr) == (3, False), done.stderr
    if keep == "none":
        assert "start the sweep again: what is whole in it is not computed again" in done.stderr
    else:
        assert {each["status"] for each in json.loads(done.stdout)["failures"]} == {"crashed"}
    assert list(tmp_path.glob("spec-sweep/cases/.*")) == []
    again = json.loads(mbproj("sweep", "spec.yaml", "--json", folder=tmp_path).stdout)
    assert (again["failed"], again["left"]) == (0, 0)
    assert (again["reused"] > 0) == (keep == "none")


@pytest.mark.skipif(os.name != "posix", reason="sends SIGINT")
def test_an_interrupted_sweep_has_its_tables_and_says_how_to_go_on(tmp_path):
    write(tmp_path, "  length: 1:2:60\n  simulation.duration: 0.9\n  simulation.step: 1e-4\n", more="keep: all\n")
    some = lambda: list(tmp_path.glob("spec-sweep/cases/[0-9a-f]*.h5"))  # noqa: E731
    running = begun("sweep", "spec.yaml", "-j", "1", "--fresh", folder=tmp_path, when=some)
    running.send_signal(signal.SIGINT)
    _, said = running.communicate()
    assert (running.returncode, said) == (130, "interrupted; go on with: mbproj sweep spec.yaml\n")
    with (tmp_path / "spec-sweep" / "summary.csv").open(encoding="utf-8") as file:
        statuses = [row["status"] for row in csv.DictReader(file)]
    assert "not run" in statuses
    assert {*statuses} <= {"done", "not run"}
    assert list(tmp_path.glob("spec-sweep/cases/.*")) == []
    with h5py.File(tmp_path / "spec-sweep" / "summary.h5") as file:
        assert file["status"].asstr()[()].reshape(-1).tolist() == statuses


@pytest.mark.full
@pytest.mark.skipif(os.name != "posix", reason="sends SIGINT")
def test_who_presses_ctrl_c_again_and_again_sees_no_traceback(tmp_path):
    write(tmp_path, "  length: 1:2:60\n  simulation.duration: 0.9\n  simulation.step: 1e-4\n")
    store = tmp_path / "spec-sweep" / "store.sqlite-wal"
    filled = lambda: store.exists() and store.stat().st_size > 60_000  # noqa: E731
    running = begun("sweep", "spec.yaml", "-j", "2", folder=tmp_path, when=filled)
    while running.poll() is None:
        running.send_signal(signal.SIGINT)
        time.sleep(0.02)
    said = running.stderr.read()
    assert (running.returncode, "Traceback" in said, "Exception" in said) == (130, False, False), said


@pytest.mark.full
def test_a_check_of_its_folder_finds_what_is_damaged(tmp_path):
    write(tmp_path, "  length: [1, 2]\n", more="keep: all\n")
    assert mbproj("sweep", "spec.yaml", "-q", folder=tmp_path).returncode == 0
    folder = tmp_path / "spec-sweep"
    done = mbproj("info", "--check", "spec-sweep", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "spec-sweep: 2 rows and 2 results files read\n  nothing is wrong with it\n"
    with closing(sqlite3.connect(folder / "store.sqlite")) as database, database:
        database.execute("UPDATE kept SET value = substr(value, 2) WHERE study = ?", [STORED_CASES])
    with h5py.File(folder / "summary.h5", "r+") as file:
        file["seconds"][0] = 7.0
    table = (folder / "summary.csv").read_bytes()
    (folder / "summary.csv").write_bytes(table[:-3] + bytes([table[-3] ^ 1]) + table[-2:])
    results = next(folder.glob("cases/*.h5"))
    with h5py.File(results, "r+") as file:
        file["time"].attrs["units"] = "h"
    before = (folder / "store.sqlite").read_bytes()
    found = json.loads(mbproj("info", "--check", "--json", "spec-sweep", folder=tmp_path).stdout)
    rows, changed, arrays, *case = found["faults"]
    assert (found["sound"], rows) == (False, "store.sqlite: 2 of 3 rows are damaged")
    assert changed == "summary.csv: it is not as it was written"
    assert "summary.h5" in arrays and "'seconds' is not what was written: its checksum differs" in arrays
    assert {fault.partition(":")[0] for fault in case} == {f"cases/{results.name}"}
    assert found["damaged"] == [f"cases/{results.name}"]
    assert (folder / "store.sqlite").read_bytes() == before
    done = mbproj("info", "--check", "spec-sweep", folder=tmp_path)
    assert f"  delete 'spec-sweep/cases/{results.name}': a sweep keeps" in done.stdout
    results.unlink()  # and what it says next leads to a folder that is sound
    assert "start the sweep again: it computes what is damaged or missing" in done.stdout
    assert mbproj("sweep", "spec.yaml", "-q", folder=tmp_path).returncode == 0
    assert mbproj("info", "--check", "spec-sweep", folder=tmp_path).returncode == 0
    (folder / "summary.csv").write_bytes(table.replace(b"case", b"cale", 1))
    (fault,) = json.loads(mbproj("info", "--check", "--json", "spec-sweep", folder=tmp_path).stdout)["faults"]
    assert fault.endswith("it is not as it was written, and not to be told from another program's: remove it")
    (folder / "summary.csv").write_bytes(table)
    with closing(sqlite3.connect(folder / "store.sqlite")) as database, database:  # as an older mbproj left it
        database.execute("DELETE FROM kept WHERE study = 'about'")
    found = json.loads(mbproj("info", "--check", "--json", "spec-sweep", folder=tmp_path).stdout)
    assert (found["sound"], found["unguarded"]) == (True, ["summary.csv"])
    succeeds("sweep", "spec.yaml", "-q", folder=tmp_path)  # which tells the store again
    (tmp_path / "other.yaml").write_text((tmp_path / "spec.yaml").read_text(encoding="utf-8"), encoding="utf-8")
    succeeds("sweep", "other.yaml", "-q", folder=tmp_path)
    shutil.copy(tmp_path / "other-sweep" / "summary.h5", folder)
    (fault,) = json.loads(mbproj("info", "--check", "--json", "spec-sweep", folder=tmp_path).stdout)["faults"]
    assert fault == "summary.h5: it is not as it was written, or that of another sweep"
    done = mbproj("info", "--check", ".", folder=tmp_path)
    assert (done.returncode, "is not the folder of a sweep" in done.stderr) == (2, True)


def test_failed_cases_run_again_when_they_are_to(tmp_path):
    write(tmp_path, "  fails: [0, 1]\n")
    assert mbproj("sweep", "spec.yaml", "-q", folder=tmp_path).returncode == 3
    again = json.loads(mbproj("sweep", "spec.yaml", "--json", "--retry-failed", folder=tmp_path).stdout)
    assert (again["computed"], again["reused"], again["failed"]) == (1, 1, 1)


@pytest.mark.parametrize("name", ["summary.csv", "summary.h5"])
def test_what_the_user_has_in_the_folder_is_not_replaced(tmp_path, name):
    """Nor is what a link there leads to, and that is said before a case runs. Our own are, whatever varied in them."""
    for vary in ("length: [1]", "bodies.bar.mass: [1, 2]", "bodies.bar.mass: [1, 2, 3]"):
        write(tmp_path, f"  {vary}\n")
        done = succeeds("sweep", "spec.yaml", "-q", "--dry-run" if vary.endswith("3]") else "-q", folder=tmp_path)
    ours = tmp_path / "spec-sweep" / name
    for link in (False, True):
        mine = tmp_path / "mine" if link else ours
        mine.write_text("case,thesis\n1,2\n")
        if link:
            ours.unlink()
            ours.symlink_to(mine)
        done = mbproj("sweep", "spec.yaml", folder=tmp_path)
        assert done.returncode == 2
        assert f"'spec-sweep/{name}' exists and is not " in done.stderr
        assert "give --force, or choose another folder with -o" in done.stderr
        assert mine.read_text() == "case,thesis\n1,2\n"
    done = mbproj("sweep", "spec.yaml", "--force", "--json", folder=tmp_path)
    assert json.loads(done.stdout)["computed"] == 1


def test_a_report_that_is_not_ours_is_replaced_with_force(tmp_path):
    write(tmp_path, "  length: [1]\n")
    (tmp_path / "cases.xml").write_text("<mine/>")
    done = mbproj("sweep", "spec.yaml", "--junit", "cases.xml", folder=tmp_path)
    assert (done.returncode, "give --force" in done.stderr) == (2, True)
    assert mbproj("sweep", "spec.yaml", "--junit", "cases.xml", "--force", folder=tmp_path).returncode == 0


def test_its_folder_is_drawn(tmp_path, undrawn):
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
