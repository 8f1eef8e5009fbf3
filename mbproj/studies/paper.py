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
from mbproj.motion.simulate import simulate
from mbproj.scene.scene import read_scene
from mbproj.scene.settings import settings_to_run
from mbproj.studies.measure.solve import DatasetRecorder, Mechanism

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

OF_MARKERS = ("markers/position", "markers/velocity")
VIOLATIONS = ("diagnostics/position_violation", "diagnostics/velocity_violation")
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
    ready, recorder, failure = Mechanism.of(scene), DatasetRecorder(("time", *OF_MARKERS, *VIOLATIONS)), None
    try:
        simulate(ready.system, ready.state, settings_to_run(scene), recorder)
    except SimulationError as error:
        failure = str(error)
    position, velocity = (recorder[path][:, 0] for path in OF_MARKERS)
    of_position, of_velocity = (recorder[path] for path in VIOLATIONS)
    return History(recorder["time"], position, velocity, of_position, of_velocity, failure)
