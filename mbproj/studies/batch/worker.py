"""What runs in a process of its own: one scene after the other, as the pool hands them over."""

from __future__ import annotations

import os
import threading
import traceback
from multiprocessing import parent_process
from multiprocessing.connection import Connection, wait
from time import perf_counter

from mbproj.analysis import Outcome, outcomes
from mbproj.dynamics import assemble
from mbproj.errors import ExitCode, MbprojError, placed_at
from mbproj.integrate import simulate
from mbproj.integrate.report import summary
from mbproj.model import compile_system, initial_guess
from mbproj.results import ResultsWriter, open_results
from mbproj.scene import read_scene, settings_to_run
from mbproj.studies.batch.result import SceneResult, Task


def work(connection: Connection) -> None:
    """The process: says that it is there, then answers each Task with a SceneResult, until there are no more."""
    threading.Thread(target=_end_with_the_parent, daemon=True).start()
    try:
        connection.send(None)
        while True:
            connection.send(run_task(connection.recv()))
    except (EOFError, BrokenPipeError, KeyboardInterrupt):
        return


def run_task(task: Task) -> SceneResult:
    """Runs one scene and checks its expectations. Whatever goes wrong is in the result."""
    started = perf_counter()
    found: tuple[Outcome, ...] = ()
    code, message = ExitCode.DONE, ""
    try:
        found = _outcomes(task)
        if not all(outcome.holds for outcome in found):
            code = ExitCode.CHECK_FAILED
    except MbprojError as error:
        code, message = error.exit_code, str(error)
    except MemoryError:
        code, message = ExitCode.FAILED, "out of memory"
    except Exception:
        code, message = ExitCode.INTERNAL, traceback.format_exc()
    if not task.keep:
        task.output.unlink(missing_ok=True)
    output = task.output if task.keep and task.output.exists() else None
    return SceneResult(task.scene, code, message, found, perf_counter() - started, output)


def _outcomes(task: Task) -> tuple[Outcome, ...]:
    started = perf_counter()
    scene = read_scene(task.scene)
    settings = settings_to_run(scene)
    system = compile_system(scene)
    state = assemble(system, initial_guess(scene, system))
    with (
        placed_at(scene.place("simulation", "projection", "method")),
        ResultsWriter(task.output, scene, system.names.as_mapping()) as recorder,
    ):
        report = simulate(system, state, settings, recorder)
        seconds = perf_counter() - started
        recorder.attributes(summary(str(task.scene), str(task.output), report, total_seconds=seconds))
    with open_results(task.output) as results:
        return tuple(outcomes(scene.expectations, results))


def _end_with_the_parent() -> None:
    """Nobody waits for results when the parent is gone, killed perhaps: no process is left behind."""
    parent = parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(int(ExitCode.INTERRUPTED))
