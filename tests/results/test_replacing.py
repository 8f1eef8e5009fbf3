"""OUT.part: it replaces OUT when a run ends, never blocks a run, and touches nothing that is not ours."""

from __future__ import annotations

import os
import platform
import queue
import subprocess
import threading

import h5py
import numpy as np
import pytest

from mbproj.base.errors import ExitCode, InputError, SimulationError
from mbproj.results import reader
from mbproj.results.crash_safety import check_output
from mbproj.results.faults import OutputError
from mbproj.results.file.opening import lock
from mbproj.results.reader import open_results
from mbproj.results.writer import ResultsWriter
from tests.cli.commands import mbproj as command
from tests.crossed import some
from tests.results.pendulum_blocks import NAMES, PATHS, block, part_of, record, scene, times
from tests.results.processes import WRITE_FOR_EVER, child, killed

# OUT.part without a living writer never blocks a run; one that is being written is never touched.

#: The run stops where it is about to do this, which `killed` then makes its end.
CREATING = """
    def stop(*arguments, **options):
        go()
        time.sleep(60)
    {}
    with ResultsWriter(sys.argv[1], scene(), NAMES):
        pass
"""
STAGES = {
    "the part is empty": "writer.ResultsWriter._image = stop",
    "room is reserved": "import os; os.pwrite = stop",
    "the file is written": "writer.write_whole = lambda *a, of=writer.write_whole: (of(*a), stop())",
    "it can be read": "writer.time.monotonic = stop",
}
CREATED_SLOWLY = """
    def stop(*arguments, of=writer.write_whole):
        of(*arguments)
        go()
        sys.stdin.readline()
    writer.write_whole = stop
    with ResultsWriter(sys.argv[1], scene(), NAMES) as recorder:
        recorder.write(block(times(5)))
"""
WITH_SAMPLES = """
    writer.FLUSH_SECONDS = 0.0
    with ResultsWriter(sys.argv[1], scene(), NAMES) as recorder:
        recorder.write(block(times(int(sys.argv[2]) if len(sys.argv) > 2 else 50)))
        go()
        sys.stdin.readline()
"""


@pytest.mark.parametrize("stage", STAGES)
def test_a_kill_while_the_file_is_created_blocks_nobody(tmp_path, stage):
    path = tmp_path / "out.h5"
    killed(CREATING.format(STAGES[stage]), path)
    assert (tmp_path / "out.h5.part").exists()
    record(path, block(times(5)))
    assert [entry.name for entry in tmp_path.iterdir()] == ["out.h5"]


@pytest.mark.parametrize("stage", STAGES)
def test_a_file_that_is_being_created_is_another_runs(tmp_path, stage):
    process = child(CREATING.format(STAGES[stage]), str(tmp_path / "out.h5"))
    process.stdout.readline()
    try:
        with pytest.raises(InputError) as caught:
            check_output(tmp_path / "out.h5")
    finally:
        process.kill()
        process.wait()
    who = (
        f" (process {process.pid} on '{platform.node()}')" if stage in ("the file is written", "it can be read") else ""
    )
    part = tmp_path / "out.h5.part"
    expected = f"error: another run{who} is writing '{part}'; wait for it, or choose another file with -o"
    assert str(caught.value) == expected


def test_who_looks_at_a_file_while_it_is_created_stops_no_run(tmp_path):
    process = child(CREATED_SLOWLY, str(tmp_path / "out.h5"))
    process.stdout.readline()
    with h5py.File(tmp_path / "out.h5.part") as file:
        _, errors = process.communicate("go on\n", timeout=60)
        assert (process.returncode, errors, file.filename) == (0, "", f"{tmp_path}/out.h5.part")
    assert len(open_results(tmp_path / "out.h5").time) == 5


def test_a_second_run_with_the_same_output_is_refused(tmp_path):
    path = tmp_path / "out.h5"
    process = child(WRITE_FOR_EVER, str(path))
    process.stdout.readline()
    try:
        for begin in (check_output, lambda path: ResultsWriter(path, scene(), NAMES).__enter__()):
            with pytest.raises(InputError, match=rf"another run \(process {process.pid} on '.*'\) is writing"):
                begin(path)
        shown = command("info", "out.h5", folder=tmp_path)
        assert (shown.returncode, "running (partial: it is being written)" in shown.stdout) == (0, True)
    finally:
        process.kill()
        process.wait()
    assert "(partial: the run was killed or still goes on)" in command("info", "out.h5", folder=tmp_path).stdout


def test_samples_of_a_killed_run_are_kept(tmp_path):
    path = tmp_path / "out.h5"
    for expected in ("out.h5.part.1", "out.h5.part.2"):
        killed(WITH_SAMPLES, path)
        with ResultsWriter(path, scene(), NAMES) as recorder:
            recorder.write(block(times(5)))
            assert recorder.set_aside == tmp_path / expected
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["out.h5", "out.h5.part.1", "out.h5.part.2"]
    with open_results(tmp_path / "out.h5.part.1") as results:
        assert np.array_equal(results["bodies/position"], block(times(50))["bodies/position"])


