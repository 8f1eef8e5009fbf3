"""mbproj itself, with the settings that the problem names: fixed steps, or a sweep of tolerances."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from mbproj import SimulationError, State, System, assemble, compile_system, initial_guess, settings_to_run, simulate
from mbproj.base.settings import Settings
from mbproj.equations.recorded import Block
from mbproj.scene.scene import Scene

from .problem import Array, NotDone, Outcome, Problem, Program, Setting, step_label, tolerance_label, tolerances

FIXED = ("rk4",)
#: Where a method has neither a step nor a sweep of its own.
TOLERANCE = 1e-6


class _Watched:
    """Keeps markers and coordinates that are watched."""

    def __init__(self, watch: tuple[str, ...], scene: Scene, system: System) -> None:
        markers, self.coordinates = [marker.name for marker in scene.markers], list(system.names.coordinates)
        self.watch, self.markers = watch, markers
        self.blocks: list[Array] = []

    def write(self, block: Block) -> None:
        """Takes a block of samples."""
        places = []
        for name in self.watch:
            if name in self.markers:
                places.append(block["markers/position"][:, self.markers.index(name)])
            else:
                value = block["joints/coordinate"][:, self.coordinates.index(name)]
                places.append(np.stack([value, 0.0 * value, 0.0 * value], axis=-1))
        self.blocks.append(np.stack(places, axis=1))

    def events(self, events: object) -> None:
        """They are not asked for."""


def _run(problem: Problem, scene: Scene, system: System, state: State, settings: Settings, times: Array) -> Outcome:
    kept, end = _Watched(problem.watch, scene, system), float(times[-1])
    try:
        report = simulate(system, state, replace(settings, duration=end, output_step=end / len(times)), kept)
    except SimulationError as error:
        raise NotDone(str(error)) from error
    seen = np.concatenate(kept.blocks)[1:]
    opened, evaluations = report.position_violation.value, report.counters["evaluations"]
    return Outcome(seen, report.integration_cpu_seconds, opened, evaluations)


def _settings(problem: Problem, name: str, given: Mapping[str, Any]) -> Iterator[Setting]:
    rest = dict(given)
    scene = rest.pop("scene", problem.scene)
    system = compile_system(scene)
    run = partial(_run, problem, scene, system, assemble(system, initial_guess(scene, system)))
    projection = {key: rest.pop(key) for key in ("energy",) if key in rest}
    given_once = replace(scene.settings, duration=problem.end, step=None, tolerance=TOLERANCE)
    usual = settings_to_run(replace(scene, settings=given_once))
    if "step" in given:
        usual = replace(usual, tolerance=None)
    usual = replace(usual, projection=replace(usual.projection, method="gpopm", **projection), **rest)
    if "step" in given or "tolerance" in given:
        yield Setting("", partial(run, usual))
    elif name in problem.tried or given["integrator"] in FIXED:
        for step, count in problem.steps(name):
            settings = replace(usual, step=step, tolerance=None)
            yield Setting(step_label(step), partial(run, settings), count)
    else:
        for tolerance in tolerances():
            settings = replace(usual, step=None, tolerance=tolerance)
            yield Setting(tolerance_label(tolerance), partial(run, settings))


def programs(problem: Problem) -> Iterator[Program]:
    """One for each method that the problem names."""
    for method, given in problem.mbproj.items():
        name = f"mbproj, {method}"
        yield Program(name, partial(_settings, problem, name, given))
