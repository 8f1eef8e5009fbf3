"""tradeoff(): what accuracy costs on a mechanism, measured over a designed grid.

First every integrator is swept with one projection; those that are cheap somewhere, in evaluations, are swept with the
other projections and schedules, too. All that runs in parallel. Then the settings near the front are timed: alone, in
turn, several times over.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.errors import InputError, Problem
from mbproj.registry import PROJECTIONS, integrators
from mbproj.scene.records import Scene
from mbproj.scene.suggestions import choose_from
from mbproj.studies.accuracy import Yardstick
from mbproj.studies.grid import Ladder, integrator_ladders, projection_ladders, schedule_ladders
from mbproj.studies.journal import Journal
from mbproj.studies.mechanism import Mechanism
from mbproj.studies.near_front import CLOSED, projections_at_one_size, promising, to_time
from mbproj.studies.pareto import cheapest, front
from mbproj.studies.reference import Reference, reference
from mbproj.studies.setting import Setting
from mbproj.studies.spans import common_times, span
from mbproj.studies.sweep import Track, sweeps
from mbproj.studies.timing import REPETITIONS, Timing, time_settings
from mbproj.studies.trial import Trial
from mbproj.version import __version__

#: Projections of the grid unless others are asked for: one of each kind that every formulation has.
PROJECTIONS_TRIED = ("gpopm", "gopm", "none", "baumgarte")
#: A reference that is less certain than this part of the mechanism's size ends the study before its span.
CERTAIN = 1e-6
#: Sweeps end at this multiple of the reference's uncertainty, and at this part of the mechanism's size.
ABOVE_FLOOR, FINEST = 3.0, 1e-11
Tell = Callable[[str, int, int], None]


def _silent(phase: str, done: int, whole: int) -> None:
    """Tells nobody."""


@dataclass(frozen=True, eq=False)
class Tradeoff:
    """What the grid gave. `size` (m) is the mechanism's; `points` are those whose largest error counts; `timings` those
    of the trials that were timed, by their index; `own` is the index of the scene's own setting, None where it has
    none; `compared` are the indices of settings that differ in their projection alone; `notes` say what a reader should
    know."""

    title: str
    size: float
    points: tuple[str, ...]
    trials: tuple[Trial, ...]
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
        """Processor time where it was measured alone, (N,) in s; infinite elsewhere."""
        timed = np.full(len(self.trials), inf)
        for index, timing in self.timings.items():
            timed[index] = timing.median
        return timed

    @cached_property
    def front(self) -> tuple[int, ...]:
        """Indices of the settings of which none is both cheaper and more accurate, the cheapest first."""
        return tuple(front(self.seconds, np.maximum(self.error, self.floor)).tolist())

    @cached_property
    def violation_front(self) -> tuple[int, ...]:
        """The same for |C| in place of the error."""
        return tuple(front(self.seconds, self.violation).tolist())

    def cheapest(self, limit: float, closed: float = inf) -> int | None:
        """The index of the cheapest setting with at most this error (m), and at most this |C| (m or rad)."""
        return cheapest(self.seconds, np.where(self.violation <= closed, self.error, inf), limit)

    def most_accurate(self, seconds: float) -> int | None:
        """The index of the most accurate setting that takes at most so long (s)."""
        return cheapest(self.error, self.seconds, seconds)

    @property
    def floor(self) -> float:
        """The uncertainty of the reference over the whole span, m."""
        columns = [self.reference.points.index(name) for name in self.points]
        return float(self.reference.uncertainty[-1, columns].max())


def tradeoff(
    scene: Scene,
    *,
    projections: Sequence[str] = PROJECTIONS_TRIED,
    methods: Sequence[str] | None = None,
    formulation: str | None = None,
    at: Sequence[str] = (),
    until: float | None = None,
    longest: float = 0.5,
    repetitions: int = REPETITIONS,
    processes: int | None = None,
    journal: Path | None = None,
    tell: Tell = _silent,
) -> Tradeoff:
    """Measures accuracy against cost over `projections`, the integrators `methods` (all), steps, tolerances, schedules.

    The error is the largest up to `until` s (the duration) of the markers `at` (all of them; the bodies' centres where
    the scene has none). `longest`: sweeps end with a run of so many seconds. With a `journal` the study resumes where
    it was interrupted, and gives the same tables again. Raises InputError for what cannot be run at all.
    """
    mechanism = Mechanism.of(scene)
    points = _points(mechanism, at)
    own = _own(scene, formulation)
    base = replace(own, step=None, tolerance=None, formulation=_formulation(own, projections, formulation))
    names = tuple(methods or integrators())
    truth, notes = certain_reference(mechanism, span(scene, until), own, names, tell)
    goal = max(ABOVE_FLOOR * float(truth.uncertainty[-1].max()), FINEST * mechanism.system.length)
    track = Track(Yardstick(scene, truth), goal, longest)
    record = Journal(journal, _study(mechanism, truth, base, projections, names, longest, repetitions))
    mine = replace(own, formulation=base.formulation) if own.step or own.tolerance else None
    trials = _accuracy(track, base, mine, projections, names, record, processes, tell)
    numbers = {trial.setting: index for index, trial in enumerate(trials)}
    if mine is not None and mine not in numbers:
        numbers[mine] = len(trials)
        trials.append(_kept(record, track.yardstick, mine))
    errors = np.array([trial.at(points) for trial in trials])
    compared = projections_at_one_size(trials, errors, mine)
    closed = CLOSED * max(1.0, mechanism.system.length)
    wanted = to_time(trials, errors, closed, [*compared, *([numbers[mine]] if mine is not None else [])])
    timings = _timings(mechanism, record, [trials[index].setting for index in wanted], truth, repetitions, tell)
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


def _points(mechanism: Mechanism, at: Sequence[str]) -> tuple[str, ...]:
    for name in at:
        if name not in mechanism.points:
            hint = choose_from(name, mechanism.points)
            raise InputError(Problem(f"there is no '{name}' among the {mechanism.kind}", hint=hint))
    return tuple(at) or mechanism.points


def _own(scene: Scene, formulation: str | None) -> Setting:
    own = Setting.of(scene.settings)
    return own if formulation is None else replace(own, formulation=formulation)


def _formulation(own: Setting, projections: Sequence[str], asked: str | None) -> str:
    """One formulation for all, because seconds of several do not compare."""
    only_full = any(name in PROJECTIONS and not PROJECTIONS[name].compiled for name in projections)
    return "full" if only_full and asked is None else own.formulation


def certain_reference(
    mechanism: Mechanism, until: float, own: Setting, names: Sequence[str], tell: Tell = _silent
) -> tuple[Reference, list[str]]:
    """The reference up to `until` s, or as far as it is certain to `CERTAIN`; and notes on it."""
    steps = [own.step] if own.step is not None and own.step <= until else []
    tell("reference", 0, 1)
    found = reference(mechanism, common_times(until, steps), names)
    limit, notes = CERTAIN * mechanism.system.length, []
    certain = found.certain_until(limit)
    if certain < found.times[-1]:
        if certain < 2 * found.times[1]:
            message = "two fine solutions agree nowhere: there is no reference for this mechanism"
            raise InputError(Problem(message, hint="is a force or a motion not smooth? try a shorter --until"))
        notes.append(
            f"the motion is not predictable any longer: the reference is certain to {limit:.1g} m up to {certain:.4g} "
            "s, where the study ends"
        )
        found = reference(mechanism, common_times(certain, steps), names)
    largest = float(found.uncertainty[-1].max())
    notes.insert(0, f"reference: {found.method}; within {largest:.1e} m of {found.check}")
    return found, notes


def _study(
    mechanism: Mechanism, truth: Reference, base: Setting, projections: Sequence[str], names: Sequence[str],
    longest: float, repetitions: int
) -> dict[str, Any]:  # fmt: skip
    """What a journal belongs to."""
    scene = mechanism.scene
    return {
        "version": __version__, "scene": scene.text, "parameters": dict(scene.overrides), "base": asdict(base),
        "until": float(truth.times[-1]), "projections": list(projections), "integrators": list(names),
        "longest": longest, "repetitions": repetitions,
    }  # fmt: skip


def _accuracy(
    track: Track, base: Setting, own: Setting | None, projections: Sequence[str], names: Sequence[str], record: Journal,
    processes: int | None, tell: Tell,
) -> list[Trial]:  # fmt: skip
    """The trials of the grid: integrators, then projections and schedules of the promising ones and of the scene's."""
    methods = [replace(_plain(base, name), formulation=base.formulation) for name in projections]
    for method in methods:
        replace(method, integrator="rk4", step=1.0).settings(1.0, 1.0)  # raises InputError for what is not there
    ladders = integrator_ladders(methods[0], names)
    tell("integrators", 0, len(ladders))
    first = sweeps(track, ladders, record, processes, lambda done: tell("integrators", done, len(ladders)))
    others: list[Ladder] = []
    owned = [each for each in ladders if own is not None and each.holds(own)]
    for ladder in dict.fromkeys((*promising(ladders, first), *owned)):
        others += projection_ladders(ladder, methods[1:])
        if PROJECTIONS[methods[0].projection].corrects:
            others += schedule_ladders(ladder, track.yardstick.mechanism.system.length)
    tell("projections and schedules", 0, len(others))
    second = sweeps(
        track, others, record, processes, lambda done: tell("projections and schedules", done, len(others))
    )
    unique = {trial.setting: trial for swept in (*first, *second) for trial in swept}
    return list(unique.values())


def _plain(base: Setting, projection: str) -> Setting:
    """The scene's own options of its own method; the defaults of every other."""
    if projection == base.projection:
        return replace(base, every=1, threshold=None)
    return Setting(projection=projection, acceleration=base.acceleration)


def _kept(record: Journal, yardstick: Yardstick, setting: Setting) -> Trial:
    """A trial from the journal, or made and put there."""
    key = f"trial {setting.command_line()}"
    if key not in record:
        record.add(key, yardstick.trial(setting).as_json())
    return Trial.from_json(record[key])


def _timings(
    mechanism: Mechanism, record: Journal, settings: Sequence[Setting], truth: Reference, repetitions: int, tell: Tell
) -> list[Timing]:
    """From the journal, or taken and put there: all of them, because they are taken in turn."""
    if "timings" not in record:
        whole = repetitions * len(settings)
        tell("timing", 0, whole)
        until = float(truth.times[-1])
        taken = time_settings(mechanism, settings, until, repetitions, lambda done: tell("timing", done, whole))
        record.add("timings", [timing.samples for timing in taken])
    return [Timing(tuple(samples)) for samples in record["timings"]]
