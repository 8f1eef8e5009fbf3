"""solve(): run a mechanism with a setting and return plain arrays. A failed run is an answer, not an exception."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Annotated, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array
from mbproj.base.dataclass import brief, dataclass
from mbproj.base.errors import InputError, Problem, SimulationError, choose_from
from mbproj.base.settings import MECHANISM, SETTINGS, Settings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.recorded import Block
from mbproj.linear.equilibrium.start import start_state
from mbproj.model.system import System
from mbproj.motion.formulations.choice import Choice, choose
from mbproj.motion.kernel_run import FollowedSteps
from mbproj.motion.report import Report
from mbproj.motion.simulate import EventRecorder, Recorder, simulate
from mbproj.motion.time_events import Event
from mbproj.results.analysis.expectations import datasets, measured
from mbproj.scene.records import Expectation
from mbproj.scene.scene import Scene
from mbproj.scene.settings import placed_in
from mbproj.studies.measure.setting import Setting

# --- A mechanism that is compiled and assembled once, ready to be run many times --------------------------------------


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A scene with its system and its consistent start. `points` names its markers, or its bodies where it has none."""

    scene: Scene
    system: System
    state: State

    __repr__ = brief

    @classmethod
    def of(cls, scene: Scene) -> Mechanism:
        """Compile and assemble a scene. Raises InputError where the mechanism cannot be assembled."""
        system = compile_system(scene)
        return cls(scene, system, start_state(scene, system))

    @classmethod
    def to_choose_for(cls, scene: Scene) -> Mechanism:
        """Compile and assemble a scene for a study of settings. Raises InputError where the run is kinematic, as no
        setting matters then."""
        mechanism = cls.of(scene)
        if mechanism.choice(scene.settings).kinematic:
            message = "0 degrees of freedom: the run is kinematic, exact at any setting; there is none to choose"
            hint = "simply run it; --set simulation.kinematic=false integrates it all the same"
            raise InputError(Problem(message, scene.place("simulation"), hint))
        return mechanism

    def choice(self, settings: Settings) -> Choice:
        """Return the result of `choose` for a run from the start."""
        with placed_in(self.scene):
            return choose(self.system, self.state, settings)

    @property
    def points(self) -> tuple[str, ...]:
        """The names of the points at which errors are measured, (k,): markers, or bodies where the scene has no
        marker."""
        return tuple(self.system.names.markers or self.system.names.bodies)

    @property
    def kind(self) -> str:
        """The kind of the points: "markers" or "bodies"."""
        return "markers" if self.system.names.markers else "bodies"

    def columns(self, names: Sequence[str] = ()) -> tuple[int, ...]:
        """The numbers of the named points, or of all points where no name is given. Raises InputError for an unknown
        name."""
        for name in names:
            if name not in self.points:
                problem = Problem(f"there is no '{name}' among the {self.kind}", hint=choose_from(name, self.points))
                raise InputError(problem)
        return tuple(k for k, name in enumerate(self.points) if not names or name in names)

    def settings(self, setting: Setting, duration: float, output_step: float) -> Settings:
        """The settings of a run of the scene with `setting`, both times in s. Raises InputError where
        `setting.settings` does."""
        return of_scene(self.scene, setting.settings(duration, output_step))

    @property
    def identity(self) -> dict[str, Any]:
        """All that the mechanism follows from, as the key of the store."""
        scene = self.scene
        settings = {entry.name: entry.of(scene.settings) for entry in _OF_SCENE}
        elements = repr(scene.elements) if scene.elements else ""
        return {"scene": scene.text, "parameters": dict(scene.overrides), "settings": settings, "elements": elements}


#: The settings that belong to the mechanism: no study varies them.
_OF_SCENE = [entry for entry in SETTINGS.values() if entry.decides == MECHANISM]


def of_scene(scene: Scene, settings: Settings) -> Settings:
    """Return the settings with those of the scene that belong to its mechanism."""
    return replace(settings, **{entry.key: entry.of(scene.settings) for entry in _OF_SCENE})


# --- solve(): run a mechanism with a setting and return plain arrays --------------------------------------------------


#: The datasets of a solution, with the shape of a marker's or a body's part, or of a number.
_WIDTHS: Mapping[str, tuple[int, ...]] = {
    "markers/position": (3,),
    "markers/velocity": (3,),
    "bodies/position": (3,),
    "bodies/orientation": (4,),
    "bodies/velocity": (3,),
    "diagnostics/kinetic_energy": (),
    "diagnostics/potential_energy": (),
    "diagnostics/energy_balance": (),
    "diagnostics/position_violation": (),
    "diagnostics/velocity_violation": (),
    "diagnostics/acceleration_violation": (),
}


@dataclass(frozen=True)
class Failure:
    """The reason why a run did not get to its end: it "failed" at `time` (s), or was "refused" before the start."""

    status: str
    time: float
    cause: str

    def __str__(self) -> str:
        return self.cause


