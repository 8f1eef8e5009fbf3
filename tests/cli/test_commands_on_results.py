"""Commands that read results: whether two are of the same motion, and what is said of a file that is wrong."""

from __future__ import annotations

import json
import os
from pathlib import Path

import h5py
import pytest

from mbproj.base.errors import ExitCode
from mbproj.results.writer import ResultsWriter
from tests.cli.commands import FIVE_BAR, mbproj, succeeds
from tests.results.pendulum_blocks import NAMES, block, record, scene, times
from tests.results.processes import killed

# Commands that read results say what is wrong with a file, with the exit code of it, and never show a traceback.

READERS = (
    ("info", "R"),
    ("info", "R", "--check"),
    ("export", "R"),
    ("plot", "R"),
    ("rerun", "R", "-o", "again.h5"),
    ("compare-results", "R", "R"),
    ("verify", FIVE_BAR, "--store", "R"),
    ("run", FIVE_BAR, "-o", "R"),
)


@pytest.mark.parametrize("command", READERS, ids=lambda command: command[0])
def test_a_pipe_is_refused_at_once(tmp_path, command):
    os.mkfifo(tmp_path / "R")
    done = mbproj(*command, folder=tmp_path)
    assert done.returncode == ExitCode.BAD_INPUT
    assert "'R' is a named pipe, not a results file" in done.stderr


@pytest.mark.parametrize("command", READERS, ids=lambda command: command[0])
def test_a_torn_file_is_refused(tmp_path, command):
    """Zeros where HDF5 keeps the names of the groups: who believes them reads the same place for ever."""
    data = bytearray(record(tmp_path / "R", block(times(20))).read_bytes())
    for heap in (b"FRHP", b"FHDB", b"GCOL"):
        while (start := data.find(heap)) >= 0:
            data[start : start + 512] = bytes(512)
    (tmp_path / "R").write_bytes(data)
    done = mbproj(*command, folder=tmp_path)
    assert done.returncode == ExitCode.BAD_INPUT
    assert "is damaged" in done.stderr or "cannot be read as results of mbproj" in done.stderr
    assert "Traceback" not in done.stderr


def test_info_check(tmp_path):
    path = record(tmp_path / "R", block(times(20)))
    done = mbproj("info", "R", "--check", folder=tmp_path)
    assert (done.returncode, done.stderr) == (ExitCode.DONE, "")
    assert done.stdout.endswith("MB of samples\n  nothing is wrong with it\n")
    with h5py.File(path, "r") as file:
        place = file["bodies/position"].id.get_chunk_info(0).byte_offset
    with path.open("r+b") as file:
        file.seek(place + 17)
        file.write(b"\x55")
    done = mbproj("info", "R", "--check", folder=tmp_path)
    assert done.returncode == ExitCode.CHECK_FAILED
    assert "  wrong: 'bodies/position' cannot be read, samples 0 to 19\n" in done.stdout
    found = json.loads(mbproj("info", "R", "--check", "--json", folder=tmp_path).stdout)
    assert (found["sound"], found["faults"]) == (False, ["'bodies/position' cannot be read, samples 0 to 19"])
    assert mbproj("info", "--check", folder=tmp_path).returncode == ExitCode.BAD_INPUT


def test_a_run_says_where_the_samples_of_a_killed_one_are(tmp_path):
    code = """
        writer.FLUSH_SECONDS = 0.0
        with ResultsWriter(sys.argv[1], scene(), NAMES) as recorder:
            recorder.write(block(times(50)))
            go()
            sys.stdin.readline()
    """
    killed(code, tmp_path / "R")
    done = mbproj("info", "R", "--check", folder=tmp_path)
    assert done.returncode == ExitCode.DONE
    assert done.stdout.endswith("run has not ended: samples have Fletcher-32 alone, which takes 16 ones for 16 zeros\n")
    done = mbproj("run", FIVE_BAR, "--duration", "0.01", "-o", "R", folder=tmp_path)
    assert done.returncode == ExitCode.DONE
    assert "note: 'R.part', which a killed run had left, is kept as 'R.part.1'\n" in done.stderr
    assert sorted(entry.name for entry in tmp_path.iterdir() if entry.name != "cache") == ["R", "R.part.1"]


