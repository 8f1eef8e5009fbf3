"""Slopes of measures along one run, by numbers of the scene. Dual numbers follow the run. Their directions come from
models of neighbours, scenes with slightly changed numbers, which are compiled but not run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from mbproj.base.arrays import Array, Integers, may_overflow
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, SimulationError
from mbproj.base.registry import EQUILIBRIUM, is_explicit
from mbproj.base.settings import Settings
from mbproj.equations.assembly.assemble import coordinate_values, turns_of
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.kinematics import pose_of
from mbproj.equations.recorded import Block, Observer
from mbproj.equations.samples import GivenMotion, Samples, join
from mbproj.linear.equilibrium.start import start_state
from mbproj.model.planar.plane import Plane
from mbproj.model.planar.reduction import planar_reduction
from mbproj.model.system import System
from mbproj.motion.formulations.compiled import Compiled
from mbproj.motion.formulations.reduced import InPlane, Reduced
from mbproj.motion.kernel_run import FollowedSteps, Trace, TracedSteps
from mbproj.motion.tangents import Directions, numbers_of, slopes_along, structure_of
from mbproj.motion.time_events import Event, breaks_of
from mbproj.results.analysis.expectations import datasets
from mbproj.scene.records import Expectation
from mbproj.scene.scene import Scene
from mbproj.scene.settings import settings_to_run
from mbproj.studies.measure.solve import MeasuredSamples, Mechanism, measured_run

#: Datasets that depend on the state alone, not on contacts, works or tolerances.
SEEN = (
    "bodies/",
    "markers/",
    "joints/coordinate",
    "joints/speed",
    "joints/reaction_",
    "forces/",
    "motions/",
    "states/",
    "signals/",
    "ropes/",
)
SEEN_ENERGIES = tuple(f"diagnostics/{name}_energy" for name in ("kinetic", "potential", "total"))
#: Formulas for slopes: the shifts of neighbours in steps, and their weights. The first one whose models have the
#: structure of the run's model is taken.
FORMULAS = (
    ((-1.0, 1.0), (-0.5, 0.5)),
    ((0.0, 1.0, 2.0), (-1.5, 2.0, -0.5)),
    ((0.0, -1.0, -2.0), (1.5, -2.0, 0.5)),
)
#: A formula of fourth order.
WIDE = ((-2.0, -1.0, 1.0, 2.0), (1.0 / 12.0, -2.0 / 3.0, 2.0 / 3.0, -1.0 / 12.0))
#: One-sided formulas of first order, for searches, whose slopes need not be exact.
SIDES = (((0.0, 1.0), (-1.0, 1.0)), ((0.0, -1.0), (1.0, -1.0)))
#: The usual relative change of a model's numbers from neighbour to neighbour, and the least size to which it is
#: relative.
CHANGES, SMALL = 1e-5, 0.1
Formula = tuple[tuple[float, ...], tuple[float, ...]]


@dataclass(frozen=True, eq=False)
class VariedNumber:
    """A number of a scene, by name: a function that returns the scene with the number increased, and the step of
    differences."""

    name: str
    scene: Callable[[float], Scene]
    step: float


@dataclass(frozen=True, eq=False)
class Slope:
    """The slopes of k measures by a number: the `values` (n, k) of its neighbours, and the formula for slopes. The
    states of neighbours are linear in the number, so that only the measures may be nonlinear. `cut`: the relative error
    of the slopes of the model's numbers. `why`: the reason where slopes are not known."""

    values: Array
    formula: Formula
    step: float
    cut: float = 0.0
    why: str = ""

    @classmethod
    def unknown(cls, why: str) -> Slope:
        """Return an unknown slope, with the reason."""
        return cls(np.zeros((0, 0)), SIDES[0], 1.0, 0.0, why)

    @property
    def slopes(self) -> Array:
        """The slopes, (k,)."""
        return np.tensordot(self.formula[1], self.values, 1) / self.step

    def rough(self, centre: Array) -> Array:
        """The slopes by a formula of lower order, (k,), from the values `centre` of the scene itself."""
        away, values = self.formula[0], self.values
        if len(away) == len(WIDE[0]):
            return (values[2] - values[1]) / (2.0 * self.step)
        return (values[1] - centre) / (away[1] * self.step)


