"""compare(): chosen methods on one mechanism, side by side."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import nan
from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.errors import InputError, Problem, SimulationError
from mbproj.registry import PROJECTIONS, integrators
from mbproj.scene.records import Scene
from mbproj.studies.energy_split import EnergySplit, energy_split
from mbproj.studies.measures import error
from mbproj.studies.mechanism import Mechanism
from mbproj.studies.reference import Reference, reference
from mbproj.studies.setting import Setting
from mbproj.studies.solve import Solution, solve
from mbproj.studies.spans import common_times, span
from mbproj.studies.timing import REPETITIONS, Timing, time_settings
from mbproj.studies.workers import in_parallel

#: What is compared unless something else is asked for: one of each kind that every formulation has.
PROJECTIONS_COMPARED = ("none", "baumgarte", "gopm", "gpopm")

#: What an entry counts.
COUNTERS = ("steps", "evaluations", "projections", "projection_iterations", "velocity_iterations", "factorisations")

#: Called with a phase in words, how much of it is done, and how much there is.
Tell = Callable[[str, int, int], None]


def _silent(phase: str, done: int, whole: int) -> None:
    """Tells nobody."""


@dataclass(frozen=True, eq=False)
class Entry:
    """One setting of a comparison: its solution, its error (T, k) in m, whose the energy drift is (None where the run
    failed), and what it cost (None where costs are not compared in time, or the run failed)."""

    setting: Setting
    label: str
    solution: Solution
    error: Array
    split: EnergySplit | None
    timing: Timing | None

    @property
    def numbers(self) -> dict[str, Any]:
        """The entry in a row: largest violations and error (m) over the span, the energy drift at its end (J) in its
        two parts, CPU seconds (median, smallest, largest), counters; NaN where there is none."""
        solution, report, timing = self.solution, self.solution.report, self.timing
        parts = (nan, nan) if self.split is None else (self.split.integrator[-1], self.split.projection[-1])
        low, high = timing.spread if timing else (nan, nan)
        return {
            "setting": self.setting.command_line(),
            "formulation": report.formulation if report else "",
            "position_violation": report.position_violation.value if report else nan,
            "velocity_violation": report.velocity_violation.value if report else nan,
            "acceleration_violation": float(solution.acceleration_violation.max()),
            "error": float(self.error.max()),
            "energy_drift": float(sum(parts)),
            "energy_drift_integrator": float(parts[0]),
            "energy_drift_projection": float(parts[1]),
            "cpu_seconds": timing.median if timing else nan,
            "cpu_seconds_lowest": low,
            "cpu_seconds_highest": high,
            **({name: report.counters[name] for name in COUNTERS} if report else dict.fromkeys(COUNTERS, nan)),
            "failure": str(solution.failure or ""),
        }


@dataclass(frozen=True, eq=False)
class Comparison:
    """Entries in the order asked for, and the reference of their errors. `cost_in_time` is False where the entries ran
    in several formulations, whose seconds do not compare; `notes` say what a reader should know."""

    entries: tuple[Entry, ...]
    reference: Reference
    cost_in_time: bool
    notes: tuple[str, ...]


def compare(
    scene: Scene,
    *,
    projections: Sequence[str] = PROJECTIONS_COMPARED,
    integrators: Sequence[str] | None = None,
    steps: Sequence[float] | None = None,
    tolerances: Sequence[float] | None = None,
    formulations: Sequence[str] | None = None,
    until: float | None = None,
    repetitions: int = REPETITIONS,
    processes: int | None = None,
    tell: Tell = _silent,
) -> Comparison:
    """Runs every projection with every integrator and every step (s) or tolerance over `until` s.

    What is not given is the scene's. Raises InputError for what cannot be run at all; a setting that fails is an entry.
    """
    settings, notes = _settings(scene, projections, integrators, steps, tolerances, formulations)
    mechanism = Mechanism.of(scene)
    times = common_times(span(scene, until), {each.step for each in settings if each.step is not None})
    tell("reference", 0, 1)
    truth = reference(mechanism, times, {each.integrator for each in settings})
    found: dict[int, tuple[Solution, EnergySplit | None]] = {}
    tell("runs", 0, len(settings))
    for number, result in in_parallel(_run, (scene, times), settings, processes):
        found[number] = result
        tell("runs", len(found), len(settings))
    taken = {s.report.formulation for s, _ in found.values() if s.report is not None}
    alive = [number for number in sorted(found) if found[number][0].report is not None] if len(taken) == 1 else []

    def timed(done: int) -> None:
        tell("timing", done, repetitions * len(alive))

    timings = dict(
        zip(alive, time_settings(mechanism, [settings[n] for n in alive], float(times[-1]), repetitions, timed),
            strict=True)
    )  # fmt: skip
    labels = labels_of(settings)
    entries = tuple(
        Entry(each, labels[n], found[n][0], error(found[n][0], truth), found[n][1], timings.get(n))
        for n, each in enumerate(settings)
    )
    return Comparison(entries, truth, len(taken) <= 1, (*notes, *_remarks(entries, truth, taken)))


def _run(shared: tuple[Scene, Array], setting: Setting) -> tuple[Solution, EnergySplit | None]:
    """One entry's solution and energy split; runs in a process of its own."""
    mechanism = Mechanism.of(shared[0])
    solution = solve(mechanism, setting, shared[1])
    try:
        return solution, None if solution.failure else energy_split(mechanism, solution)
    except SimulationError:
        return solution, None


