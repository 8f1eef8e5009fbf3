"""tradeoff(): accuracy and cost of settings on a mechanism, measured over a designed grid.

First each integrator is swept with one projection. Integrators that need few evaluations for some error are then swept
with the other projections and schedules. All sweeps run in parallel. Then the settings near the front are timed: alone,
in turn, several times over.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from functools import cached_property
from itertools import product
from math import inf
from typing import Any

import numpy as np

from mbproj import registry
from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.results.views.table import Table, Tabled
from mbproj.scene.records import Scene
from mbproj.studies.measure.accuracy import Yardstick, attempt
from mbproj.studies.measure.certain import certain_reference
from mbproj.studies.measure.measurement import MEASUREMENT_RECORDS, Measurement
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.reference import Reference
from mbproj.studies.measure.setting import Setting, only_full
from mbproj.studies.measure.spans import span
from mbproj.studies.measure.timing import REPETITIONS, Timing, kept_timings, timing_columns
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.studies.store import ValueCache
from mbproj.studies.tradeoff.fronts import CLOSED, cheapest, front, projections_at_one_size, promising, to_time
from mbproj.studies.tradeoff.ladders import (
    Ladder,
    SweepSetup,
    integrator_ladders,
    projection_ladders,
    schedule_ladders,
    sweeps,
)

#: Projections of the grid by default: one of each kind that every formulation has.
PROJECTIONS_TRIED = ("gpopm", "gopm", "none", "baumgarte")
#: Sweeps end at an error of this multiple of the reference's uncertainty, or of this part of the mechanism's size.
ABOVE_FLOOR, FINEST = 3.0, 1e-11

#: Columns of the table: options of a setting, and counters of its run.
SETTING = ("projection", "integrator", "step", "tolerance", "every", "threshold")
COUNTERS = (
    "steps",
    "rejected_steps",
    "evaluations",
    "projections",
    "projection_iterations",
    "velocity_iterations",
    "factorisations",
)


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
        """A table with a row for each setting. `mbproj.studies.tradeoff.table.MEANING` describes its columns."""
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
            **{name: getattr(trial.setting, name) for name in SETTING},
            "formulation": trial.formulation,
            "error": float(self.error[index]),
            **{f"error_{name}": trial.error[name] for name in self.reference.points},
            "position_violation": trial.position_violation,
            "velocity_violation": trial.velocity_violation,
            "energy_drift": trial.energy_drift,
            "warned": trial.doubt > 1.0,
            **{name: trial.counters.get(name, 0) for name in COUNTERS},
            **timing_columns(self.timings.get(index)),
            "first_cpu_seconds": trial.seconds,
            "on_front": index in self.front,
            "on_violation_front": index in self.violation_front,
            "failure": trial.failure or "",
        }


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
    mechanism, own = Mechanism.to_choose_for(scene), Setting.of(scene.settings)
    points = tuple(mechanism.points[k] for k in mechanism.columns(at))
    names = tuple(integrators or registry.explicit_integrators())
    for projection, name in product(projections, names):
        free = name == registry.AUTOMATIC  # raises InputError for an unknown name
        Setting(projection, name, None if free else 1.0, 1e-3 if free else None).settings(1.0, 1.0)
    # all runs are in one formulation: the seconds of several do not compare
    own = replace(own, formulation=formulation or ("full" if only_full(projections) else own.formulation))
    base = replace(own, step=None, tolerance=None)
    truth, notes = certain_reference(mechanism, span(scene, until), own, names, tell)
    goal = max(ABOVE_FLOOR * float(truth.uncertainty[-1].max()), FINEST * mechanism.system.length)
    track = SweepSetup(Yardstick(scene, truth), goal, longest)
    what = {
        "study": "tradeoff",
        **mechanism.identity,
        "base": asdict(base),
        "until": float(truth.times[-1]),
        "projections": list(projections),
        "integrators": list(names),
        "longest": longest,
        "repetitions": repetitions,
    }
    kept = ValueCache(what, fresh, (Timing, *MEASUREMENT_RECORDS))
    mine = own if own.step or own.tolerance else None
    trials = _accuracy(track, base, mine, projections, names, kept, processes, tell)
    numbers = {trial.setting: index for index, trial in enumerate(trials)}
    if mine is not None and mine not in numbers:
        numbers[mine] = len(trials)
        trials += attempt(mechanism, [mine], truth, kept, 1)
    errors = np.array([trial.at(points) for trial in trials])
    compared = projections_at_one_size(trials, errors, mine)
    closed = CLOSED * max(1.0, mechanism.system.length)
    wanted = to_time(trials, errors, closed, [*compared, *([numbers[mine]] if mine is not None else [])])
    timings = kept_timings(
        kept, mechanism, [trials[index].setting for index in wanted], float(truth.times[-1]), repetitions, tell
    )
    return Tradeoff(
        title=scene.title,
        size=mechanism.system.length,
        points=points,
        trials=tuple(trials),
        timings=dict(zip(wanted, timings, strict=True)),
        own=None if mine is None else numbers[mine],
        compared=tuple(compared),
        reference=truth,
        notes=tuple(notes),
    )


def _accuracy(
    track: SweepSetup,
    base: Setting,
    own: Setting | None,
    projections: Sequence[str],
    names: Sequence[str],
    kept: ValueCache,
    processes: Where,
    tell: Tell,
) -> list[Measurement]:
    """The trials of the grid: first all integrators, then projections and schedules of the promising ladders and the
    scene's own."""
    methods = [
        replace(base.projected_by(name), every=1, threshold=None, formulation=base.formulation) for name in projections
    ]
    ladders = integrator_ladders(methods[0], names)
    first = sweeps(track, ladders, kept, processes, "integrators", tell)
    others: list[Ladder] = []
    constrained = track.yardstick.mechanism.system.joints.size > 0
    owned = [each for each in ladders if own is not None and each.holds(own)]
    for ladder in dict.fromkeys((*promising(ladders, first), *owned)) if constrained else ():
        others += projection_ladders(ladder, methods[1:])
        if registry.PROJECTIONS[methods[0].projection].corrects:
            others += schedule_ladders(ladder, track.yardstick.mechanism.system.length)
    second = sweeps(track, others, kept, processes, "projections and schedules", tell)
    unique = {trial.setting: trial for swept in (*first, *second) for trial in swept}
    return list(unique.values())