class Followed:
    """A run that dual numbers can follow, with its measures."""

    def __init__(self, mechanism: Mechanism, settings: Settings, measures: Sequence[Expectation]) -> None:
        self.mechanism, self.settings, self.measures = mechanism, settings, tuple(measures)
        self.steps: FollowedSteps = TracedSteps()
        self._blocks: list[Samples] = []
        self._met: Sequence[Event] = ()
        self.rows: Integers | None = None  # the samples that measures depend on; None for all
        self._models: dict[tuple[str, float], Model] = {}
        self._seen_ones = tuple(each for each in measures if not self.unseen(each))
        self._paths = {path for each in self._seen_ones for path in self._datasets(each)}

    def again(self, settings: Settings) -> Followed:
        """Return the run with other steps, not yet made. Models of neighbours are compiled once for both."""
        copy = Followed(self.mechanism, settings, self.measures)
        copy._models = self._models
        return copy

    def run(self, steps: FollowedSteps | None = None) -> MeasuredSamples:
        """Make the run, with the steps of another run if given, and return the samples of the measures. Raises
        SimulationError."""
        self.steps = TracedSteps() if steps is None else steps.of_another()
        samples, _ = measured_run(self.mechanism, self.settings, self.measures, self.steps, self)
        self._met = samples.met
        return samples

    def write(self, block: Block) -> None:
        """Keep a block of samples."""
        self._blocks.append(block.samples)  # type: ignore[attr-defined]

    @property
    def trace(self) -> Trace | None:
        """The trace of the run; None where the kernel did not make it, or it followed another run."""
        return self.steps.trace if isinstance(self.steps, TracedSteps) else None

    @property
    def why(self) -> str:
        """The reason why dual numbers do not follow the run; empty where they do."""
        system, settings = self.mechanism.system, self.settings
        kinematic = self.trace is not None and self.trace.settings.kinematic is True
        if not (kinematic or is_explicit(settings.integrator)):
            return f"{settings.integrator} makes implicit steps"
        if system.has_contacts:
            return "the scene has stops or dry friction"
        if settings.start == EQUILIBRIUM:
            return "the run starts at an equilibrium"
        if self.trace is None:
            return "the run is not made by the kernel"
        return ""

    def unseen(self, measure: Expectation) -> str:
        """The reason why a measure is not known for neighbours, which are not run; empty where it is known."""
        odd = next((path for path in self._datasets(measure) if not _is_seen(path)), "")
        return f"'{odd}' is no function of the state" if odd else ""

    @property
    def missing(self) -> dict[Expectation, str]:
        """The measures that are not known for neighbours, with the reasons."""
        return {each: why for each in self.measures if (why := self.unseen(each))}

    @property
    def misses(self) -> str:
        """The reason why dual numbers give no slope of any measure; empty where they give some."""
        missing = [*self.missing.values()]
        return self.why or (missing[0] if missing and len(missing) == len(self.measures) else "")

    def _datasets(self, measure: Expectation) -> tuple[str, ...]:
        return datasets(measure, self.mechanism.system.names.as_mapping()["coordinates"])

    def slopes(
        self,
        numbers: Sequence[VariedNumber],
        measure: Callable[[Scene, MeasuredSamples], Array],
        formulas: Sequence[Formula] = FORMULAS,
    ) -> list[Slope]:
        """Return the slopes of `measure`, a function of a scene and its samples, by each of the numbers."""
        trace = self.trace
        assert trace is not None
        base = Model(trace.compiled, self.mechanism)
        columns = [self._alike(base, number, formulas) for number in numbers]
        known = [k for k, each in enumerate(columns) if not isinstance(each, str)]
        slopes: list[Slope] = [Slope.unknown(each if isinstance(each, str) else "") for each in columns]
        if not known:
            return slopes
        samples = join(self._blocks) if self.rows is None else chosen_of(join(self._blocks), self.rows)
        y = base.states(samples)
        chosen = [(numbers[k], *columns[k]) for k in known]
        directions = Directions(
            *(
                np.array(
                    [
                        np.tensordot(weights, [getattr(near, of) for near in models], 1) / number.step
                        for number, (_, weights), models in chosen
                    ]
                )
                for of in ("numbers", "start")
            )
        )
        try:
            along = slopes_along(trace, base.start, directions, samples.t, y)
            counted = coordinate_values(self.mechanism.system, pose_of(samples.q)) + 2.0 * np.pi * samples.turns
            at_base: Array | None = None
            for place, (number, formula, models) in enumerate(chosen):
                values = []
                for away, near in zip(formula[0], models, strict=True):
                    there = y + away * number.step * along[:, place]
                    if near is not base or at_base is None:
                        value = measure(near.mechanism.scene, self._measured_samples(near, samples, counted, there))
                        at_base = value if near is base else at_base
                    values.append(at_base if near is base else value)
                slopes[known[place]] = Slope(np.array(values), formula, number.step, _truncation(formula, models, base))
        except InputError as error:
            return [Slope.unknown(error.problems[0].message)] * len(numbers)
        except SimulationError as error:
            return [Slope.unknown(str(error))] * len(numbers)
        return slopes

    def _alike(
        self, base: Model, number: VariedNumber, formulas: Sequence[Formula]
    ) -> tuple[Formula, list[Model]] | str:
        """Return the first of the formulas whose neighbours have models of the same structure, with these models; else
        the reason why there is none."""
        why = ""
        for formula in formulas:
            models = []
            try:
                for away in formula[0]:
                    key = number.name, away * number.step
                    if away != 0.0 and key not in self._models:
                        self._models[key] = self._neighbour(base, number.scene(key[1]))
                    models.append(base if away == 0.0 else self._models[key])
                return formula, models
            except InputError as error:
                why = why or error.problems[0].message
        return why

    def _neighbour(self, base: Model, scene: Scene) -> Model:
        """Return the model of a neighbour. Raises InputError where its structure differs from the model that ran."""
        trace = self.trace
        assert trace is not None
        if _without_steps(settings_to_run(scene, by_options=False)) != _without_steps(self.settings):
            raise InputError("it changes how the run is made")
        system = compile_system(scene)
        state = self.mechanism.state
        if trace.settings.kinematic is not True:
            state = start_state(scene, system)
        model = Model(compiled_like(trace.compiled, system, state.q), Mechanism(scene, system, state))
        times = [each.time for each in breaks_of(system, state.t, trace.settings)]
        if times != [each.time for each in trace.leg.breaks]:
            raise InputError("it moves instants at which functions of time have kinks")
        if not np.array_equal(model.structure, base.structure):
            raise InputError("it changes a curve, knots, a rope's path, what counts teeth, or the choice of rows")
        if model.numbers.shape != base.numbers.shape:
            raise InputError("it changes the structure of the model")
        return model

    def _measured_samples(self, near: Model, samples: Samples, counted: Array, y: Array) -> MeasuredSamples:
        """Return the measured samples of a neighbour at its states y (T, S)."""
        measured, mechanism = MeasuredSamples(near.mechanism, self._seen_ones), near.mechanism
        with may_overflow():
            near_samples = near.samples(samples, counted, y, self._paths)
            measured.write(Observer(mechanism.system, mechanism.state).at(near_samples))
        measured.events(self._met)
        return measured


