"""tradeoff(): accuracy and cost of settings on a mechanism, measured over a designed grid.

First each integrator is swept with one projection. Integrators that need few evaluations for some error are then swept
with the other projections and schedules. All sweeps run in parallel. Then the settings near the front are timed: alone,
in turn, several times over.

The settings of a ladder differ only in the size of their steps, from coarse to fine. A ladder is swept until a finer
setting brings nothing more.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import product
from math import ceil, inf, nan
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from mbproj.base import registry
from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.version import __version__
from mbproj.results.output_files import hdf5, replacing
from mbproj.results.report_schema.facts import report_of
from mbproj.results.report_schema.studies import COUNTED, OF_POINT, TRIALS, VARIED
from mbproj.results.views import Table, Tabled
from mbproj.scene.scene import Scene
from mbproj.studies.measure.measurement import (
    REPETITIONS,
    Measurement,
    SettingsStudy,
    Timing,
    Yardstick,
    timing_columns,
)
from mbproj.studies.measure.reference import Reference, certain_reference, divisors, span
from mbproj.studies.measure.setting import Setting, only_full
from mbproj.studies.measure.solve import Mechanism
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.studies.study import Study

# --- Pareto fronts, neighbours and families ---------------------------------------------------------------------------
# Pareto fronts of a grid of settings, the settings near them that are timed, and the families of settings that are
# lines in diagrams.


#: A setting is timed where its first time is within this factor of the cheapest setting that is as good. At most
#: `MOST_TIMED` settings are timed.
NEAR_IN_TIME, MOST_TIMED = 1.5, 40
#: Errors below this count as zero, before a logarithm is taken. They occur where nothing moves, or the span is zero.
NONE = 1e-300
#: Joints count as closed where |C| is at most this part of the mechanism's size, or of 1 m.
CLOSED = 1e-11


def front(cost: Sequence[float] | Array, error: Sequence[float] | Array) -> Integers:
    """Indices of the Pareto front, by increasing cost. A setting is on it where no other has at most its cost and its
    error, and less of one. Of equal settings the first counts; infinite values never do."""
    costs, errors = np.asarray(cost, dtype=float), np.asarray(error, dtype=float)
    order = np.lexsort((np.arange(len(costs)), errors, costs))
    indices, best = [], np.inf
    for index in order:
        if np.isfinite(costs[index]) and errors[index] < best:
            indices.append(index)
            best = errors[index]
    return np.array(indices, dtype=np.intp)


def excess(cost: Sequence[float] | Array, error: Sequence[float] | Array) -> Array:
    """The cost of each setting over the least cost with at most its error, (N,) >= 1. It is infinite where the cost or
    the error is not finite."""
    costs, errors = np.asarray(cost, dtype=float), np.asarray(error, dtype=float)
    ratios = np.full(len(costs), np.inf)
    for index in np.flatnonzero(np.isfinite(costs) & np.isfinite(errors)):
        ratios[index] = costs[index] / costs[errors <= errors[index]].min()
    return ratios


def cheapest(cost: Sequence[float] | Array, error: Sequence[float] | Array, limit: float) -> int | None:
    """The index of the cheapest setting with an error of at most `limit`; None where there is none."""
    costs = np.where(np.asarray(error, dtype=float) <= limit, np.asarray(cost, dtype=float), np.inf)
    index = int(np.argmin(costs)) if len(costs) else 0
    return index if len(costs) and np.isfinite(costs[index]) else None


def projections_at_one_size(trials: Sequence[Measurement], errors: Array, scene_setting: Setting | None) -> list[int]:
    """Indices of settings with one integrator and one fixed step that differ only in their projection. The largest such
    group is taken. Of equally large groups, take the one with the scene's own setting, or else the one with the middle
    error."""
    groups: dict[Any, list[int]] = {}
    for index, trial in enumerate(trials):
        if trial.setting.step is not None and trial.failure is None:
            groups.setdefault((trial.setting.integrator, trial.setting.step), []).append(index)
    most = max((len(group) for group in groups.values()), default=0)
    full = [group for group in groups.values() if len(group) == most and most > 1]
    if not full:
        return []
    for group in full:
        if scene_setting is not None and any(trials[index].setting == scene_setting for index in group):
            return group
    best = np.log(np.array([errors[group].min() for group in full]).clip(NONE))
    middle = 0.5 * (best.min() + best.max())
    return full[int(np.argmin(np.abs(best - middle)))]


def to_time(trials: Sequence[Measurement], errors: Array, closed: float, always: Sequence[int]) -> list[int]:
    """Indices of the settings to time: those near one of three fronts, and `always`. The fronts are of all settings, of
    the settings with |C| of at most `closed`, and with |C| in place of the error."""
    seconds = np.array([trial.seconds for trial in trials])
    violations = np.array([trial.position_violation for trial in trials])
    fronts = (errors, np.where(violations <= closed, errors, inf), violations)
    nearness = np.min([excess(seconds, values) for values in fronts], axis=0)
    near = [index for index in np.argsort(nearness, kind="stable") if nearness[index] <= NEAR_IN_TIME][:MOST_TIMED]
    alive = [index for index in always if trials[index].failure is None]
    return sorted({int(index) for index in (*near, *alive)})


def kind(setting: Setting) -> str:
    """The integrator of a setting and how its step is chosen: fixed steps or a tolerance."""
    return f"{setting.integrator}, {'fixed steps' if setting.tolerance is None else 'tolerance'}"


def by_integrator(trials: Sequence[Measurement]) -> dict[str, list[int]]:
    """Indices of the trials that have the projection and schedule of the first trial, by integrator and kind of
    step."""
    plain = trials[0].setting.schedule
    return grouped(trials, lambda setting: kind(setting) if setting.schedule == plain else None)


def studied(trials: Sequence[Measurement], front: Sequence[int]) -> str:
    """The integrator and kind of step with most settings on the front, among those that were tried with several
    projections."""
    tried = {
        name: len({trials[index].setting.schedule for index in indices})
        for name, indices in grouped(trials, kind).items()
    }
    wins = {name: sum(kind(trials[index].setting) == name for index in front) for name in tried}
    return max(tried, key=lambda name: (tried[name] > 1, wins[name]))


def by_projection(trials: Sequence[Measurement], name: str) -> dict[str, list[int]]:
    """Indices of the trials of one integrator and kind of step, by projection and schedule."""
    return grouped(trials, lambda setting: setting.schedule if kind(setting) == name else None)


def grouped(trials: Sequence[Measurement], key: Callable[[Setting], str | None]) -> dict[str, list[int]]:
    """Indices of the trials, grouped by `key` of their settings; trials whose key is None are left out."""
    groups: dict[str, list[int]] = {}
    for index, trial in enumerate(trials):
        name = key(trial.setting)
        if name is not None:
            groups.setdefault(name, []).append(index)
    return groups


# --- `Tradeoff` -------------------------------------------------------------------------------------------------------
# The trials of a grid of settings, with their Pareto fronts, as a table and as an HDF5 file.


#: Columns of the table: options of a setting, and counters of its run.


@dataclass(frozen=True, eq=False)
class Tradeoff(Tabled):
    """The trials of a grid of settings on a mechanism of `size` (m). The largest error of `points` counts.

    `timings` are those of the trials that were timed, by their index. `own` is the index of the scene's own setting, or
    None. `compared` are the indices of settings that differ only in their projection. `notes` are for the reader."""

    title: str
    size: float
    points: tuple[str, ...]
    trials: tuple[Measurement, ...]
    timings: Mapping[int, Timing]
    own: int | None
    compared: tuple[int, ...]
    reference: Reference
    notes: tuple[str, ...]

    @cached_property
    def error(self) -> Array:
        """The largest error of the points, (N,) in m."""
        return np.array([trial.at(self.points) for trial in self.trials])

    @cached_property
    def violation(self) -> Array:
        """The largest |C|, (N,) in m or rad."""
        return np.array([trial.position_violation for trial in self.trials])

    @cached_property
    def seconds(self) -> Array:
        """The processor time of settings that were timed alone, (N,) in s; infinite for the others."""
        timed = np.full(len(self.trials), inf)
        for index, timing in self.timings.items():
            timed[index] = timing.median
        return timed

    @cached_property
    def front(self) -> tuple[int, ...]:
        """Indices of the Pareto front, the cheapest setting first: no other setting is both cheaper and more
        accurate."""
        return tuple(front(self.seconds, np.maximum(self.error, self.floor)).tolist())

    @cached_property
    def violation_front(self) -> tuple[int, ...]:
        """Indices of the Pareto front with |C| in place of the error, the cheapest setting first."""
        return tuple(front(self.seconds, self.violation).tolist())

    def cheapest(self, limit: float, closed: float = inf) -> int | None:
        """The index of the cheapest setting with an error (m) of at most `limit` and |C| (m or rad) of at most
        `closed`."""
        return cheapest(self.seconds, np.where(self.violation <= closed, self.error, inf), limit)

    def most_accurate(self, seconds: float) -> int | None:
        """The index of the most accurate setting that takes at most `seconds`."""
        return cheapest(self.error, self.seconds, seconds)

    @property
    def floor(self) -> float:
        """The uncertainty of the reference over the whole span, m."""
        columns = [self.reference.points.index(name) for name in self.points]
        return float(self.reference.uncertainty[-1, columns].max())

    @property
    def table(self) -> Table:
        """A table with a row for each setting. `TRIALS` describes its columns."""
        return Table.of(map(self._row, range(len(self.trials))))

    @property
    def line(self) -> str:
        """A line with the number of settings, the duration, and the number of failures."""
        failed = sum(trial.failure is not None for trial in self.trials)
        until = self.reference.times[-1]
        return (
            f"{self.title or 'The mechanism'}: {len(self.trials)} settings up to {until:g} s, of which {failed} failed"
        )

    __repr__ = Tabled.__repr__

    def _row(self, index: int) -> dict[str, Any]:
        trial = self.trials[index]
        return {
            "setting": trial.setting.command_line(),
            **report_of(VARIED, trial.setting),
            "formulation": trial.formulation,
            "error": float(self.error[index]),
            **{f"error_{name}": trial.error[name] for name in self.reference.points},
            "position_violation": trial.position_violation,
            "velocity_violation": trial.velocity_violation,
            "energy_drift": trial.energy_drift,
            "warned": trial.doubt > 1.0,
            **{fact.key: trial.counters.get(fact.key, 0) for fact in COUNTED},
            **timing_columns(self.timings.get(index)),
            "first_cpu_seconds": trial.seconds,
            "on_front": index in self.front,
            "on_violation_front": index in self.violation_front,
            "failure": trial.failure or "",
        }


FORMAT = "mbproj tradeoff"
KIND = hdf5(FORMAT)


def write_hdf5(path: Path, result: Tradeoff, *, force: bool = False) -> Path:
    """Write a trade-off: /trials has an array for each column of its table, /reference has times, positions and
    uncertainty."""
    with replacing(path, KIND, force=force) as draft, h5py.File(draft, "w") as file:
        file.attrs.update(
            {
                "format": FORMAT,
                "mbproj_version": __version__,
                "title": result.title,
                "points": list(result.points),
                "notes": list(result.notes),
            }
        )
        table, trials = result.table, {fact.key: fact for fact in TRIALS}
        for name, column in zip(table.headings, zip(*table.rows, strict=True), strict=True):
            values = [nan if value is None else value for value in column]
            text = isinstance(values[0], str)
            data = np.array(values, dtype=h5py.string_dtype() if text else None)
            dataset = file.create_dataset(f"trials/{name}", data=data)
            fact = trials.get(name, trials[OF_POINT])
            dataset.attrs.update({"description": fact.words.partition("; null")[0], "units": fact.unit})
        truth = result.reference
        for name, array, unit in (
            ("time", truth.times, "s"),
            ("position", truth.position, "m"),
            ("uncertainty", truth.uncertainty, "m"),
        ):
            file.create_dataset(f"reference/{name}", data=array).attrs["units"] = unit
        file["reference"].attrs.update({"points": list(truth.points), "method": truth.method, "check": truth.check})
    return path


# --- tradeoff() -------------------------------------------------------------------------------------------------------


#: Projections of the grid by default: one of each kind that every formulation has.
PROJECTIONS_TRIED = ("gpopm", "gopm", "none", "baumgarte")
#: Sweeps end at an error of this multiple of the reference's uncertainty, or of this part of the mechanism's size.
ABOVE_FLOOR, FINEST = 3.0, 1e-11
#: The fewest and the most steps over the whole span, and the least ratio between neighbouring numbers.
FEWEST, MOST, RATIO = 20, 400_000, 1.4
#: Exponents of the tolerances, from the loosest to the tightest, a decade apart.
TOLERANCES = range(2, 14)
#: Schedules of the projection: every k-th step, or above thresholds that are parts of the mechanism's size.
EVERY = (2, 5, 20)
THRESHOLDS = (1e-3, 1e-6, 1e-9)
#: A sweep ends when this many settings in a row have not brought the error below this part of the best error.
PATIENCE, FALLING = 3, 0.7
#: A ladder is promising where its evaluations are within this factor of the fewest for some error limit. At most
#: `PROMISING` ladders are chosen. The limits are a decade apart.
NEAR_IN_EVALUATIONS, PROMISING = 1.5, 2


def tradeoff(
    scene: Scene,
    *,
    projections: Sequence[str] = PROJECTIONS_TRIED,
    integrators: Sequence[str] | None = None,
    formulation: str | None = None,
    at: Sequence[str] = (),
    until: float | None = None,
    longest: float = 0.5,
    repetitions: int = REPETITIONS,
    processes: Where = None,
    fresh: bool = False,
    tell: Tell = silent,
) -> Tradeoff:
    """Measures accuracy against cost over `projections`, `integrators` (by default the explicit ones), steps,
    tolerances and schedules.

    The error is the largest up to `until` s (the duration) at the markers `at` (all of them; the bodies' centres where
    the scene has none). A sweep ends with a run that takes more than `longest` s. An interrupted study resumes, and a
    finished one gives the same tables again, unless `fresh`. Raises InputError for what cannot be run at all.
    """
    mechanism, scene_setting = Mechanism.to_choose_for(scene), Setting.of(scene.settings)
    points = tuple(mechanism.points[k] for k in mechanism.columns(at))
    names = tuple(integrators or registry.explicit_integrators())
    for projection, name in product(projections, names):
        free = name == registry.AUTOMATIC  # raises InputError for an unknown name
        Setting(projection, name, None if free else 1.0, 1e-3 if free else None).settings(1.0, 1.0)
    # all runs are in one formulation: seconds of different formulations are not comparable
    scene_setting = replace(
        scene_setting, formulation=formulation or ("full" if only_full(projections) else scene_setting.formulation)
    )
    base = replace(scene_setting, step=None, tolerance=None)
    truth, notes = certain_reference(mechanism, span(scene, until), scene_setting, names, tell)
    goal = max(ABOVE_FLOOR * float(truth.uncertainty[-1].max()), FINEST * mechanism.system.length)
    kind = list[Measurement]
    study = SettingsStudy("tradeoff", mechanism, truth, processes, fresh, tell, kind, longest=longest)
    mine = scene_setting if scene_setting.step or scene_setting.tolerance else None
    track = SweepSetup(study.yardstick, goal, longest)
    trials = _accuracy(study, track, base, mine, projections, names)
    numbers = {trial.setting: index for index, trial in enumerate(trials)}
    if mine is not None and mine not in numbers:
        numbers[mine] = len(trials)
        trials += study.measured([mine])
    errors = np.array([trial.at(points) for trial in trials])
    compared = projections_at_one_size(trials, errors, mine)
    closed = CLOSED * max(1.0, mechanism.system.length)
    wanted = to_time(trials, errors, closed, [*compared, *([numbers[mine]] if mine is not None else [])])
    timings = study.timed([trials[index].setting for index in wanted], repetitions)
    return Tradeoff(
        title=scene.title,
        size=mechanism.system.length,
        points=points,
        trials=tuple(trials),
        timings=dict(zip(wanted, timings.values(), strict=True)),
        own=None if mine is None else numbers[mine],
        compared=tuple(compared),
        reference=truth,
        notes=tuple(notes),
    )


def _accuracy(
    study: Study,
    track: SweepSetup,
    base: Setting,
    scene_setting: Setting | None,
    projections: Sequence[str],
    names: Sequence[str],
) -> list[Measurement]:
    """The trials of the grid: first all integrators, then projections and schedules of the promising ladders and the
    scene's own."""
    methods = [
        replace(base.projected_by(name), every=1, threshold=None, formulation=base.formulation) for name in projections
    ]
    ladders = integrator_ladders(methods[0], names)
    first = sweeps(study, track, ladders, "integrators")
    others: list[Ladder] = []
    constrained = track.yardstick.mechanism.system.joints.size > 0
    owned = [each for each in ladders if scene_setting is not None and each.holds(scene_setting)]
    for ladder in dict.fromkeys((*promising(ladders, first), *owned)) if constrained else ():
        others += projection_ladders(ladder, methods[1:])
        if registry.PROJECTIONS[methods[0].projection].corrects:
            others += schedule_ladders(ladder, track.yardstick.mechanism.system.length)
    second = sweeps(study, track, others, "projections and schedules")
    unique = {trial.setting: trial for swept in (*first, *second) for trial in swept}
    return list(unique.values())