def _settings(
    scene: Scene,
    projections: Sequence[str],
    methods: Sequence[str] | None,
    steps: Sequence[float] | None,
    tolerances: Sequence[float] | None,
    formulations: Sequence[str] | None,
) -> tuple[list[Setting], list[str]]:
    """The product of what was asked for, in one formulation unless several are asked for; and why that one."""
    own, notes = Setting.of(scene.settings), []
    sizes: list[dict[str, Any]] = [{"step": step, "tolerance": None} for step in steps or ()]
    sizes += [{"step": None, "tolerance": tolerance} for tolerance in tolerances or ()]
    if not sizes:
        if own.step is None and own.tolerance is None:
            problem = Problem("the scene has neither step nor tolerance", scene.place("simulation"),
                              "say which with --steps or --tolerances")  # fmt: skip
            raise InputError(problem)
        sizes = [{"step": own.step, "tolerance": own.tolerance}]
    only_full = [name for name in projections if name in PROJECTIONS and not PROJECTIONS[name].compiled]
    chosen = list(formulations or ["full" if only_full else own.formulation])
    if only_full and not formulations and own.formulation != "full":
        names = ", ".join(f"'{name}'" for name in only_full)
        notes.append(f"all in the full formulation: {names} exist{'s' * (len(only_full) == 1)} there only")
    found = [
        replace(plain(own, projection), integrator=integrator, formulation=formulation, **size)
        for formulation, projection, integrator, size in product(
            chosen, projections, methods or [own.integrator], sizes
        )
        if size["step"] is not None or _estimates(integrator)
    ]
    for setting in found:
        setting.settings(1.0, setting.step or 1.0)  # raises InputError for a name that is not there
    return list(dict.fromkeys(found)), notes


def _estimates(integrator: str) -> bool:
    """Whether an integrator can be run to a tolerance; one that is not there is left to be complained of."""
    return integrator not in integrators() or integrators()[integrator].embedded


def plain(own: Setting, projection: str) -> Setting:
    """A setting with this projection, and of the scene's own what belongs to every method; all of it where the method
    is the scene's own."""
    if projection == own.projection:
        return own
    return Setting(projection=projection, acceleration=own.acceleration)


def labels_of(settings: Sequence[Setting]) -> list[str]:
    """For a legend: of each setting's label the words in which they differ, and where that is none the projection."""
    words = [[each.formulation, *each.label.split(", ")] for each in settings]
    shared = set.intersection(*map(set, words))
    return [", ".join(word for word in own if word not in shared) or own[1] for own in words]


def _remarks(entries: Sequence[Entry], truth: Reference, taken: set[str]) -> list[str]:
    """What a reader of the table should know."""
    found = [
        f"reference: {truth.method}; it is {truth.uncertainty[-1].max():.1e} m from {truth.check} or nearer",
        *(f"{entry.label}: {entry.solution.failure}" for entry in entries if entry.solution.failure),
    ]
    if len(taken) > 1:
        found.append("several formulations: cost is compared in factorisations and iterations, not in time")
    floor = float(np.max(truth.uncertainty[-1]))
    below = [entry.label for entry in entries if np.isfinite(entry.error).all() and entry.error.max() < 10.0 * floor]
    if below:
        found.append(f"errors not far above the reference's own uncertainty: {'; '.join(below)}")
    return found
