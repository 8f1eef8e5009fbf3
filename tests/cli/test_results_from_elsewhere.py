"""Commands that read results say what is wrong with a file, with the exit code of it, and never show a traceback."""

from __future__ import annotations

import json
import os

import h5py
import pytest

from mbproj.base.errors import ExitCode
from mbproj.results.writer import ResultsWriter
from tests.cli.commands import FIVE_BAR, mbproj
from tests.results.pendulum_blocks import NAMES, block, record, scene, times
from tests.results.processes import killed

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