def promising(ladders: Sequence[Ladder], swept: Sequence[Sequence[Measurement]]) -> list[Ladder]:
    """The ladders that need about the fewest evaluations for most of the error limits, which are a decade apart."""
    flat = [(number, trial) for number, trials in enumerate(swept) for trial in trials if np.isfinite(trial.at())]
    errors = np.array([trial.at() for _, trial in flat])
    evaluations = np.array([trial.counters["evaluations"] for _, trial in flat], dtype=float)
    owner = np.array([number for number, _ in flat])
    if not len(flat):
        return []
    wins = np.zeros(len(ladders))
    lowest, highest = np.log10(np.array([errors.min(), errors.max()]).clip(NONE))
    for limit in 10.0 ** np.arange(np.ceil(lowest), highest + 1.0):
        able = np.where(errors <= limit, evaluations, inf)
        best = np.array([able[owner == number].min(initial=inf) for number in range(len(ladders))])
        wins += best <= NEAR_IN_EVALUATIONS * best.min()
    chosen = [number for number in np.argsort(-wins, kind="stable") if wins[number]][:PROMISING]
    return [ladders[number] for number in sorted(chosen)]


@dataclass(frozen=True)
class Ladder:
    """Settings that add to `base` a step or, with `by_tolerance`, a tolerance."""

    base: Setting
    by_tolerance: bool

    @property
    def label(self) -> str:
        """A short label, e.g. "rk4, gpopm every 5 steps" or "dop853 to a tolerance, none"."""
        base, method = self.base, f"{self.base.integrator}{' to a tolerance' if self.by_tolerance else ''}"
        return f"{method}, {base.schedule}"

    def holds(self, setting: Setting) -> bool:
        """Whether a setting has the integrator and the kind of step of this ladder."""
        by_tolerance = setting.tolerance is not None
        return (setting.integrator, by_tolerance) == (self.base.integrator, self.by_tolerance)

    def sizes(self, times: Array) -> list[Setting]:
        """The settings of the ladder from coarse to fine: all tolerances, or steps that meet some of `times`."""
        if self.by_tolerance:
            return [replace(self.base, step=None, tolerance=float(f"1e-{k}")) for k in TOLERANCES]
        until = float(times[-1])
        return [replace(self.base, step=until / steps, tolerance=None) for steps in step_numbers(len(times) - 1)]


