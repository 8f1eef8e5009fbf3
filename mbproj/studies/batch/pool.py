"""Running scenes in parallel processes. A process that hangs or dies is replaced, and its scene counts as failed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from mbproj.errors import ExitCode
from mbproj.results.files import part_path
from mbproj.studies.batch.result import SceneResult, Task
from mbproj.studies.batch.run import run_task
from mbproj.studies.parallel.hand_out import Where, in_parallel


def run_batch(tasks: Sequence[Task], where: Where, timeout: float, done: Callable[[int, SceneResult], None]) -> None:
    """Runs all tasks, and calls `done` with the number and the result of each as it ends.

    A scene that takes longer than `timeout` (s) is stopped. Raises KeyboardInterrupt after SIGINT or SIGTERM. No
    process is left behind.
    """
    for number, result in in_parallel(_run, Path.cwd(), tasks, where, _lost, timeout):
        done(number, result)


def _run(folder: Path, task: Task) -> SceneResult:
    return run_task(task, folder)


def _lost(task: Task, why: str, seconds: float) -> SceneResult:
    """The result of a task whose process died or was stopped. Its recorded part can be read."""
    part = part_path(task.output)
    kept = part if task.keep and part.exists() else None
    if kept is not None:
        why += f"; what it has recorded is in '{kept}'"
    return SceneResult(task.scene, ExitCode.FAILED, why, (), seconds, kept)
