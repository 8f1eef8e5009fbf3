"""compare(): chosen methods, integrators and steps on one mechanism, side by side."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise, product
from math import nan
from typing import Any, NamedTuple

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, SimulationError
from mbproj.base.registry import AUTOMATIC, PROJECTIONS, integrator_choices, is_embedded
from mbproj.base.settings import Settings
from mbproj.equations.assembly.assemble import State
from mbproj.equations.energy import total_energy
from mbproj.motion.formulations.choice import Choice, choose
from mbproj.motion.formulations.full import FullFormulation
from mbproj.motion.marks import START, Mark
from mbproj.motion.numpy_loop import march
from mbproj.motion.report import Tally
from mbproj.motion.simulate import simulate
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.studies import COMPARED, ENERGY_ROW
from mbproj.results.views import Table, Tabled
from mbproj.scene.sampling import whole_steps
from mbproj.scene.scene import Scene
from mbproj.studies.measure.measurement import (
    REPETITIONS,
    Measurement,
    SettingsStudy,
    Timing,
    Yardstick,
    measured,
    timing_columns,
)
from mbproj.studies.measure.reference import Reference, common_times, error, reference, span
from mbproj.studies.measure.setting import Setting, only_full
from mbproj.studies.measure.solve import DatasetRecorder, Mechanism, Series, Solution, solve
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell, silent

# --- Energy drift -----------------------------------------------------------------------------------------------------
# The energy drift of a run, split into the part of the integrator and the work of the projection.
# Each step is repeated from the state before it, once without projection and once with it, in the formulation of the
# run. The change of E - W + D in the first is the integrator's part. The difference of the second from the first is
# the projection's work. Their sum is the drift: with fixed steps to round-off, with error control to second order in
# the violation. There the kernel projects with the factor of another stage.


#: The first and the largest number of samples with which the steps of a run with error control are looked for.
SAMPLES, MOST_SAMPLES = 4000, 4_000_000


@dataclass(frozen=True, eq=False)
class EnergySplit:
    """The part of the integrator and the work of the projections in the energy drift, each cumulated up to `times`
    (T,), (T,) in J. Their sum is the drift."""

    times: Series
    integrator: Series
    projection: Series


class _StepEnd(NamedTuple):
    """The end of one step: its state, and W - D over the step in J. `carried` is for the next step: the mark of the
    run, and W - D at the mark."""

    state: State
    work: float
    carried: tuple[Mark, float] = (START, 0.0)


def energy_split(mechanism: Mechanism, solution: Solution) -> EnergySplit:
    """Split the energy drift of a solution at its times. Raises SimulationError where a repeated step fails."""
    setting, times = solution.setting, solution.times
    if not PROJECTIONS[setting.projection].corrects:
        return EnergySplit(times, solution.energy_balance, np.where(np.isnan(solution.energy_balance), np.nan, 0.0))
    ends = _step_ends(mechanism, setting, float(times[-1]))
    pairs = list(_steps(mechanism, setting, ends))
    start = _energies(mechanism, [mechanism.state])
    free, closed = (_energies(mechanism, [pair[which].state for pair in pairs]) for which in (0, 1))
    work = np.array([pair[0].work for pair in pairs])
    integrator = free - np.concatenate([start, closed[:-1]]) - work
    # A sample time inside a step has the sums up to the step before.
    row = np.searchsorted(ends, times * (1.0 + 1e-12), side="right") - 1
    return EnergySplit(times, _cumulated(integrator)[row], _cumulated(closed - free)[row])


def _cumulated(changes: Array) -> Array:
    return np.concatenate([np.zeros(1), np.cumsum(changes)])


def _energies(mechanism: Mechanism, states: list[State]) -> Array:
    return np.array([total_energy(mechanism.system, state) for state in states])


def _steps(mechanism: Mechanism, setting: Setting, ends: Array) -> Iterator[tuple[_StepEnd, _StepEnd]]:
    """Repeat all steps; yield the end of each without and with projection. The next step starts from the second."""
    settings = mechanism.settings(setting, float(ends[-1]), float(ends[-1]))
    every, state = settings.projection.every, mechanism.state
    choice, carried = choose(mechanism.system, state, settings), (START, 0.0)
    balance: Mark = START
    always = replace(settings, projection=replace(settings.projection, every=1))
    never = replace(settings, projection=replace(settings.projection, method="none", energy=False, momentum=False))
    for number, (begin, end) in enumerate(pairwise(ends.tolist()), start=1):
        free = _one_step(mechanism, choice, never, state, end - begin, carried)
        closed = free
        if number % every == 0 or number == 1:  # the energy row's balance begins with the first step
            projected = _one_step(mechanism, choice, always, state, end - begin, carried)
            balance = {name: value for name, value in projected.carried[0].items() if name == "kept"}
            closed = projected if number % every == 0 else free
        yield free, closed
        mark, work = closed.carried
        state, carried = replace(closed.state, t=end), ({**mark, **balance}, work)


def _one_step(
    mechanism: Mechanism, choice: Choice, settings: Settings, state: State, h: float, carried: tuple[Mark, float]
) -> _StepEnd:
    """Make one step of size h (s) from a state and the data `carried` to it. Raises SimulationError where it fails."""
    single = replace(settings, step=h, duration=h, tolerance=None, output_step=None)
    if choice.compiled is None:
        full = FullFormulation.of(mechanism.system, state, single, choice.redundant)
        *_, last = march(full, state, Tally())
        return _StepEnd(last.state, float(last.work[0] - last.work[1]))
    run, (mark, before) = choice.compiled.run(state, single), carried
    if mark:
        start_mark = mark if run.kept else {name: value for name, value in mark.items() if name != "kept"}
        run.resume({**start_mark, "t": state.t, "h": h, "grid": 0})
    block = run.advance(2, np.inf)
    failure = choice.compiled.failure(run, settings)
    if failure is not None:
        raise failure
    samples = choice.compiled.samples({name: values[-1:] for name, values in block.items()}, {})
    work = float(samples.work[0, 0] - samples.work[0, 1])
    return _StepEnd(samples.state(0), work - before, (run.here(), work))


def _step_ends(mechanism: Mechanism, setting: Setting, until: float) -> Array:
    """The start time and the times at which the steps of a run end, (N + 1,) in s."""
    if setting.step is not None:
        count = whole_steps(setting.settings(until, until))
        return np.append(setting.step * np.arange(count), until)
    samples = SAMPLES
    while samples <= MOST_SAMPLES:
        recorder = DatasetRecorder(("diagnostics/steps", "diagnostics/step_size"))
        simulate(mechanism.system, mechanism.state, mechanism.settings(setting, until, until / samples), recorder)
        number, size = recorder["diagnostics/steps"][1:], recorder["diagnostics/step_size"][1:]
        steps, first = np.unique(number, return_index=True)
        if len(steps) == steps[-1]:  # every step has a sample
            return np.append(np.concatenate([[0.0], np.cumsum(size[first][:-1])]), until)
        samples *= 8
    raise ValueError("the steps are too small to be found one by one")


# --- compare() --------------------------------------------------------------------------------------------------------


#: The projections that are compared by default: one of each kind that every formulation has.
PROJECTIONS_COMPARED = ("none", "baumgarte", "gopm", "gpopm")

#: The counters in the row of a setting.


@dataclass(frozen=True, eq=False)
class SettingResult:
    """The result of one setting of a comparison: its measurement, its solution, and its error (T, k) in m.

    `split` has the two parts of the energy drift, None where the run failed or has no split. `timing` is None where the
    run failed, or costs are not compared in time."""

    label: str
    measurement: Measurement
    solution: Solution
    error: Array
    split: EnergySplit | None
    timing: Timing | None

    @property
    def numbers(self) -> dict[str, Any]:
        """The numbers of a row: the largest violations and error (m), the energy drift at the end (J) and its two
        parts, CPU seconds (median, smallest, largest), counters. A number that does not exist is NaN."""
        measurement = self.measurement
        parts = (nan, nan) if self.split is None else (self.split.integrator[-1], self.split.projection[-1])
        return {
            "setting": measurement.setting.command_line(),
            "formulation": measurement.formulation,
            "position_violation": nan if measurement.failure else measurement.position_violation,
            "velocity_violation": nan if measurement.failure else measurement.velocity_violation,
            "acceleration_violation": float(self.solution.acceleration_violation.max()),
            "error": measurement.at(),
            "energy_drift": float(sum(parts)),
            "energy_drift_integrator": float(parts[0]),
            "energy_drift_projection": float(parts[1]),
            **self._energy_row_numbers(),
            **timing_columns(self.timing),
            **{fact.key: measurement.counters.get(fact.key, nan) for fact in COMPARED},
            "failure": measurement.failure or "",
        }

    def _energy_row_numbers(self) -> dict[str, float]:
        """The numbers of the energy row: the energy that it added, signed and in absolute values, J; and the numbers of
        steps at which it was satisfied, left out, or refused."""
        report = self.solution.report
        if not self.measurement.setting.energy_row or report is None:
            return {}
        return report_of(ENERGY_ROW, report)


@dataclass(frozen=True, eq=False)
class Comparison(Tabled):
    """The results of all settings, in the order asked for, and the reference of their errors. `cost_in_time` is False
    where they ran in several formulations, whose seconds do not compare. `notes` are for the reader."""

    entries: tuple[SettingResult, ...]
    reference: Reference
    cost_in_time: bool
    notes: tuple[str, ...]

    @property
    def table(self) -> Table:
        """A table with a row for each setting: its label and its numbers. Where some have the energy row, the columns
        of its numbers are NaN for the others."""
        rows = [{"label": entry.label, **entry.numbers} for entry in self.entries]
        return Table.of({name: row.get(name, nan) for name in max(rows, key=len)} for row in rows)

    @property
    def line(self) -> str:
        """A line with the number of settings and the duration."""
        return f"{len(self.entries)} settings until t = {self.reference.times[-1]:.6g} s"

    __repr__ = Tabled.__repr__


def compare(
    scene: Scene,
    *,
    projections: Sequence[str] = PROJECTIONS_COMPARED,
    integrators: Sequence[str] | None = None,
    steps: Sequence[float] | None = None,
    tolerances: Sequence[float] | None = None,
    formulations: Sequence[str] | None = None,
    energy_rows: Sequence[bool] | None = None,
    alphas: Sequence[float] | None = None,
    gains: Sequence[tuple[float, float]] | None = None,
    until: float | None = None,
    repetitions: int = REPETITIONS,
    processes: Where = None,
    fresh: bool = False,
    tell: Tell = silent,
) -> Comparison:
    """Runs every projection with every integrator and every step (s) or tolerance over `until` s, without or with the
    energy row. A method that takes a penalty, or gains (1/s), runs with each of `alphas`, or of `gains`. Stored results
    are reused, unless `fresh`.

    The scene's own settings complete the arguments. Raises InputError for what cannot be run at all; a setting that
    fails is an entry of the result.
    """
    settings, notes = _settings(scene, projections, integrators, steps, tolerances, formulations, energy_rows)
    settings = _with_each(settings, "alpha", alphas)
    settings = _with_each(settings, "gains", gains)
    mechanism = Mechanism.to_choose_for(scene)
    times = common_times(span(scene, until), {each.step for each in settings if each.step is not None})
    truth = reference(mechanism, times, {each.integrator for each in settings}, tell=tell)
    kind = tuple[Solution, EnergySplit | None]
    study = SettingsStudy("compare", mechanism, truth, processes, fresh, tell, kind)
    runs = study.of_settings(_solved, settings)
    taken = {solution.report.formulation for solution, _ in runs if solution.report is not None}
    alive = [solution.setting for solution, _ in runs if solution.report is not None and len(taken) == 1]
    timings = study.timed(alive, repetitions)
    entries = tuple(
        SettingResult(label, measured(one, truth), one, error(one, truth), split, timings.get(one.setting))
        for label, (one, split) in zip(labels_of(settings), runs, strict=True)
    )
    return Comparison(entries, truth, len(taken) <= 1, (*notes, *_notes(entries, truth, taken)))


def _solved(yardstick: Yardstick, setting: Setting) -> tuple[Solution, EnergySplit | None]:
    """Solve with a setting and split the energy drift. There is no split for `auto`, whose steps use several methods,
    and with contacts. This runs in a worker process."""
    mechanism = yardstick.mechanism
    solution = solve(mechanism, setting, yardstick.reference.times)
    try:
        # energy lost in impacts and friction belongs neither to the integrator nor to the projection
        changes = mechanism.system.has_contacts
        undivided = bool(solution.failure) or setting.integrator == AUTOMATIC or changes
        return solution, None if undivided else energy_split(mechanism, solution)
    except SimulationError:
        return solution, None


def _settings(
    scene: Scene,
    projections: Sequence[str],
    methods: Sequence[str] | None,
    steps: Sequence[float] | None,
    tolerances: Sequence[float] | None,
    formulations: Sequence[str] | None,
    rows: Sequence[bool] | None,
) -> tuple[list[Setting], list[str]]:
    """All combinations of the requested options, and notes. They are in one formulation, whose reason a note gives,
    unless several are asked for."""
    scene_setting, notes = Setting.of(scene.settings), []
    sizes: list[dict[str, Any]] = [{"step": step, "tolerance": None} for step in (() if steps is None else steps)]
    sizes += [{"step": None, "tolerance": tolerance} for tolerance in (() if tolerances is None else tolerances)]
    if not sizes:
        if scene_setting.step is None and scene_setting.tolerance is None:
            problem = Problem(
                "the scene has neither step nor tolerance",
                scene.place("simulation"),
                "say which with --steps or --tolerances",
            )
            raise InputError(problem)
        sizes = [{"step": scene_setting.step, "tolerance": scene_setting.tolerance}]
    slow = only_full(projections)
    chosen = list(formulations or ["full" if slow else scene_setting.formulation])
    if slow and not formulations and scene_setting.formulation != "full":
        names = ", ".join(f"'{name}'" for name in slow)
        notes.append(f"all in the full formulation: {names} exist{'s' * (len(slow) == 1)} there only")
    all_settings = [
        replace(each.projected_by(projection), integrator=integrator, formulation=formulation, **size)
        for formulation, projection, integrator, size, each in product(
            chosen,
            projections,
            methods or [scene_setting.integrator],
            sizes,
            [scene_setting] if rows is None else [replace(scene_setting, energy_row=row) for row in rows],
        )
        if (_takes_tolerance(integrator) if size["step"] is None else integrator != AUTOMATIC)
    ]
    if not all_settings:
        message = f"{', '.join(methods or [scene_setting.integrator])}: no error estimate, which a tolerance needs"
        if AUTOMATIC in (methods or [scene_setting.integrator]):
            message = f"'{AUTOMATIC}' chooses its steps by their error: it takes no 'step'"
            raise InputError(Problem(message, Place("--steps"), "give --tolerances"))
        raise InputError(Problem(message, Place("--tolerances"), "add --integrators dop853, or give --steps"))
    for setting in all_settings:
        setting.settings(1.0, setting.step or 1.0)  # raises InputError for an unknown name
    return list(dict.fromkeys(all_settings)), notes


def _with_each(settings: Sequence[Setting], option: str, values: Sequence[Any] | None) -> list[Setting]:
    """The settings, each whose projection takes the option once with each value. Raises InputError where none does."""
    if values is None:
        return list(settings)
    able = {setting.projection for setting in settings if option in PROJECTIONS[setting.projection].options}
    if not able:
        takers = " or ".join(name for name, entry in PROJECTIONS.items() if option in entry.options)
        name = "alphas" if option == "alpha" else option
        raise InputError(Problem(f"no method that is compared takes '{option}'", Place(f"--{name}"), f"add {takers}"))
    varied: list[Setting] = []
    for setting in settings:
        changes: list[dict[str, Any]] = [{option: value} for value in values] if setting.projection in able else [{}]
        varied += [replace(setting, **change) for change in changes]
    return varied


def _takes_tolerance(integrator: str) -> bool:
    """Whether an integrator can run with a tolerance. An unknown one counts as able: another check reports it."""
    return integrator not in integrator_choices() or is_embedded(integrator)


def labels_of(settings: Sequence[Setting]) -> list[str]:
    """Labels for a legend: the words in which the labels of the settings differ, or the projection where they do
    not."""
    words = [[each.formulation, *each.label.split(", ")] for each in settings]
    shared = set.intersection(*map(set, words))
    return [", ".join(word for word in label if word not in shared) or label[1] for label in words]


def _notes(entries: Sequence[SettingResult], truth: Reference, taken: set[str]) -> list[str]:
    """Notes for a reader of the table."""
    notes = [
        truth.words,
        *(f"{entry.label}: {entry.solution.failure}" for entry in entries if entry.solution.failure),
        *(
            f"{entry.label}: by its energy the motion may be wrong"
            for entry in entries
            if entry.measurement.doubt > 1.0
        ),
    ]
    if len(taken) > 1:
        notes.append("several formulations: cost is compared in factorisations and iterations, not in time")
    floor = float(np.max(truth.uncertainty[-1]))
    below = [entry.label for entry in entries if np.isfinite(entry.error).all() and entry.error.max() < 10.0 * floor]
    if below:
        notes.append(f"errors not far above the reference's own uncertainty: {'; '.join(below)}")
    return notes