def step_numbers(intervals: int) -> list[int]:
    """Numbers of steps that divide `intervals` or are multiples of it, in ratios of at least `RATIO`."""
    chosen: list[int] = []
    for part in divisors(intervals):
        if part >= (RATIO * chosen[-1] if chosen else FEWEST):
            chosen.append(part)
    while (number := intervals * (max(2, ceil(RATIO * chosen[-1] / intervals)) if chosen else 2)) <= MOST:
        chosen.append(number)
    return chosen


def integrator_ladders(base: Setting, names: Sequence[str]) -> list[Ladder]:
    """A ladder with fixed steps for each integrator, and one with tolerances where the integrator estimates its
    error."""
    ladders = []
    for name in names:
        if name != registry.AUTOMATIC:
            ladders.append(Ladder(_sizeless(base, integrator=name), by_tolerance=False))
        if registry.is_embedded(name):
            ladders.append(Ladder(_sizeless(base, integrator=name), by_tolerance=True))
    return ladders


def projection_ladders(ladder: Ladder, methods: Sequence[Setting]) -> list[Ladder]:
    """The ladder with other projections: those of the settings `methods`."""
    base = ladder.base
    return [
        Ladder(_sizeless(method, integrator=base.integrator, formulation=base.formulation), ladder.by_tolerance)
        for method in methods
    ]


