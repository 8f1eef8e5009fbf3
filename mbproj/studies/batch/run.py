"""One scene of a batch: run, and held against what it expects."""

from __future__ import annotations

from dataclasses import astuple
from time import perf_counter

from mbproj.analysis import Outcome, outcomes
from mbproj.dynamics import unique_components
from mbproj.ending import ending
from mbproj.errors import ExitCode, MbprojError, SimulationError
from mbproj.integrate import simulate
from mbproj.integrate.events.time_events import events_of
from mbproj.integrate.outcome.report import summary
from mbproj.linear.equilibrium.started import start_state
from mbproj.model import compile_system
from mbproj.results import ResultsWriter, open_results
from mbproj.results.events import RecordedEvent
from mbproj.scene import read_scene, settings_to_run
from mbproj.scene.problem_places import placed_in
from mbproj.studies.batch.result import SceneResult, Task


def run_task(task: Task) -> SceneResult:
    """Runs one scene and checks its expectations. Whatever goes wrong is in the result."""
    started = perf_counter()
    found: tuple[Outcome, ...] = ()
    code, message, formulation = ExitCode.DONE, "", None
    try:
        found, formulation = _outcomes(task)
        if not all(outcome.holds for outcome in found):
            code = ExitCode.CHECK_FAILED
    except MbprojError as error:
        code, message = error.exit_code, str(error)
        formulation = error.formulation if isinstance(error, SimulationError) else None
    except Exception as error:
        message, code = ending(error)
    if not task.keep:
        task.output.unlink(missing_ok=True)
    output = task.output if task.keep and task.output.exists() else None
    return SceneResult(task.scene, code, message, found, perf_counter() - started, output, formulation)


def _outcomes(task: Task) -> tuple[tuple[Outcome, ...], str]:
    """What became of the expectations, and the formulation that ran."""
    started = perf_counter()
    scene = read_scene(task.scene)
    settings = settings_to_run(scene)
    system = compile_system(scene)
    state = start_state(scene, system)
    unique = unique_components(system, state)
    with (
        ResultsWriter(task.output, scene, system.names.as_mapping(), constants=unique) as recorder,
        placed_in(scene),
    ):
        recorder.events([RecordedEvent(*astuple(event)) for event in events_of(system, state.t, settings)])
        report = simulate(system, state, settings, recorder)
        seconds = perf_counter() - started
        recorder.attributes(summary(str(task.scene), str(task.output), report, total_seconds=seconds))
    with open_results(task.output) as results:
        return tuple(outcomes(scene.expectations, results)), report.formulation
