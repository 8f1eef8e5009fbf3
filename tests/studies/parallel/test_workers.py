"""Processes and bundles of items: every item once, and no innocent one is blamed."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from itertools import count, islice

import pytest

from mbproj.base.errors import MbprojWarning
from mbproj.studies.parallel import hand_out, workers
from mbproj.studies.parallel.hand_out import LARGEST, in_bundles, in_parallel
from tests.studies.tasks import die, environment, fragile, module_file, place
from tests.support import ROOT

# Processes: every item once, in another process, faults handed on, and none left behind.


def test_items_run_elsewhere_and_each_once():
    found = dict(in_parallel(place, "shared", [3, 0, 1, 2], where=2))
    assert sorted(found) == [0, 1, 2, 3]
    assert {shared for shared, _ in found.values()} == {"shared"}
    pids = {pid for _, pid in found.values()}
    assert os.getpid() not in pids
    assert len(pids) == 2


def test_they_run_the_caller_s_mbproj_whatever_the_current_folder_holds(tmp_path, monkeypatch):
    (tmp_path / "mbproj").mkdir()
    (tmp_path / "mbproj" / "__init__.py").write_text("raise ImportError('the folder beside it')")
    monkeypatch.chdir(tmp_path)
    found = dict(in_parallel(module_file, "mbproj.studies.parallel.workers", [0, 0], where=2))
    assert set(found.values()) == {workers.__file__}


def test_processes_have_one_thread_each(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    found = dict(in_parallel(environment, ["OMP_NUM_THREADS", "MKL_NUM_THREADS"], [0, 0], where=2))
    assert found == {0: ["1", "1"], 1: ["1", "1"]}


def test_few_items_start_few_processes(monkeypatch):
    """Items without a length, as of a sweep: nobody knows before how many there are."""
    started = []
    real = workers.subprocess.Popen
    monkeypatch.setattr(workers.subprocess, "Popen", lambda *given, **more: started.append(1) or real(*given, **more))
    monkeypatch.setattr(hand_out, "MOST", 100_000)
    assert len(list(in_parallel(place, "few", iter([0, 0, 0]), where=100_000))) == 3
    assert 1 <= len(started) <= 3


def test_no_more_processes_are_started_than_the_machine_can_use(monkeypatch):
    monkeypatch.setattr(hand_out, "processors", lambda: 1)
    monkeypatch.setattr(hand_out, "MOST", 2)
    with pytest.warns(MbprojWarning, match="100000 processes are more than 1 processors can use: at most 2"):
        found = dict(in_parallel(place, "many", iter([5] * 12), where=100_000))
    assert len({pid for _, pid in found.values()}) <= 2


@pytest.mark.skipif(os.name != "posix", reason="closes pipes of another process")
@pytest.mark.parametrize("when", ["in the middle of a message", "before the answer"])
def test_a_worker_whose_study_was_killed_says_nothing(tmp_path, when):
    said = tmp_path / "said"
    with said.open("w") as stderr:
        program = [sys.executable, "-c", "from mbproj.studies.parallel.worker import main; main()"]
        process = subprocess.Popen(program, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=stderr, cwd=ROOT)
    pickle.dump((environment, ["HOME"]), process.stdin)
    process.stdin.flush()
    assert pickle.load(process.stdout) == "ready"
    if when == "before the answer":
        process.stdout.close()
        pickle.dump(0, process.stdin)
        process.stdin.flush()
    else:
        process.stdin.write(pickle.dumps([0.0] * 100)[:50])
        process.stdin.close()
    assert process.wait(60) == 0
    assert said.read_text() == ""


def test_what_is_lost_has_a_result_too():
    results = in_parallel(place, "x", [0, 500, 0], 1, lambda item, why, seconds: (why, round(seconds)), timeout=1.0)
    found = dict(results)
    assert found[1] == ("stopped: it took longer than 1 s", 1)
    assert found[0][1] != found[2][1]  # by another process


def test_one_process_is_this_one():
    assert list(in_parallel(place, "x", [0, 0], where=1)) == [(0, ("x", os.getpid())), (1, ("x", os.getpid()))]


def test_a_fault_is_raised_here_and_no_process_is_left():
    results = in_parallel(place, "fault", [0, -1, 100, 100], where=2)
    with pytest.raises(ValueError, match="fault -1"):
        for _ in results:
            pass


def test_a_process_that_dies_is_said_to():
    with pytest.raises(RuntimeError, match="its process ended with code 1"):
        list(in_parallel(die, None, [1, 1], where=2))


def test_leaving_early_ends_the_processes():
    """The items that they have begun would take an hour each."""
    results = in_parallel(place, "early", [0, 0, 360_000, 360_000], where=2)
    pids = {next(results)[1][1], next(results)[1][1]}
    results.close()
    for pid in pids:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)


# Bundles of short items: every one once, whatever happens to the processes, and no innocent one is blamed.


def lost(item: int, why: str, seconds: float) -> str:
    return why.split(":")[0].split(" with")[0]


def test_all_items_come_back_and_only_the_guilty_are_blamed():
    found = [pair for ended in in_bundles(fragile, 30.0, range(40), 2, lost, timeout=0.5) for pair in ended]
    assert sorted(item for item, _ in found) == list(range(40))
    expected = {item: item * item for item in range(40)} | {13: "its process ended", 17: "stopped"}
    assert dict(found) == expected


def test_items_are_taken_as_they_are_needed():
    """Of an endless supply, so that any number may be handed out."""
    taken = count()
    ended = in_bundles(fragile, 0.0, (100 + item for item in taken), 1, lost)
    some = list(islice((item for found in ended for item, _ in found), 5))
    ended.close()
    assert sorted(some) == [100, 101, 102, 103, 104]
    assert next(taken) < LARGEST
