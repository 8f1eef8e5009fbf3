"""recommend(): the cheapest setting that keeps the error below a goal.

All integrators are tried, with fixed steps and with error control.

The cost is the number of evaluations of the accelerations, including those for the samples. Settings within a quarter
of the fewest evaluations are then timed in turn. All settings close the joints after every step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.errors import ExitCode, MbprojError
from mbproj.integrate.stiff.fast_forces import steps_for_stability
from mbproj.results.views.table import Table, Tabled
from mbproj.scene.read import Scene
from mbproj.scene.records import Settings
from mbproj.studies.measure.certain import why_not
from mbproj.studies.measure.measurement import MEASUREMENT_RECORDS, Measurement
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.reference import reference
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.spans import sampled
from mbproj.studies.measure.timing import time_settings
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.studies.parallel.resumable import resumable
from mbproj.studies.recommend.search import Bench, Family, cheapest, families, with_closed_joints
from mbproj.studies.store import ValueCache

#: Settings with at most this multiple of the fewest evaluations are timed.
CONTENDERS = 1.25
#: The search in a family with error control starts at this tolerance, relative to the error over the mechanism's size.
FIRST = 0.1
#: Implicit integrators are tried where stability alone needs at least this part of the steps of an explicit one.
FOR_STABILITY = 0.5
#: The part of the duration by which the study is shortened at a time where the error cannot be kept to the end.
SHORTER = 0.02
#: Other processes search where the first search took this processor time, s. On the spherical pendulum it takes less,
#: and two processes take longer to start than all searches together.
LONG = 1.0


class Unreachable(MbprojError):
    """The error of a search in which no setting keeps the goal, not even up to the first sample."""

    exit_code = ExitCode.CHECK_FAILED


@dataclass(frozen=True, eq=False)
class Recommendation(Tabled):
    """The cheapest setting found that keeps `goal` (m) at `points`, verified on a fresh run.

    `best` is the measurement of that run. `contenders` are the settings of similar cost, cheapest first; where they
    were timed, their seconds are medians of several runs. `own` is the scene's own setting, or None. All runs end at
    `until` (s). That is before `wanted` where no setting keeps the error longer; `why` then gives the reason, and is ""
    otherwise. The reference is uncertain by `uncertain` (m); `method` and `check` describe its two solutions.
    `settings` are those of the best run. `tried` are all settings that were measured up to `until`.
    """

    goal: float
    points: tuple[str, ...]
    best: Measurement
    contenders: tuple[Measurement, ...]
    own: Measurement | None
    until: float
    wanted: float
    uncertain: float
    method: str
    check: str
    why: str
    settings: Settings
    tried: tuple[Measurement, ...]

    @property
    def setting(self) -> Setting:
        """The recommended setting."""
        return self.best.setting

    @property
    def reached(self) -> bool:
        """Whether the error is kept up to the time that was asked for."""
        return self.until >= self.wanted * (1.0 - 1e-9)

    @property
    def table(self) -> Table:
        """A table with a row for each setting: the best, those of similar cost, and the scene's own. Its column
        `setting` has the options of mbproj run."""
        near = [("near", each) for each in self.contenders[1:]]
        own = [] if self.own is None else [("own", self.own)]
        return Table.of(_row(kind, each) for kind, each in [("best", self.best), *near, *own])

    @property
    def line(self) -> str:
        """A line with the recommended setting."""
        until = "" if self.reached else f" until t = {self.until:.6g} s only: {self.why}"
        return f"{self.setting.command_line()} keeps {self.goal:g} m{until}"

    __repr__ = Tabled.__repr__


def _row(kind: str, of: Measurement) -> dict[str, Any]:
    point = of.worst()
    return {
        "kind": kind,
        "setting": of.setting.command_line(),
        "integrator": of.setting.integrator,
        "step": of.setting.step,
        "tolerance": of.setting.tolerance,
        "error": of.error[point],
        "point": point,
        "time": of.when[point],
        "evaluations": of.evaluations,
        "cpu_seconds": of.seconds,
        "failure": of.failure or "",
    }


def recommend(
    scene: Scene,
    error: float,
    at: Sequence[str] = (),
    until: float | None = None,
    timed: bool = True,
    fresh: bool = False,
    tell: Tell = silent,
    processes: Where = None,
) -> Recommendation:
    """The cheapest setting of `scene` whose error at every sample up to `until` (s; the scene's duration) is at most
    `error` (m) at the markers `at` (all; the bodies' centres where there are none). Without `timed` the fewest
    evaluations decide. The integrators are searched in parallel. What was found is stored: an interrupted search
    resumes, unless `fresh`.

    Raises InputError for an unknown name or a missing duration, Unreachable where no setting keeps the error at all.
    """
    mechanism = Mechanism.to_choose_for(scene)
    columns = mechanism.columns(at)
    times = sampled(scene, until)
    tell("reference", 0, 1)
    truth = reference(mechanism, times)
    kept = ValueCache(["recommend", mechanism.identity, times.tolist(), error, columns], fresh, MEASUREMENT_RECORDS)
    bench = Bench(mechanism, truth, error, columns, kept)
    base = with_closed_joints(Setting.of(scene.settings))
    own = Setting.of(scene.settings) if scene.settings.step or scene.settings.tolerance else None
    first, bench = _cheapest_of_first_family(bench, base, tell)
    contenders, tried = _contenders(bench, base, first, processes, tell)
    usual = [] if own is None else [bench.measure(own)]
    if timed:
        contenders, usual = _timed(bench, contenders, usual, tell)
    settings = mechanism.settings(contenders[0].setting, float(f"{bench.until:.12g}"), float(times[1]))
    return Recommendation(
        goal=error,
        points=tuple(mechanism.points[column] for column in columns),
        best=bench.fresh(contenders[0].setting, Mechanism.of(scene)).timed(contenders[0].seconds),
        contenders=tuple(contenders),
        own=usual[0] if usual else None,
        until=bench.until,
        wanted=float(times[-1]),
        uncertain=float(bench.uncertainty[-1]),
        method=truth.method,
        check=truth.check,
        why=why_not(mechanism, truth, error, bench.until, tell) if bench.until < times[-1] else "",
        settings=settings,
        tried=(*bench.measurements, *tried),
    )


def _cheapest_of_first_family(bench: Bench, base: Setting, tell: Tell) -> tuple[Measurement, Bench]:
    """The cheapest setting of the first family, which reaches the smallest errors. The bench is shortened where the
    motion is chaotic, or the goal near round-off."""
    wanted, whole, family = bench.until, bench.reference, next(families(base, _interval(bench)))
    tell("the first integrator", 0, 1)
    certain = bench.uncertainty <= bench.goal
    while True:
        if not certain[: len(bench.reference.times)].all():
            reach = float(bench.reference.times[max(int(np.argmin(certain)) - 1, 0)])
        else:
            start = _start_fineness(bench, family)
            best = cheapest(bench, family, start)
            if best is not None:
                return best, bench
            assert family.finest is not None
            finest = bench.measure(family.setting(family.finest))
            if bench.by_energy and finest.doubt > 1.0 and finest.at() <= bench.goal:  # no step improves the balance
                bench = replace(bench, by_energy=False)
                continue
            reach = min(bench.kept_until(family.setting(family.finest)), bench.until - SHORTER * wanted)
        if reach <= bench.reference.times[1]:
            why = why_not(bench.mechanism, whole, bench.goal, reach, tell)
            raise Unreachable(f"no setting keeps the error below {bench.goal:g} m: {why}")
        bench = bench.shortened(reach)


def _start_fineness(bench: Bench, family: Family) -> int:
    """The fineness at which the search in a family with error control starts."""
    tolerance = FIRST * bench.goal / bench.mechanism.system.length
    return family.at_error(1, tolerance / family.tolerance(1))


def _contenders(
    bench: Bench, base: Setting, first: Measurement, processes: Where, tell: Tell
) -> tuple[list[Measurement], list[Measurement]]:
    """The cheapest setting of each family, where its cost is near the least of all, fewest evaluations first; then all
    that was measured of the families after the first. Each of them is searched on its own, up to the first one's cost.
    """
    budget, end = CONTENDERS * first.evaluations, f"--duration {bench.until!r} up to {first.evaluations}"
    others = list(families(base, _interval(bench), stiff=_limited_by_stability(bench, first)))[1:]
    items = {f"{each.setting(1).command_line()} {end}, {bench.by_energy}": each for each in others}
    shared = replace(bench, kept=ValueCache()), budget
    is_long = sum(each.seconds for each in bench.measurements) > LONG
    where = 1 if processes is None and not is_long else processes
    searched = resumable(_searched, shared, items, bench.kept, where, "integrators", tell).values()
    contenders, tried = ([each for pair in searched for each in pair[part]] for part in (0, 1))
    contenders = [first, *contenders]
    contenders += _with_energy_row(bench, base, min(contenders, key=lambda one: one.evaluations))
    contenders.sort(key=lambda one: one.evaluations)
    return [one for one in contenders if one.evaluations <= CONTENDERS * contenders[0].evaluations], tried


def _searched(shared: tuple[Bench, float], family: Family) -> tuple[list[Measurement], list[Measurement]]:
    """The cheapest setting of a family within a budget of evaluations, if there is one, and all that was measured."""
    bench, budget, intervals = replace(shared[0], kept=ValueCache()), shared[1], len(shared[0].reference.times) - 1
    start = _start_fineness(bench, family) if family.by_error else int(budget / family.fixed_cost(1, intervals))
    best = cheapest(bench, family, start, budget)
    return [] if best is None else [best], bench.measurements


def _with_energy_row(bench: Bench, base: Setting, best: Measurement) -> list[Measurement]:
    """The cheapest setting in the family of the best one with the energy balance as a row of the projection, where it
    costs less. Each contact event would begin a new balance, so mechanisms with contacts have none."""
    if base.energy_row or bench.mechanism.system.has_contacts:
        return []
    setting = best.setting
    family = Family(replace(base, energy_row=True), setting.integrator, setting.step is None, _interval(bench))
    start = round(_interval(bench) / setting.step) if setting.step else _start_fineness(bench, family)
    tried = cheapest(bench, family, start, best.evaluations - 1)
    return [] if tried is None else [tried]


def _limited_by_stability(bench: Bench, first: Measurement) -> bool:
    """Whether stability, not accuracy, decides the steps of the first family."""
    settings = bench.mechanism.settings(first.setting, bench.until, _interval(bench))
    needed = steps_for_stability(bench.mechanism.system, bench.mechanism.state, settings)
    return needed >= FOR_STABILITY * first.counters["steps"]


def _timed(
    bench: Bench, contenders: Sequence[Measurement], usual: Sequence[Measurement], tell: Tell
) -> tuple[list[Measurement], list[Measurement]]:
    """Return both lists with median times of runs with all samples; the contenders sorted, fastest first."""
    measurements = [*contenders, *usual]
    settings = [one.setting for one in measurements]
    timings = time_settings(bench.mechanism, settings, bench.reference.times, tell=tell)
    timed = [one.timed(timing.median) for one, timing in zip(measurements, timings, strict=True)]
    return sorted(timed[: len(contenders)], key=lambda one: one.seconds), timed[len(contenders) :]


def _interval(bench: Bench) -> float:
    return float(bench.reference.times[1])