def _is_seen(path: str) -> bool:
    return path.startswith(SEEN) or path in SEEN_ENERGIES


def _truncation(formula: Formula, models: Sequence[Model], base: Model) -> float:
    """The relative error of a formula for the numbers of models and their initial states: about the square of the
    difference to a formula of lower order."""
    worst = 0.0
    for of in ("numbers", "start"):
        values, at = np.array([getattr(near, of) for near in models]), getattr(base, of)
        better = np.tensordot(formula[1], values, 1)
        rough = 0.5 * (values[2] - values[1]) if len(values) == len(WIDE[0]) else (values[1] - at) / formula[0][1]
        usual = np.maximum(np.abs(better), CHANGES * np.maximum(np.abs(at), SMALL))
        worst = max(worst, float(np.max(((better - rough) / usual) ** 2, initial=0.0)))
    return worst


def _without_steps(settings: Settings) -> Settings:
    return replace(settings, step=None, tolerance=None)


# --- Models with changed numbers beside one that ran ------------------------------------------------------------------
# Their numbers, their initial states, and samples at given states.


#: Parts of the paths of datasets that need accelerations, and of those that need multipliers.
ACCELERATIONS, MULTIPLIERS = ("acceleration", "forces/"), ("reaction", "motions/force", "ropes/")


