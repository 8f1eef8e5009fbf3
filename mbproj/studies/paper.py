"""The numerical examples of the paper (sect. 5): its two mechanisms, its step, its stop test, its methods.

A nearly exact run beside them (DOP853 at a tight tolerance) tells the error of the paper's step.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import SimulationError
from mbproj.base.mechanisms_folder import mechanism
from mbproj.equations.assembly.assemble import assemble
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.recorded import Block
from mbproj.model.compile.mechanism import initial_guess
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene
from mbproj.scene.settings import settings_to_run

#: The methods of Figs. 4-5 and 9-10, by their names in the paper's legends.
METHODS: Mapping[str, str] = {
    "direct integration": "none",
    "Baumgarte, α = β = 25": "baumgarte",
    "GOPM": "gopm",
    "MMOPM, α = 1e7": "mmopm",
    "GPOPM": "gpopm",
}
#: An error of the marker, in m, that counts as "not converged": a thousandth of a bar of the pendulum.
LIMIT = 1e-3

_PAPER = {"step": "0.01", "integrator": "rk4", "acceleration": "bordered", "formulation": "full"}
_EXACT = {"tolerance": "1e-11", "integrator": "dop853", "output_step": "0.01", "projection": "gpopm"}


@dataclass(frozen=True, eq=False)
class History:
    """The run of one method: times (T,), position and velocity of the marker (T, 3), |C|∞ and |C'|∞ (T,), and why it
    stopped early."""

    time: Array
    position: Array
    velocity: Array
    position_violation: Array
    velocity_violation: Array
    failure: str | None


@dataclass(frozen=True, eq=False)
class Example:
    """The results of one mechanism of the paper: a history for each legend, and the error of GPOPM's marker over time
    (T,), m.

    `unconverged_from` is the first time (s) at which that error exceeds `LIMIT`; None where it never does.
    """

    name: str
    title: str
    marker: str
    histories: Mapping[str, History]
    error: Array
    unconverged_from: float | None


class _HistoryRecorder:
    """A recorder of the first marker and of the violations."""

    def __init__(self) -> None:
        self.blocks: list[Block] = []

    def write(self, block: Block) -> None:
        """Record a block of T samples."""
        self.blocks.append(block)

    def history(self, failure: str | None) -> History:
        """Join the recorded blocks to a history. `failure` is the reason why the run stopped early."""

        def all_of(path: str) -> Array:
            return np.concatenate([block[path] for block in self.blocks])

        return History(
            time=all_of("time"),
            position=all_of("markers/position")[:, 0],
            velocity=all_of("markers/velocity")[:, 0],
            position_violation=all_of("diagnostics/position_violation"),
            velocity_violation=all_of("diagnostics/velocity_violation"),
            failure=failure,
        )


def run_example(name: str, duration: float, tell: Callable[[str], None] = lambda message: None) -> Example:
    """Runs the mechanism `name` ("five_bar" or "spatial_slider_crank") with every method of the paper.

    `tell` is called with one line before each run. A run that fails is kept up to its failure.
    """
    histories = {}
    for legend, method in METHODS.items():
        tell(f"{name}: {legend}")
        test = {"projection_test": "paper"} if method in ("gopm", "mmopm", "gpopm") else {}
        histories[legend] = _run(name, duration, {**_PAPER, "projection": method, **test})
    tell(f"{name}: for comparison, DOP853 at a tolerance of 1e-11")
    exact = _run(name, duration, _EXACT)
    scene = read_scene(mechanism(name))
    error = marker_error(histories["GPOPM"], exact)
    beyond = np.flatnonzero(error > LIMIT)
    return Example(
        name=name,
        title=scene.title,
        marker=scene.markers[0].name,
        histories=histories,
        error=error,
        unconverged_from=float(histories["GPOPM"].time[beyond[0]]) if len(beyond) else None,
    )


def marker_error(history: History, exact: History) -> Array:
    """The distance of the marker from that of `exact` at the times that both have, m."""
    shared = min(len(history.time), len(exact.time))
    distance: Array = np.linalg.norm(history.position[:shared] - exact.position[:shared], axis=1)
    return distance


def _run(name: str, duration: float, simulation: Mapping[str, str]) -> History:
    scene = read_scene(mechanism(name), {}, {"duration": repr(duration), **simulation})
    system, recorder, failure = compile_system(scene), _HistoryRecorder(), None
    try:
        simulate(system, assemble(system, initial_guess(scene, system)), settings_to_run(scene), recorder)
    except SimulationError as error:
        failure = str(error)
    return recorder.history(failure)
