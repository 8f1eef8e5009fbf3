"""compare(): chosen methods, integrators and steps on one mechanism, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from math import nan
from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem, SimulationError
from mbproj.registry import AUTOMATIC, integrator_choices, is_embedded
from mbproj.report_schema import report_of
from mbproj.report_schema.studies import COMPARED, ENERGY_ROW
from mbproj.results.views.table import Table, Tabled
from mbproj.scene.read import Scene
from mbproj.studies.compare.energy_split import EnergySplit, energy_split
from mbproj.studies.measure.measurement import Measurement, measured
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.reference import Reference, error, reference
from mbproj.studies.measure.setting import Setting, only_full
from mbproj.studies.measure.solve import SOLUTION_RECORDS, Solution, solve
from mbproj.studies.measure.spans import common_times, span
from mbproj.studies.measure.timing import REPETITIONS, Timing, kept_timings, timing_columns
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.studies.parallel.resumable import resumable
from mbproj.studies.store import ValueCache

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
    until: float | None = None,
    repetitions: int = REPETITIONS,
    processes: Where = None,
    fresh: bool = False,
    tell: Tell = silent,
) -> Comparison:
    """Runs every projection with every integrator and every step (s) or tolerance over `until` s, without or with the
    energy row. Stored results are reused, unless `fresh`.

    The scene's own settings complete the arguments. Raises InputError for what cannot be run at all; a setting that
    fails is an entry of the result.
    """
    settings, notes = _settings(scene, projections, integrators, steps, tolerances, formulations, energy_rows)
    mechanism = Mechanism.to_choose_for(scene)
    times = common_times(span(scene, until), {each.step for each in settings if each.step is not None})
    tell("reference", 0, 1)
    truth = reference(mechanism, times, {each.integrator for each in settings})
    kept = ValueCache(["compare", mechanism.identity, times.tolist()], fresh, (EnergySplit, Timing, *SOLUTION_RECORDS))
    items = {setting.command_line(): setting for setting in settings}
    solved = resumable(_solved, (scene, times), items, kept, processes, "runs", tell)
    runs = [solved[setting.command_line()] for setting in settings]
    taken = {solution.report.formulation for solution, _ in runs if solution.report is not None}
    alive = [solution.setting for solution, _ in runs if solution.report is not None and len(taken) == 1]
    taken_times = kept_timings(kept, mechanism, alive, float(times[-1]), repetitions, tell)
    timings = dict(zip(alive, taken_times, strict=True))
    entries = tuple(
        SettingResult(label, measured(one, truth), one, error(one, truth), split, timings.get(one.setting))
        for label, (one, split) in zip(labels_of(settings), runs, strict=True)
    )
    return Comparison(entries, truth, len(taken) <= 1, (*notes, *_notes(entries, truth, taken)))


def _solved(shared: tuple[Scene, Array], setting: Setting) -> tuple[Solution, EnergySplit | None]:
    """Solve with a setting and split the energy drift. There is no split for `auto`, whose steps use several methods,
    and with contacts. This runs in a worker process."""
    mechanism, times = Mechanism.to_choose_for(shared[0]), shared[1]
    solution = solve(mechanism, setting, times)
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
    own, notes = Setting.of(scene.settings), []
    sizes: list[dict[str, Any]] = [{"step": step, "tolerance": None} for step in (() if steps is None else steps)]
    sizes += [{"step": None, "tolerance": tolerance} for tolerance in (() if tolerances is None else tolerances)]
    if not sizes:
        if own.step is None and own.tolerance is None:
            problem = Problem(
                "the scene has neither step nor tolerance",
                scene.place("simulation"),
                "say which with --steps or --tolerances",
            )
            raise InputError(problem)
        sizes = [{"step": own.step, "tolerance": own.tolerance}]
    slow = only_full(projections)
    chosen = list(formulations or ["full" if slow else own.formulation])
    if slow and not formulations and own.formulation != "full":
        names = ", ".join(f"'{name}'" for name in slow)
        notes.append(f"all in the full formulation: {names} exist{'s' * (len(slow) == 1)} there only")
    all_settings = [
        replace(each.projected_by(projection), integrator=integrator, formulation=formulation, **size)
        for formulation, projection, integrator, size, each in product(
            chosen,
            projections,
            methods or [own.integrator],
            sizes,
            [own] if rows is None else [replace(own, energy_row=row) for row in rows],
        )
        if (_takes_tolerance(integrator) if size["step"] is None else integrator != AUTOMATIC)
    ]
    if not all_settings:
        message = f"{', '.join(methods or [own.integrator])}: no error estimate, which a tolerance needs"
        if AUTOMATIC in (methods or [own.integrator]):
            message = f"'{AUTOMATIC}' chooses its steps by their error: it takes no 'step'"
            raise InputError(Problem(message, Place("--steps"), "give --tolerances"))
        raise InputError(Problem(message, Place("--tolerances"), "add --integrators dop853, or give --steps"))
    for setting in all_settings:
        setting.settings(1.0, setting.step or 1.0)  # raises InputError for an unknown name
    return list(dict.fromkeys(all_settings)), notes


def _takes_tolerance(integrator: str) -> bool:
    """Whether an integrator can run with a tolerance. An unknown one counts as able: another check reports it."""
    return integrator not in integrator_choices() or is_embedded(integrator)


def labels_of(settings: Sequence[Setting]) -> list[str]:
    """Labels for a legend: the words in which the labels of the settings differ, or the projection where they do
    not."""
    words = [[each.formulation, *each.label.split(", ")] for each in settings]
    shared = set.intersection(*map(set, words))
    return [", ".join(word for word in own if word not in shared) or own[1] for own in words]


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