def test_a_file_that_is_being_written_is_not_touched(tmp_path):
    recorder = ResultsWriter(tmp_path / "R", scene(), NAMES)
    with recorder:
        recorder.write(block(times(5)))
        done = mbproj("run", FIVE_BAR, "-o", "R", folder=tmp_path)
    assert done.returncode == ExitCode.BAD_INPUT
    assert f"another run (process {os.getpid()} on " in done.stderr
    assert "remove" not in done.stderr


@pytest.mark.parametrize(
    ("command", "code"),
    [
        (("info", "R"), 0),
        (("info", "R", "--check"), 0),
        (("export", "R"), 0),
        (("plot", "R"), 2),
        (("compare-results", "R", "R"), 2),
    ],
)
def test_a_run_without_samples(tmp_path, command, code):
    """As a kill leaves it that comes before the first second is over."""
    record(tmp_path / "R", block(times(0)))
    done = mbproj(*command, folder=tmp_path)
    assert (done.returncode, "Traceback" in done.stderr) == (code, False)
    if command[0] == "export":
        table = (tmp_path / "R-body-bob.csv").read_text(encoding="utf-8").splitlines()
        assert [len(table), table[0][:8]] == [1, "time (s)"]


# `mbproj compare-results`: is it the same motion?


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs")
    for name, *options in (("a.h5",), ("b.h5", "--output-step", "0.02"), ("c.h5", "--step", "0.02")):
        succeeds("run", FIVE_BAR, "-q", "--duration", "2", "-o", name, *options, folder=folder)
    return folder


def test_other_samples_of_one_run_are_the_same_motion(runs: Path) -> None:
    done = mbproj("compare-results", "a.h5", "b.h5", "--tolerance", "1e-15", folder=runs)
    lines = done.stdout.splitlines()
    assert lines[:3] == [
        "a.h5: 201 samples to t = 2 s",
        "b.h5: 101 samples to t = 2 s",
        "compared at the 101 times that both have",
    ]
    assert lines[4].split() == ["bodies/position", "0.00e+00", "m", "bar1", "0", "s", *lines[4].split()[6:8], "same"]
    assert (lines[-1], done.returncode) == ("the same motion", 0)


def test_another_step_is_another_motion(runs: Path) -> None:
    done = mbproj("compare-results", "a.h5", "c.h5", folder=runs)
    assert done.returncode == 4
    assert done.stdout.splitlines()[-1].startswith("they part at t = 0.")
    assert mbproj("compare-results", "a.h5", "c.h5", "--tolerance", "0.01", folder=runs).returncode == 0


def test_json(runs: Path) -> None:
    done = mbproj("compare-results", "a.h5", "c.h5", "--absolute", "markers/position=1 inch", "--json", folder=runs)
    assert done.returncode == 2  # no such unit
    done = mbproj("compare-results", "a.h5", "c.h5", "--absolute", "markers/position=1 um", "--json", folder=runs)
    found = json.loads(done.stdout)
    assert (found["same"], done.returncode, found["samples_compared"], found["ends"]) == (False, 4, 101, [2.0, 2.0])
    marker = next(each for each in found["quantities"] if each["quantity"] == "markers/position")
    assert (marker["allowed"], marker["largest"]["of"], marker["same"]) == (1e-6, "tip", False)
    assert marker["first"]["difference"] > 1e-6
    assert found["parting"]["time"] == min(each["first"]["time"] for each in found["quantities"] if each["first"])


def test_mistakes(runs: Path) -> None:
    for options, message in (
        (["--tolerance", "0"], "--tolerance: error: '--tolerance' must be greater than 0, found 0\n"),
        (
            ["--absolute", "marker/position=1"],
            "--absolute: error: there is no quantity 'marker/position'; did you mean 'markers/position'?\n",
        ),
        (["--absolute", "bodies/position=1 kg"], "--absolute: error: '--absolute' is in m, this is a mass, in kg\n"),
    ):
        done = mbproj("compare-results", "a.h5", "b.h5", *options, folder=runs)
        assert (done.returncode, done.stderr) == (2, message)
    missing = mbproj("compare-results", "a.h5", "d.h5", folder=runs)
    assert (missing.returncode, missing.stderr[:35]) == (2, "error: there is no results file 'd.")
