"""Simulates a scene from a state into a results file, for `mbproj.run` and for the command."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mbproj.dynamics.assembly.assemble import State, assemble
from mbproj.integrate.simulate import Progress, simulate
from mbproj.model.compile.guess import initial_guess
from mbproj.model.system import System
from mbproj.registry import EQUILIBRIUM
from mbproj.scene.records import Scene
from mbproj.scene.settings import settings_to_run

if TYPE_CHECKING:
    from mbproj.integrate.outside import Function
    from mbproj.integrate.reporting.report import Report
    from mbproj.results.crash_safety.checkpoint import Checkpoint
    from mbproj.results.record import Results
    from mbproj.results.trust import Trust
    from mbproj.results.writer import ResultsWriter
    from mbproj.studies.parallel.progress import Tell

#: A Python function that acts on a run, and its period in s.
Acting = tuple["Function", "float | None"]
#: The number of earlier samples that are copied at once.
COPIED = 10_000


class Earlier(NamedTuple):
    """The run that is continued: its last state, and the results to copy before the new ones, or None."""

    checkpoint: Checkpoint
    results: Results | None


def start_of(scene: Scene, system: System) -> State:
    """Return the initial state of a run, as `linear.equilibrium.started.start_state` does, which is imported for an
    equilibrium alone."""
    if scene.settings.start != EQUILIBRIUM:
        return assemble(system, initial_guess(scene, system))
    from mbproj.linear.equilibrium.started import start_state

    return start_state(scene, system)


def record(
    scene: Scene,
    system: System,
    state: State,
    recorder: ResultsWriter,
    progress: Progress | None,
    limits: Sequence[float] | None,
    *,
    tell: Tell | None = None,
    earlier: Earlier | None = None,
    outside: Acting | None = None,
) -> tuple[Report, Trust | None]:
    """Simulate a scene from a state, or continue an `earlier` run, into a results file. With `limits` (m), certify the
    run; `tell` reports the progress of that."""
    settings, resumed = settings_to_run(scene), {} if earlier is None else earlier.checkpoint.state
    if earlier is not None and earlier.results is not None:
        _copy(earlier.results, recorder, until=float(resumed.get("t", "-inf")))
    if outside is not None:
        return simulate(system, state, settings, recorder, progress, controller=outside[0], period=outside[1]), None
    if limits is None:
        return simulate(system, state, settings, recorder, progress, keep=recorder.keep, resumed=resumed), None
    from mbproj.studies.certify.certified import simulate_certified
    from mbproj.studies.measure.mechanism import Mechanism
    from mbproj.studies.parallel.progress import silent

    mechanism = Mechanism(scene, system, state)
    return simulate_certified(mechanism, settings, recorder, progress, limits, tell or silent, recorder.keep)


def _copy(results: Results, recorder: ResultsWriter, until: float) -> None:
    """Copy the samples up to the time `until` (s)."""
    count = int(np.searchsorted(results.time, until, side="right"))
    for first in range(0, count, COPIED):
        rows = slice(first, min(first + COPIED, count))
        shapes = {dataset: (None, *results.shape(dataset.path)[1:]) for dataset in results.datasets}
        read = results.contents.array
        recorder.write({each.path: read(each.path, shape, each.dtype, rows) for each, shape in shapes.items()})
