"""OUT.part is renamed over OUT however a run ends but by a kill; what is not ours is never replaced."""

from __future__ import annotations

import os
import subprocess

import h5py
import numpy as np
import pytest

from mbproj.base.errors import ExitCode, InputError, SimulationError
from mbproj.results.crash_safety import check_output
from mbproj.results.faults import OutputError
from mbproj.results.reader import open_results
from mbproj.results.writer import ResultsWriter
from tests.crossed import some
from tests.results.pendulum_blocks import NAMES, PATHS, block, part_of, record, scene, times
from tests.results.processes import WRITE_FOR_EVER, child

FAILURE = SimulationError(0.73, "the mass matrix is singular", hint="try gpopm")


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (None, "complete"),
        (FAILURE, f"failed: {FAILURE}"),
        (KeyboardInterrupt(), "interrupted"),
        (InputError("wrong"), "failed: error: wrong"),
        (ZeroDivisionError("division by zero"), "failed: internal error: ZeroDivisionError: division by zero"),
    ],
)
def test_results_are_kept_however_the_run_ends(tmp_path, error, status):
    path, whole = record(tmp_path / "out.h5", block(times(3))), block(times(40))

    def run() -> None:
        with ResultsWriter(path, scene(), NAMES) as recorder:
            recorder.write(whole)
            assert (tmp_path / "out.h5.part").exists()
            with open_results(path) as old:
                assert len(old.time) == 3
            if error:
                raise error

    if error is None:
        run()
    else:
        with pytest.raises(type(error)):
            run()
    assert [entry.name for entry in tmp_path.iterdir()] == ["out.h5"]
    with open_results(path) as results:
        assert results.status == status
        assert not results.partial
        assert results.time.tobytes() == whole["time"].tobytes()


