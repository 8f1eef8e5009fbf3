"""One run at an extreme: what came out, how far it is from the exact motion, and whether the program told the truth."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from time import perf_counter

import numpy as np

from mbproj import InputError, SimulationError, assemble, compile_system, initial_guess, settings_to_run, simulate
from mbproj.base.arrays import Array
from mbproj.base.registry import PROJECTIONS
from mbproj.base.settings import SETTINGS, ProjectionSettings, Settings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.model.system import System
from mbproj.motion.report import Report
from mbproj.scene.scene import Scene, read_scene_text
from mbproj.studies.record import notes_on

from .time_limit import at_most

#: A motion that is off by less, relative to its own size, is right; a closure of so many floors is closed.
RIGHT, CLOSED = 1e-6, 100.0
#: The default penalty.
ALPHA = float(SETTINGS["alpha"].where_taken)
#: Samples of a run.
SAMPLES = 10
#: Baumgarte's gains in 1/s: the default, or this over the step where that is less.
GAIN, GAIN_TIMES_STEP = 25.0, 0.2


class Done:
    """A finished run; indexing gives recorded arrays, first axis time."""

    def __init__(self, scene: Scene, system: System) -> None:
        self.scene, self.system = scene, system
        self.report: Report | None = None
        self._blocks: list[Mapping[str, Array]] = []

    def write(self, block: Mapping[str, Array]) -> None:
        """Keeps a block."""
        self._blocks.append({path: block[path] for path in RECORDED if path in block})

    def __getitem__(self, path: str) -> Array:
        return np.concatenate([block[path] for block in self._blocks])

    def of(self, path: str, name: str) -> Array:
        """What was recorded at `path` of the body, joint or coordinate of this name."""
        kind = "coordinates" if path in ("joints/coordinate", "joints/speed") else path.split("/")[0]
        return self[path][:, getattr(self.system.names, kind).index(name)]


RECORDED = (
    "time",
    "bodies/position",
    "bodies/orientation",
    "bodies/angular_acceleration",
    "joints/coordinate",
    "joints/speed",
    "joints/reaction_force",
    "diagnostics/position_violation",
)


@dataclass(frozen=True)
class Extreme:
    """A quantity that goes to its extremes.

    `scene(value)` is the scene file and its parameters, `steps(value)` the number of steps and their size in s,
    `error(done, value)` how far a run is from the exact motion, relative to its size, at most `right`. `values` are
    those of the campaign, `brief` those of the tests, `formulations` what it is for. `start(system, state, value)`
    may move the state. `slack` is what the scene itself leaves open. A run that takes longer than `limit` s is endless.
    """

    name: str
    scene: Callable[[float], tuple[str, dict[str, str]]]
    steps: Callable[[float], tuple[int, float]]
    error: Callable[[Done, float], float]
    values: tuple[float, ...]
    brief: tuple[float, ...]
    formulations: tuple[str, ...] = ("full", "reduced", "planar")
    start: Callable[[System, State, float], State] | None = None
    slack: Callable[[float], float] = field(default=lambda value: 0.0)
    right: float = RIGHT
    limit: float = 60.0


@dataclass(frozen=True)
class Outcome:
    """What came of one run. `verdict`:

    right    the motion is right, and where the method corrects the joints are closed, to `CLOSED` floors or to the
             projection's own tolerance
    open     the motion is right, but the joints are further open
    warned   the motion is wrong, and a note of the summary says so
    stopped  the run ended early, with the time and the cause;  refused  it was refused, with the cause
    WRONG    the motion is wrong, or has no value, and nothing was said;  ENDLESS  it did not end
    """

    extreme: str
    value: float
    method: str
    formulation: str
    verdict: str
    error: float = np.nan
    closure: float = np.nan
    floor: float = np.nan
    velocity: float = np.nan
    velocity_floor: float = np.nan
    energy: float = np.nan
    seconds: float = 0.0
    message: str = ""

    @property
    def honest(self) -> bool:
        """Whether the program told the truth."""
        return self.verdict not in ("WRONG", "ENDLESS")


def combinations(extreme: Extreme) -> Iterator[tuple[str, str]]:
    """Projection methods and formulations that go together: with Euler parameters M is singular, and POPM refused."""
    for formulation in extreme.formulations:
        for method, entry in PROJECTIONS.items():
            if (method != "popm") if formulation == "full" else entry.compiled:
                yield method, formulation


def attempt(extreme: Extreme, value: float, method: str, formulation: str, steps: int | None = None) -> Outcome:
    """Runs an extreme at a value, for so many `steps` at most."""
    key, started = (extreme.name, value, method, formulation), perf_counter()
    try:
        with np.errstate(all="ignore"), at_most(extreme.limit):
            done = run(extreme, value, method, formulation, steps)
    except TimeoutError:
        return Outcome(*key, "ENDLESS", seconds=perf_counter() - started)
    except (InputError, SimulationError) as reason:
        verdict = "refused" if isinstance(reason, InputError) else "stopped"
        return Outcome(*key, verdict, seconds=perf_counter() - started, message=str(reason).partition("\n")[0])
    report = done.report
    assert report is not None
    error = _error(extreme, done, value)
    said = [note.text for note in notes_on(report)]
    closed = float(done["diagnostics/position_violation"][1:].max())
    corrects = PROJECTIONS[method].corrects
    floor = report.position_floor + extreme.slack(value)
    reached = closed <= max(CLOSED * floor, THRESHOLDS.closed_to * min(1.0, done.system.length))
    verdict = "right" if not corrects or reached else "open"
    if not error <= extreme.right:
        verdict = "warned" if said else "WRONG"
    return Outcome(
        *key,
        verdict,
        error,
        closed,
        floor,
        report.velocity_violation.value,
        report.velocity_floor,
        report.energy_drift_relative,
        perf_counter() - started,
        "; ".join(said),
    )


def run(extreme: Extreme, value: float, method: str, formulation: str, steps: int | None = None) -> Done:
    """The run itself, of so many `steps` at most."""
    text, parameters = extreme.scene(value)
    scene, system, state = _assembled(text, tuple(parameters.items()))
    if extreme.start is not None:
        state = extreme.start(system, state, value)
    count, h = extreme.steps(value)
    count = count if steps is None else min(count, steps)
    options = PROJECTIONS[method].options
    gains = (min(GAIN, GAIN_TIMES_STEP / h),) * 2 if "gains" in options else None
    alpha = ALPHA if "alpha" in options else None
    scene = replace(
        scene,
        settings=Settings(
            duration=count * h,
            step=h,
            output_step=max(count // SAMPLES, 1) * h,
            integrator="dop853",
            formulation=formulation,
            projection=ProjectionSettings(method, alpha=alpha, gains=gains),
        ),
    )
    done = Done(scene, system)
    done.report = simulate(system, state, settings_to_run(scene), done)
    return done


@lru_cache(maxsize=2)
def _assembled(text: str, parameters: tuple[tuple[str, str], ...]) -> tuple[Scene, System, State]:
    """The scene of a text with these parameters, its system, and its start."""
    scene = read_scene_text(text, "extreme.yaml", dict(parameters), {})
    system = compile_system(scene)
    return scene, system, assemble(system, initial_guess(scene, system))


def _error(extreme: Extreme, done: Done, value: float) -> float:
    """The error; infinite where anything recorded is not a number."""
    if not all(np.isfinite(done[path]).all() for path in RECORDED):
        return float("inf")
    return extreme.error(done, value)