def schedule_ladders(ladder: Ladder, size: float) -> list[Ladder]:
    """The ladder with an energy row, and with less frequent projections. `size` (m) is the mechanism's."""
    often = [replace(ladder.base, every=k) for k in EVERY]
    above = [replace(ladder.base, threshold=float(f"{part * size:.1g}")) for part in THRESHOLDS]
    conserving = [] if ladder.base.energy_row else [replace(ladder.base, energy_row=True)]
    return [Ladder(base, ladder.by_tolerance) for base in (*conserving, *often, *above)]


def _sizeless(setting: Setting, **changes: str) -> Setting:
    return replace(setting, step=None, tolerance=None, **changes)  # type: ignore[arg-type]


@dataclass(frozen=True)
class SweepSetup:
    """The common data of all sweeps: the yardstick, the error (m) at which a sweep may end, and the seconds of a run
    from which on no finer one is tried."""

    yardstick: Yardstick
    goal: float
    longest: float


def sweep(track: SweepSetup, ladder: Ladder) -> list[Measurement]:
    """Run a ladder's settings from coarse to fine and return their measurements."""
    trials: list[Measurement] = []
    best, stuck = float("inf"), 0
    for setting in ladder.sizes(track.yardstick.reference.times):
        trials.append(track.yardstick.measure(setting))
        reached = trials[-1].at()
        if reached < float("inf"):
            stuck = 0 if reached < FALLING * best else stuck + 1
            best = min(best, reached)
            if best <= track.goal or trials[-1].seconds > track.longest or stuck >= PATIENCE:
                break
    return trials


def sweeps(study: Study, track: SweepSetup, ladders: Sequence[Ladder], phase: str) -> list[list[Measurement]]:
    """Run the sweeps of all ladders in parallel; return them in the order of `ladders`."""
    names = [f"sweep {ladder.base.command_line()}{' by tolerance' * ladder.by_tolerance}" for ladder in ladders]
    return study.each(sweep, track, dict(zip(names, ladders, strict=True)), phase)
