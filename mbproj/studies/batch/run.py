"""Running one scene of a batch and checking its expectations."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from mbproj.analysis import Outcome, outcomes
from mbproj.dynamics import unique_components
from mbproj.ending import ending
from mbproj.errors import ExitCode, MbprojError, SimulationError
from mbproj.integrate import simulate
from mbproj.integrate.reporting.report import summary
from mbproj.linear.equilibrium.started import start_state
from mbproj.model import compile_system
from mbproj.results import ResultsWriter, open_results
from mbproj.scene import settings_to_run
from mbproj.scene.problem_places import placed_in
from mbproj.scene.read import SceneText
from mbproj.scene.text.source import read_text
from mbproj.studies.batch.result import SceneResult, Task

#: The current folder.
HERE = Path()


def run_task(task: Task, folder: Path = HERE) -> SceneResult:
    """Runs one scene and checks its expectations. The task's paths are relative to `folder`, wherever this process is.
    Any error is part of the result."""
    started = perf_counter()
    found: tuple[Outcome, ...] = ()
    code, message, formulation = ExitCode.DONE, "", None
    try:
        with _output(task, folder) as output:
            found, formulation = _outcomes(task, folder / task.scene, output)
        if not all(outcome.holds for outcome in found):
            code = ExitCode.CHECK_FAILED
    except MbprojError as error:
        code, message = error.exit_code, str(error)
        formulation = error.formulation if isinstance(error, SimulationError) else None
    except Exception as error:
        message, code = ending(error)
    kept = task.output if task.keep and (folder / task.output).exists() else None
    return SceneResult(task.scene, code, message, found, perf_counter() - started, kept, formulation)


@contextmanager
def _output(task: Task, folder: Path) -> Iterator[Path]:
    """The file for the results. A file that is not to be kept is removed. Without the folder of the task, on another
    machine, it is in a temporary folder."""
    output = folder / task.output
    if task.keep or output.parent.is_dir():
        try:
            yield output
        finally:
            if not task.keep:
                output.unlink(missing_ok=True)
        return
    with TemporaryDirectory(prefix="mbproj-batch-") as own:
        yield Path(own) / task.output.name


def _outcomes(task: Task, path: Path, output: Path) -> tuple[tuple[Outcome, ...], str]:
    """Run a scene into `output`; return the outcomes of its expectations and the formulation that ran."""
    started = perf_counter()
    scene = SceneText(read_text(path), str(task.scene), task.scene).scene()
    settings = settings_to_run(scene)
    system = compile_system(scene)
    state = start_state(scene, system)
    unique = unique_components(system, state)
    with (
        ResultsWriter(output, scene, system.names.as_mapping(), constants=unique) as recorder,
        placed_in(scene),
    ):
        report = simulate(system, state, settings, recorder, keep=recorder.keep)
        seconds = perf_counter() - started
        recorder.attributes(summary(str(task.scene), str(task.output), report, total_seconds=seconds))
    with open_results(output) as results:
        return tuple(outcomes(scene.expectations, results)), report.formulation