Series: TypeAlias = Annotated[Array, "T"]


@dataclass(frozen=True, eq=False)
class Solution:
    """The motion that a setting gives at `times` (T,), s. Rows after a failure are NaN.

    Positions (T, k, 3) in m and velocities in m/s are those of markers and of bodies' centres, global axes. Euler
    parameters of bodies are (T, n, 4). Energies (J) and violations, (T,), are as in a results file. `report` is None
    where the run failed."""

    setting: Setting
    times: Series
    marker_position: Annotated[Array, "T m 3"]
    marker_velocity: Annotated[Array, "T m 3"]
    body_position: Annotated[Array, "T n 3"]
    body_orientation: Annotated[Array, "T n 4"]
    body_velocity: Annotated[Array, "T n 3"]
    kinetic_energy: Series
    potential_energy: Series
    energy_balance: Series
    position_violation: Series
    velocity_violation: Series
    acceleration_violation: Series
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
    names, report, failure = ready.system.names, None, None
    counts = {"markers": (len(names.markers),), "bodies": (len(names.bodies),), "diagnostics": ()}
    recorder = DatasetRecorder(_WIDTHS)
    try:
        settings = ready.settings(setting, float(times[-1]), float(times[1]))
        report = simulate(ready.system, ready.state, settings, recorder, choice=ready.choice(settings))
        report = replace(report, state=None)  # a layout cannot be stored
    except SimulationError as error:
        failure = Failure("failed", error.time, str(error))
    except InputError as error:
        failure = Failure("refused", 0.0, "; ".join(problem.message for problem in error.problems))
    arrays = {}
    for path, width in _WIDTHS.items():
        arrays[_name(path)] = np.full((len(times), *counts[path.partition("/")[0]], *width), np.nan)
        if not recorder.is_empty:
            rows = recorder[path]
            arrays[_name(path)][: len(rows)] = rows
    return Solution(setting=setting, times=times, report=report, failure=failure, **arrays)


def _name(path: str) -> str:
    group, _, name = path.partition("/")
    return name if group == "diagnostics" else f"{'marker' if group == 'markers' else 'body'}_{name}"


# --- A recorder of the datasets that the measures of a study read -----------------------------------------------------


class DatasetRecorder:
    """A recorder of the datasets at these paths, and of the events that the run `met`. It passes everything on to
    `recorder`."""

    def __init__(self, paths: Iterable[str], recorder: Recorder | None = None) -> None:
        self._parts: dict[str, list[npt.NDArray[Any]]] = {path: [] for path in paths}
        self._recorder = recorder
        self.met: Sequence[Event] = ()

    def write(self, block: Block) -> None:
        """Record a block of T samples."""
        for path, parts in self._parts.items():
            parts.append(block[path])
        if self._recorder is not None:
            self._recorder.write(block)

    def events(self, events: Sequence[Event]) -> None:
        """Record the events of the run."""
        self.met = events
        if isinstance(self._recorder, EventRecorder):
            self._recorder.events(events)

    @property
    def is_empty(self) -> bool:
        """Whether nothing was recorded."""
        return not any(self._parts.values())

    def __getitem__(self, path: str) -> npt.NDArray[Any]:
        return np.concatenate(self._parts[path])


class MeasuredSamples(DatasetRecorder):
    """A recorder of the datasets that `measures` read."""

    def __init__(self, mechanism: Mechanism, measures: Sequence[Expectation], recorder: Recorder | None = None) -> None:
        self._names: Mapping[str, tuple[str, ...]] = mechanism.system.names.as_mapping()
        self._measures = tuple(measures)
        wanted = (path for each in measures for path in datasets(each, self.names("coordinates")))
        super().__init__(("time", *wanted), recorder)

    def names(self, kind: str) -> tuple[str, ...]:
        """The names of the columns of a kind, for example of "markers"."""
        return self._names[kind]

    @property
    def event_times(self) -> Array:
        """The times (n,), s, of the run's events."""
        return np.array([event.time for event in self.met])

    def values(self, duration: float | None, of: Sequence[Expectation] | None = None) -> tuple[float, ...]:
        """The first number of each measure, or of those given, in a run of `duration` (s); NaN where there is none."""
        values = (measured(each, self, duration) for each in (self._measures if of is None else of))
        return tuple(np.nan if each is None else float(each.values[0]) for each in values)


def measured_run(
    mechanism: Mechanism,
    settings: Settings,
    measures: Sequence[Expectation],
    steps: FollowedSteps | None = None,
    recorder: Recorder | None = None,
) -> tuple[MeasuredSamples, Report]:
    """Run a mechanism, and return the samples of the measures. Raises SimulationError."""
    samples = MeasuredSamples(mechanism, measures, recorder)
    report = simulate(mechanism.system, mechanism.state, settings, samples, accounts=False, steps=steps)
    return samples, report