def chosen_of(samples: Samples, rows: Integers) -> Samples:
    """Return the samples with these numbers."""
    names = ("t", "carried", "step_size", "work")
    counters = {name: values[rows] for name, values in samples.counters.items()}
    chosen = {name: getattr(samples, name)[rows] for name in names}
    return replace(samples, **chosen, motion=samples.motion.chosen(rows), counters=counters)


class Model:
    """A system in the kernel, with its numbers and its initial state."""

    def __init__(self, compiled: Compiled, mechanism: Mechanism) -> None:
        self.compiled, self.mechanism = compiled, mechanism
        self.numbers, self.structure = numbers_of(compiled), structure_of(compiled)
        self.start = compiled.beginning(mechanism.state)

    def states(self, samples: Samples) -> Array:
        """Return the kernel's states (T, S) at samples."""
        layout = self.compiled.layout
        bodies = self.compiled.state(samples.q, samples.v).reshape(len(samples.t), -1)
        return layout.vector_of({"bodies": bodies} | samples.layout.common_blocks(samples.y, layout))

    def samples(self, beside: Samples, counted: Array, y: Array, paths: Iterable[str]) -> Samples:
        """Return T samples at the kernel's states y (T, S), near other samples with the joint coordinates `counted`."""
        compiled, system = self.compiled, self.compiled.system
        bodies = np.ascontiguousarray(compiled.bodies_of(y))
        acceleration = np.zeros((*bodies.shape[:2], bodies.shape[2] // 2))
        carried = beside.carried
        wanted = (*ACCELERATIONS, *(MULTIPLIERS if isinstance(compiled, Reduced) else ()))
        if any(each in path for path in paths for each in wanted):
            acceleration, carried = self._solved(beside, bodies, counted)
        q, v = compiled.motion(bodies)
        turns = turns_of(system, q, counted)
        states = {"positions": q, "velocities": v, "turns": turns} | compiled.layout.common_blocks(y, system.layout)
        return replace(
            beside,
            motion=GivenMotion(
                system.layout, system.layout.vector_of(states), compiled.acceleration(bodies, acceleration)
            ),
            carried=carried,
            solved=compiled.multipliers,
        )

    def _solved(self, beside: Samples, bodies: Array, counted: Array) -> tuple[Array, Array]:
        """Return accelerations and multipliers at samples. Raises SimulationError where they are not unique."""
        equations, solutions = self.compiled.equations(), []
        for t, body, along, x in zip(beside.t, bodies, counted, beside.y[:, beside.layout["states"]], strict=True):
            solution = equations.accelerations(body, float(t), [*self.compiled.turns(along).tolist(), *x.tolist()])
            if solution is None:
                raise SimulationError(float(t), "the equations have no unique solution")
            solutions.append(solution)
        accelerations, multipliers = zip(*solutions, strict=True)
        return np.array(accelerations), np.array(multipliers)[:, : beside.carried.shape[1]]


def compiled_like(like: Compiled, system: System, q: Array) -> Compiled:
    """Return a system in the kernel's coordinates of the system `like`."""
    if isinstance(like, Reduced):
        model = Reduced(like.core, system)
        model.model.rows = like.model.rows
        return model
    plane = planar_reduction(system, q)
    if not isinstance(plane, Plane):
        raise InputError(f"it moves the mechanism out of the plane: {plane.reason}")
    return InPlane(like.core, system, plane)