@pytest.mark.parametrize("seconds", some([0.0, 0.02, 0.1, 0.3], 2, 1))
def test_kill_leaves_out_untouched_and_part_readable(tmp_path, seconds):
    path = record(tmp_path / "out.h5", block(times(3)))
    before = path.read_bytes()
    process = child(WRITE_FOR_EVER, str(path))
    assert process.stdout.readline() == "go\n"
    try:
        process.wait(seconds)
    except subprocess.TimeoutExpired:
        process.kill()
    assert process.wait() == -9
    assert path.read_bytes() == before
    path.unlink()
    with open_results(path) as results:
        assert results.partial
        assert results.path == tmp_path / "out.h5.part"
        assert results.status == "running"
        samples = len(results.time)
        assert samples % 7 == 0
        parts = [block(times(7) + 0.07 * i) for i in range(samples // 7)] or [block(times(0))]
        for name in PATHS:
            assert np.array_equal(results[name], np.concatenate([part[name] for part in parts])), name


def test_results_can_be_read_while_they_are_written(tmp_path):
    path = tmp_path / "out.h5"
    code = """
        writer.FLUSH_SECONDS = 0.0
        with ResultsWriter(sys.argv[1], scene(), NAMES) as recorder:
            recorder.write(block(times(50)))
            go()
            sys.stdin.readline()
    """
    process = child(code, str(path))
    try:
        process.stdout.readline()
        with open_results(path) as results:
            assert (results.partial, results.status, len(results.time)) == (True, "running", 50)
            assert np.array_equal(results["bodies/position"], block(times(50))["bodies/position"])
    finally:
        process.kill()
        process.wait()


FULL_DISK = """
    import resource
    writer.FLUSH_SECONDS = 0.0
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_500_000, 1_500_000))
    try:
        with ResultsWriter(sys.argv[1], scene(), NAMES) as recorder:
            for i in range(4000):
                recorder.write(block(times(37) + 0.37 * i))
    except writer.OutputError as error:
        print(error)
        sys.exit(error.exit_code)
"""


def test_a_full_disk_keeps_what_was_written(tmp_path):
    path = tmp_path / "out.h5"
    process = child(FULL_DISK, str(path))
    message, errors = process.communicate()
    assert (process.returncode, errors) == (ExitCode.FAILED, "")
    assert OutputError.exit_code == ExitCode.FAILED
    with open_results(path) as results:
        assert len(results.time) >= 37
        assert len(results.time) % 37 == 0
        expected = f"no room for results after t = {results.time[-1]:.6g} s in '{path}': File too large"
        assert message.startswith(expected)
        assert results.status == f"failed: {message.strip()}"
        assert results["bodies/position"].shape == (len(results.time), 1, 3)


def test_what_is_not_ours_is_not_replaced(tmp_path):
    path = tmp_path / "thesis.h5"
    with h5py.File(path, "w") as file:
        file["data"] = [1.0, 2.0]
    before = path.read_bytes()
    with pytest.raises(InputError) as caught:
        ResultsWriter(path, scene(), NAMES)
    assert str(caught.value) == (
        f"error: '{path}' exists and is not a results file of mbproj, so it is not replaced; "
        "remove it, or choose another file with -o"
    )
    assert path.read_bytes() == before


@pytest.mark.parametrize("name", ["out.h5", "out.h5.part"])
def test_text_files_are_not_replaced(tmp_path, name):
    (tmp_path / name).write_text("my notes")
    with pytest.raises(InputError, match=f"{name}' exists and is not a results file of mbproj"):
        check_output(tmp_path / "out.h5")
    assert (tmp_path / name).read_text() == "my notes"


def test_places_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    cases = {
        tmp_path: f"error: '{tmp_path}' is a directory; give a file in it, e.g. {tmp_path}/results.h5",
        tmp_path / "no" / "out.h5": f"error: the directory '{tmp_path}/no' of '{tmp_path}/no/out.h5' does not exist; "
        "create it, or choose another file with -o",
        tmp_path / ("x" * 300): f"error: cannot write '{tmp_path / ('x' * 300)}': File name too long; "
        "choose another file with -o",
    }
    for path, message in cases.items():
        with pytest.raises(InputError) as caught:
            ResultsWriter(path, scene(), NAMES).__enter__()
        assert str(caught.value) == message
    with pytest.raises(InputError, match="file' is a file, not a directory"):
        check_output(tmp_path / "file" / "out.h5")
    (tmp_path / "out.h5.part").mkdir()
    with pytest.raises(InputError, match=r"out.h5.part' is a directory"):
        check_output(tmp_path / "out.h5")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_directory_without_permission(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="Permission denied; choose another file with -o"):
        ResultsWriter(tmp_path / "out.h5", scene(), NAMES).__enter__()


def test_a_link_is_followed(tmp_path):
    (tmp_path / "scratch").mkdir()
    link = tmp_path / "out.h5"
    link.symlink_to(tmp_path / "scratch" / "real.h5")
    record(link)
    assert link.is_symlink()
    assert [entry.name for entry in (tmp_path / "scratch").iterdir()] == ["real.h5"]


def test_interruption_within_a_flush_loses_nothing(tmp_path, monkeypatch):
    """Ctrl-C while datasets are half appended: the end of the run appends the same samples again."""
    path, whole = tmp_path / "out.h5", block(times(30))
    flush = ResultsWriter._flush

    def interrupted(self: ResultsWriter) -> None:
        self._file["bodies/position"].resize(17, axis=0)
        monkeypatch.setattr(ResultsWriter, "_flush", flush)
        raise KeyboardInterrupt

    monkeypatch.setattr("mbproj.results.writer.FLUSH_SECONDS", 0.0)
    monkeypatch.setattr(ResultsWriter, "_flush", interrupted)
    recorder = ResultsWriter(path, scene(), NAMES)
    with pytest.raises(KeyboardInterrupt), recorder:
        recorder.write(part_of(whole, slice(0, 30)))
    with open_results(path) as results:
        assert results.status == "interrupted"
        for name in PATHS:
            assert results[name].tobytes() == whole[name].tobytes()
