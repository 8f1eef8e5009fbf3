"""solve(): run a mechanism with a setting and return plain arrays. A failed run is an answer, not an exception."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import brief, dataclass
from mbproj.dynamics.observe.recorded import Block
from mbproj.errors import InputError, SimulationError
from mbproj.integrate import Report, simulate
from mbproj.integrate.reporting.report import EnergyAccount, Worst
from mbproj.integrate.reporting.tally import RowsKept
from mbproj.scene.read import Scene
from mbproj.scene.records import ProjectionSettings, Settings
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.setting import Setting
from mbproj.thresholds import THRESHOLDS

#: The datasets of markers and bodies, with the count of numbers for each marker or body.
_PLACES = {
    "markers/position": 3,
    "markers/velocity": 3,
    "bodies/position": 3,
    "bodies/orientation": 4,
    "bodies/velocity": 3,
}
_SERIES = (
    "kinetic_energy",
    "potential_energy",
    "energy_balance",
    "position_violation",
    "velocity_violation",
    "acceleration_violation",
)


@dataclass(frozen=True)
class Failure:
    """The reason why a run did not get to its end: it "failed" at `time` (s), or was "refused" before the start."""

    status: str
    time: float
    cause: str

    def __str__(self) -> str:
        return self.cause


@dataclass(frozen=True, eq=False)
class Solution:
    """The motion that a setting gives at `times` (T,), s. Rows after a failure are NaN.

    Positions (T, k, 3) in m and velocities in m/s are those of markers and of bodies' centres, global axes. Euler
    parameters of bodies are (T, n, 4). Energies (J) and violations, (T,), are as in a results file. `report` is None
    where the run failed."""

    setting: Setting
    times: Array
    marker_position: Array
    marker_velocity: Array
    body_position: Array
    body_orientation: Array
    body_velocity: Array
    kinetic_energy: Array
    potential_energy: Array
    energy_balance: Array
    position_violation: Array
    velocity_violation: Array
    acceleration_violation: Array
    report: Report | None
    failure: Failure | None

    __repr__ = brief

    @property
    def position(self) -> Array:
        """The positions of the points at which errors are measured, (T, k, 3): markers, or bodies where there are no
        markers."""
        return self.marker_position if self.marker_position.shape[1] else self.body_position

    @property
    def velocity(self) -> Array:
        """The velocities of the points at which errors are measured, (T, k, 3)."""
        return self.marker_velocity if self.marker_velocity.shape[1] else self.body_velocity


#: The classes of a solution and its parts, which the store has to know.
SOLUTION_RECORDS = (Solution, Failure, Setting, Report, EnergyAccount, RowsKept, Worst, Settings, ProjectionSettings)


#: The hint for points that do not move.
OFF_AXIS = "put a marker on a body that turns, away from its axis"


def unseen(mechanism: Mechanism, solution: Solution) -> str:
    """The reason why a solution shows no errors, or "". Such a reason is that bodies move, but none of the points
    does."""
    span, least = float(np.ptp(solution.times)), THRESHOLDS.dependent * mechanism.system.length
    moved = np.ptp(solution.position, axis=0).max(initial=0.0) + span * np.abs(solution.velocity).max(initial=0.0)
    at_rest = 0.5 * float(np.sum(mechanism.system.mass)) * (least / span) ** 2
    if not moved < least or not solution.kinetic_energy.max(initial=0.0) > at_rest:
        return ""
    what = "markers" if mechanism.kind == "markers" else "centres of mass of the bodies"
    return f"errors are measured at the {what}, and none of these moves although bodies turn"


def sample_times(until: float, samples: int) -> Array:
    """Evenly spaced times from 0 to `until` in s, (samples + 1,)."""
    return np.linspace(0.0, until, samples + 1)


def solve(mechanism: Mechanism | Scene, setting: Setting, times: Array) -> Solution:
    """Runs `mechanism` from its start with `setting` and returns its motion at `times`. These are evenly spaced from 0
    on, at whole multiples of a fixed step. A run that fails raises nothing: the solution has the failure."""
    ready = mechanism if isinstance(mechanism, Mechanism) else Mechanism.of(mechanism)
    recorder, report, failure = _SolutionRecorder(ready, len(times)), None, None
    try:
        settings = ready.settings(setting, float(times[-1]), float(times[1]))
        report = simulate(ready.system, ready.state, settings, recorder, choice=ready.choice(settings))
        report = replace(report, state=None)  # a layout cannot be stored
    except SimulationError as error:
        failure = Failure("failed", error.time, str(error))
    except InputError as error:
        failure = Failure("refused", 0.0, "; ".join(problem.message for problem in error.problems))
    return Solution(setting=setting, times=times, report=report, failure=failure, **recorder.arrays)


class _SolutionRecorder:
    """A recorder of the datasets of a solution."""

    def __init__(self, mechanism: Mechanism, samples: int) -> None:
        counts = {"markers": len(mechanism.system.names.markers), "bodies": len(mechanism.system.names.bodies)}
        places = {
            path: np.full((samples, counts[path.partition("/")[0]], width), np.nan) for path, width in _PLACES.items()
        }
        self._by_path = places | {f"diagnostics/{name}": np.full(samples, np.nan) for name in _SERIES}
        self._filled = 0

    def write(self, block: Block) -> None:
        """Record a block of T samples."""
        rows = slice(self._filled, self._filled + len(block["time"]))
        for path, values in self._by_path.items():
            values[rows] = block[path]
        self._filled = rows.stop

    @property
    def arrays(self) -> dict[str, Array]:
        """The arrays by their names in `Solution`."""
        return {_name(path): values for path, values in self._by_path.items()}


def _name(path: str) -> str:
    group, _, name = path.partition("/")
    return name if group == "diagnostics" else f"{'marker' if group == 'markers' else 'body'}_{name}"