def test_a_damaged_part_is_kept(tmp_path):
    part = tmp_path / "out.h5.part"
    part.write_bytes(b"\x89HDF\r\n\x1a\n" + b"garbage" * 100)
    with ResultsWriter(tmp_path / "out.h5", scene(), NAMES) as recorder:
        assert recorder.set_aside == tmp_path / "out.h5.part.1"
    assert (tmp_path / "out.h5.part.1").read_bytes().endswith(b"garbage")


def test_a_part_of_somebody_else_is_refused(tmp_path):
    part = tmp_path / "out.h5.part"
    with h5py.File(part, "w") as file:
        file["data"] = 1.0
    for make in (lambda: None, lambda: part.write_bytes(b"\0" * 2**21), lambda: part.write_text("notes")):
        make()
        before = part.read_bytes()
        with pytest.raises(InputError, match="exists and is not a results file of mbproj, so it is not replaced"):
            check_output(tmp_path / "out.h5")
        assert part.read_bytes() == before
    part.unlink()
    part.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(InputError, match="is not replaced"):
        check_output(tmp_path / "out.h5")


@pytest.mark.parametrize("name", ["out.h5", "out.h5.part"])
def test_pipes_and_devices_are_refused_at_once(tmp_path, name):
    os.mkfifo(tmp_path / name)
    with pytest.raises(InputError) as caught:
        check_output(tmp_path / "out.h5")
    assert str(caught.value) == (
        f"error: '{tmp_path / name}' is a named pipe, not a results file; choose another file with -o"
    )


def test_a_damaged_file_is_not_replaced(tmp_path):
    path = record(tmp_path / "out.h5", block(times(5)))
    data = path.read_bytes()
    path.write_bytes(data[:3000])
    with pytest.raises(InputError) as caught:
        check_output(path)
    assert str(caught.value) == (
        f"error: '{path}' exists and cannot be read as results of mbproj, so it is not replaced; "
        "remove it if you do not need it, or choose another file with -o"
    )


def test_a_reader_of_a_running_run_leaves_its_lock(tmp_path):
    """A record lock of POSIX would end where the process closes any descriptor of the file."""
    path = tmp_path / "out.h5"
    with ResultsWriter(path, scene(), NAMES) as recorder:
        recorder.write(block(times(5)))
        recorder._flush()
        with open_results(path) as results:
            assert (results.status, len(results.time)) == ("running", 5)
        (recorder.part.open("rb")).close()
        other = child("from pathlib import Path; check_output(Path(sys.argv[1]))", str(path))
        _, errors = other.communicate(timeout=60)
        assert other.returncode != 0
        assert f"another run (process {os.getpid()} on" in errors
        recorder.write(block(times(5) + 0.05))
    with open_results(path) as results:
        assert (results.status, len(results.time)) == ("complete", 10)


def test_of_threads_with_one_output_one_wins_and_the_others_are_told(tmp_path):
    path, all_began, told = tmp_path / "out.h5", threading.Barrier(4), queue.SimpleQueue()

    def once() -> None:
        all_began.wait()
        try:
            with ResultsWriter(path, scene(), NAMES) as recorder:
                recorder.write(block(times(5)))
                all_tried.wait()
        except InputError as error:
            told.put(str(error))
            all_tried.wait()

    for _ in range(20):
        all_tried = threading.Barrier(4)
        threads = [threading.Thread(target=once) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        messages = [told.get_nowait() for _ in range(3)]
        assert all(" is writing " in message for message in messages)
        assert told.empty()
        assert [entry.name for entry in tmp_path.iterdir()] == ["out.h5"]
        with open_results(path) as results:
            assert (results.status, len(results.time)) == ("complete", 5)


def test_closed_results_say_so(tmp_path):
    results = open_results(record(tmp_path / "out.h5", block(times(5))))
    results.close()
    for look in (lambda: results["bodies/position"], lambda: results.time):
        with pytest.raises(InputError, match=r"out\.h5' is closed; open it again, with open_results"):
            look()


def test_a_part_that_has_just_begun_says_so_and_one_that_is_renamed_meanwhile_is_read(tmp_path, monkeypatch):
    """A run makes its part, and renames it, within milliseconds in which a reader may look."""
    monkeypatch.setattr(reader, "PAUSE", 0.0)
    path, part = tmp_path / "out.h5", tmp_path / "out.h5.part"
    with part.open("wb") as begun:
        assert lock(begun.fileno())
        with pytest.raises(InputError, match=r"a run is writing '.*', and has no samples yet; wait for it"):
            open_results(path)
    part.unlink()
    record(path, block(times(5)))
    path.rename(part)
    exists = reader._existing

    def looked_too_early(asked: object) -> object:
        found = exists(asked)
        if part.exists():
            part.rename(path)
        return found

    monkeypatch.setattr(reader, "_existing", looked_too_early)
    with open_results(path) as results:
        assert (results.status, len(results.time)) == ("complete", 5)


# OUT.part is renamed over OUT however a run ends but by a kill; what is not ours is never replaced.

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
