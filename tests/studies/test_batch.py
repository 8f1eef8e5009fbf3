"""Scenes in processes of their own: those that are shipped hold; one that hangs, dies or is wrong stops no other."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from mbproj.base.errors import ExitCode, InputError
from mbproj.base.mechanisms_folder import mechanisms, validation_scenes
from mbproj.results.reader import open_results
from mbproj.studies.batch import SceneResult, Task, exit_code, run_batch, run_task, scene_paths, tasks
from mbproj.studies.parallel import workers
from tests.kernel.scenes import needs_kernel
from tests.studies.scenes import HOLDS, SHORT, failing, hanging, write, wrong


def batch(paths: list[Path], folder: Path, jobs: int = 2, timeout: float = 120.0) -> list[SceneResult]:
    done: dict[int, SceneResult] = {}
    run_batch(tasks(paths, folder, keep=False), jobs, timeout, done.__setitem__)
    assert sorted(done) == list(range(len(paths)))
    return [done[number] for number in range(len(paths))]


#: Of all processor time of the shipped scenes these four take half.
SLOW = ("andrews_squeezer", "bump_stop", "iftomm_n_four_bar_40", "iftomm_pendulum")


@needs_kernel
@pytest.mark.long
@pytest.mark.parametrize("slow", [False, pytest.param(True, marks=pytest.mark.full)])
def test_every_shipped_scene_holds_what_it_expects(slow: bool, tmp_path: Path) -> None:
    scenes = [path for path in (*mechanisms(), *validation_scenes()) if (path.stem in SLOW) is slow]
    found = batch(scenes, tmp_path)
    short = {
        (str(result.scene), outcome.expectation.name): outcome.share
        for result in found
        for outcome in result.outcomes
        if not outcome.holds
    }
    assert short == {}
    assert [(result.scene, result.code, result.message) for result in found] == [
        (scene, ExitCode.DONE, "") for scene in scenes
    ]
    assert all(len(result.outcomes) >= 2 for result in found)


def test_each_ends_in_its_own_way_and_the_others_go_on(tmp_path: Path) -> None:
    paths = [
        wrong(tmp_path),
        hanging(tmp_path),
        write(tmp_path, "short", HOLDS + SHORT),
        failing(tmp_path),
        write(tmp_path, "holds", HOLDS),
        write(tmp_path, "plain"),
    ]
    found = batch(paths, tmp_path / "results", timeout=3.0)
    assert [result.scene for result in found] == paths
    assert [result.word for result in found] == [
        "wrong input",
        "failed",
        "falls short",
        "failed",
        "holds",
        "ran",
    ]
    assert "unknown key 'mas'; did you mean 'mass'?" in found[0].message
    assert found[1].message == "stopped: it took longer than 3 s"
    assert 3.0 <= found[1].seconds < 30.0
    assert [outcome.holds for outcome in found[2].outcomes] == [True, False]
    assert "stopped at t = " in found[3].message
    assert exit_code(found) == exit_code(found[1:]) == ExitCode.FAILED
    assert exit_code([found[0], found[4]]) == ExitCode.FAILED
    assert exit_code([found[2], *found[4:]]) == ExitCode.CHECK_FAILED
    assert exit_code(found[4:]) == ExitCode.DONE
    assert list((tmp_path / "results").glob("*.h5")) == []


def test_a_process_that_is_killed_is_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the system does when memory runs out: the first scene's process, once it is at its task."""
    ask, killed = workers.Worker.ask, []

    def kill_and_ask(self: workers.Worker, item: Task, timeout: float | None = None) -> SceneResult:
        if item.scene.stem == "hanging":
            killed.append(self.process.pid)
            os.kill(self.process.pid, signal.SIGKILL)
        return ask(self, item, timeout)

    monkeypatch.setattr(workers.Worker, "ask", kill_and_ask)
    found = batch([hanging(tmp_path), write(tmp_path, "holds", HOLDS)], tmp_path, jobs=1)
    assert found[0].code == ExitCode.FAILED
    assert found[0].message == "its process ended with code -9: killed, or out of memory?"
    assert found[1].code == ExitCode.DONE
    assert len(killed) == 1


def test_results_that_are_kept_stand_as_the_scenes_do(tmp_path: Path) -> None:
    paths = [write(tmp_path / "a", "one", HOLDS), write(tmp_path / "a" / "b", "one", HOLDS)]
    todo = tasks(paths, tmp_path / "kept", keep=True)
    found = [run_task(task) for task in todo]
    assert [result.output for result in found] == [tmp_path / "kept" / "one.h5", tmp_path / "kept" / "b" / "one.h5"]
    with open_results(found[1].output) as results:
        assert (results.status, results.attributes["scene"]) == ("complete", str(paths[1]))
        assert results.attributes["degrees_of_freedom"] == 1


def test_scenes_of_one_stem_do_not_share_their_results(tmp_path: Path) -> None:
    path = write(tmp_path, "one")
    other = path.rename(tmp_path / "one.yml")
    write(tmp_path, "one")
    assert [task.output.name for task in tasks([path, other], tmp_path, keep=True)] == ["one.yaml.h5", "one.yml.h5"]


def test_paths_are_files_and_directories_each_scene_once_in_order(tmp_path: Path) -> None:
    b, a, deep = (write(tmp_path / "d", name) for name in ("b", "a", "deep/c"))
    (tmp_path / "d" / "notes.txt").write_text("no scene")
    assert scene_paths([tmp_path / "d", b, deep, tmp_path / "d" / ".." / "d" / "a.yaml"]) == [a, b, deep]
    assert scene_paths([b, tmp_path / "d"]) == [b, a]
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError) as raised:
        scene_paths([tmp_path / "nowhere.yaml", a, tmp_path / "empty"])
    assert [problem.message for problem in raised.value.problems] == [
        f"there is no '{tmp_path / 'nowhere.yaml'}'",
        f"'{tmp_path / 'empty'}' has no *.yaml in it",
    ]
    assert scene_paths([tmp_path / "d" / "[ac].y*", tmp_path / "d" / "**" / "?.yaml"]) == [a, b, deep]


@pytest.mark.full
def test_what_a_scene_recorded_before_its_time_was_up_is_kept(tmp_path: Path) -> None:
    done: dict[int, SceneResult] = {}
    scene = write(tmp_path, "hanging", "", "duration: 0.2, step: 0.01", "duration: 1e7, step: 1e-5, output_step: 1e-4")
    run_batch(tasks([scene], tmp_path / "kept", keep=True), 1, 3.0, done.__setitem__)
    part = tmp_path / "kept" / "hanging.h5.part"
    assert done[0].message == f"stopped: it took longer than 3 s; what it has recorded is in '{part}'"
    assert done[0].output == part
    with open_results(part) as results:
        assert results.status == "running"
        assert results.marker("end").position[0] == pytest.approx([1.0, 0.0, 0.0], abs=1e-15)


def test_a_fault_of_mbproj_is_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from mbproj.studies import batch as module

    monkeypatch.setattr(module, "record_run", lambda *scene, **attributes: 1 / 0)
    (task,) = tasks([write(tmp_path, "one")], tmp_path, keep=False)
    found = run_task(task)
    assert (found.code, found.word) == (ExitCode.INTERNAL, "fault of mbproj")
    assert "ZeroDivisionError: division by zero" in found.message
