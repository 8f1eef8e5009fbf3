"""The cheapest setting that keeps an error: every integrator, with fixed steps and with error control.

Costs are counted in evaluations of the accelerations, of the run as it will be, its samples included; those within a
quarter of the fewest are then timed in turn. All settings close the joints after every step.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from statistics import median

import numpy as np

from mbproj.arrays import Array
from mbproj.errors import ExitCode, InputError, MbprojError, Problem
from mbproj.scene.records import Scene, Settings
from mbproj.scene.sampling import DEFAULT_SAMPLES
from mbproj.scene.suggestions import choose_from
from mbproj.studies.bench import Bench, Outcome
from mbproj.studies.families import Family, closing, families
from mbproj.studies.mechanism import Mechanism
from mbproj.studies.reference import reference
from mbproj.studies.search import cheapest
from mbproj.studies.setting import Setting

#: Settings that take at most so many times the fewest evaluations are timed, so many times over.
CONTENDERS, REPETITIONS = 1.25, 5
#: Where the search in a family begins: the tolerance that is this part of the error over the mechanism's size.
FIRST = 0.1
#: Part of the time that is given up at once where the error cannot be kept to the end.
SHORTER = 0.02


class Unreachable(MbprojError):
    """No setting keeps the error, not even up to the first sample."""

    exit_code = ExitCode.CHECK_FAILED


@dataclass(frozen=True, eq=False)
class Recommendation:
    """The cheapest setting found that keeps `goal` (m) at `points`, verified on a fresh run.

    `best` is that run's outcome, `contenders` are those that were near, cheapest first (seconds are medians of several
    runs where they were timed), `own` the scene's own setting where it has one. All of them are up to `until` (s),
    which is before `wanted` where nothing keeps the error that long. The reference is uncertain by `uncertain` (m);
    `method` and `check` are its two solutions in words. `settings` are those of the best run.
    """

    goal: float
    points: tuple[str, ...]
    best: Outcome
    contenders: tuple[Outcome, ...]
    own: Outcome | None
    until: float
    wanted: float
    uncertain: float
    method: str
    check: str
    settings: Settings

    @property
    def setting(self) -> Setting:
        """How to run the scene."""
        return self.best.setting

    @property
    def reached(self) -> bool:
        """Whether the error is kept as long as was asked for."""
        return self.until >= self.wanted * (1.0 - 1e-9)


def recommend(
    scene: Scene,
    error: float,
    points: Sequence[str] = (),
    until: float | None = None,
    timed: bool = True,
    tell: Callable[[str], None] = lambda message: None,
) -> Recommendation:
    """The cheapest setting of `scene` whose error at every sample up to `until` (s; the scene's duration) is at most
    `error` (m) at the named points (all). `tell` is called with a line for each run; without `timed` the fewest
    evaluations decide.

    Raises InputError for a name or duration that is not there, Unreachable where no setting keeps the error at all.
    """
    mechanism = Mechanism.of(scene)
    columns = _columns(mechanism, points)
    times = sampled(scene.settings, until)
    tell("reference: two fine solutions by different methods")
    bench = Bench(mechanism, reference(mechanism, times), error, columns, tell)
    base = closing(Setting.of(scene.settings))
    first, bench = _first(bench, base)
    contenders = _timed(bench, _contenders(bench, base, first)) if timed else _contenders(bench, base, first)
    settings = contenders[0].setting.settings(float(f"{bench.until:.12g}"), float(times[1]))
    return Recommendation(
        goal=error,
        points=tuple(mechanism.points[column] for column in columns),
        best=replace(bench.fresh(contenders[0].setting, Mechanism.of(scene)), seconds=contenders[0].seconds),
        contenders=tuple(contenders),
        own=_own(bench, scene.settings),
        until=bench.until,
        wanted=float(times[-1]),
        uncertain=float(bench.uncertainty[-1]),
        method=bench.reference.method,
        check=bench.reference.check,
        settings=settings,
    )


def sampled(settings: Settings, until: float | None) -> Array:
    """The times of the samples of a scene (T,), s: every output step, or step, or a thousandth of the duration; up to
    `until`. Raises InputError where the scene has no duration."""
    duration = until or settings.duration
    if duration is None:
        raise InputError(Problem("the scene has no duration", hint="add it to 'simulation', or give --until"))
    interval = min(duration, settings.output_step or settings.step or (settings.duration or duration) / DEFAULT_SAMPLES)
    whole: Array = interval * np.arange(int(duration / interval * (1.0 + 1e-9)) + 1)
    if duration - whole[-1] > 1e-9 * duration:
        return np.concatenate([whole, [duration]])
    return whole


def _columns(mechanism: Mechanism, points: Sequence[str]) -> tuple[int, ...]:
    for name in points:
        if name not in mechanism.points:
            hint = choose_from(name, mechanism.points, mechanism.kind)
            raise InputError(Problem(f"--at: no {mechanism.kind[:-1]} '{name}'", hint=hint))
    return tuple(k for k, name in enumerate(mechanism.points) if not points or name in points)


def _first(bench: Bench, base: Setting) -> tuple[Outcome, Bench]:
    """The cheapest of the first family, which reaches the smallest errors; with a shorter time where that is needed,
    because the motion is chaotic or the error near round-off."""
    wanted, family = bench.until, next(families(base, _interval(bench)))
    certain = bench.uncertainty <= bench.goal
    while True:
        if not certain[: len(bench.reference.times)].all():
            reach = float(bench.reference.times[max(int(np.argmin(certain)) - 1, 0)])
        else:
            start = _start(bench, family)
            found = cheapest(bench, family, start)
            if found is not None:
                return found, bench
            assert family.finest is not None
            reach = min(bench.measure(family.setting(family.finest)).kept_until, bench.until - SHORTER * wanted)
        if reach <= bench.reference.times[1]:
            raise Unreachable(f"no setting keeps an error of {bench.goal:g} m: round-off alone is larger")
        bench = bench.shortened(reach)


def _start(bench: Bench, family: Family) -> int:
    """Where to begin in a family with error control."""
    tolerance = FIRST * bench.goal / bench.mechanism.system.length
    return family.at_error(1, tolerance / family.tolerance(1))


def _contenders(bench: Bench, base: Setting, first: Outcome) -> list[Outcome]:
    """The cheapest of each family that is near the cheapest of all, fewest evaluations first."""
    found, intervals = [first], len(bench.reference.times) - 1
    for family in list(families(base, _interval(bench)))[1:]:
        budget = CONTENDERS * min(outcome.evaluations for outcome in found)
        start = _start(bench, family) if family.by_error else int(budget / family.fixed_cost(1, intervals))
        outcome = cheapest(bench, family, start, budget)
        found += [outcome] if outcome is not None else []
    found.sort(key=lambda outcome: outcome.evaluations)
    return [outcome for outcome in found if outcome.evaluations <= CONTENDERS * found[0].evaluations]


def _timed(bench: Bench, outcomes: Sequence[Outcome]) -> list[Outcome]:
    """The outcomes with the median of their times, run in turn so that a slow spell of the machine meets all alike;
    fastest first."""
    seconds: list[list[float]] = [[] for _ in outcomes]
    for _ in range(REPETITIONS):
        for own, outcome in zip(seconds, outcomes, strict=True):
            own.append(bench.fresh(outcome.setting, bench.mechanism).seconds)
    timed = [replace(outcome, seconds=median(own)) for outcome, own in zip(outcomes, seconds, strict=True)]
    return sorted(timed, key=lambda outcome: outcome.seconds)


def _own(bench: Bench, settings: Settings) -> Outcome | None:
    """What the scene's own setting does; None where it has none."""
    return None if settings.step is None and settings.tolerance is None else bench.measure(Setting.of(settings))


def _interval(bench: Bench) -> float:
    return float(bench.reference.times[1])
