"""recommend(): the cheapest setting that keeps the error below a goal.

All integrators are tried, with fixed steps and with error control.

The cost is the number of evaluations of the accelerations, including those for the samples. Settings within a quarter
of the fewest evaluations are then timed in turn. All settings close the joints after every step.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import field, replace
from math import inf, log10
from pathlib import Path
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import ExitCode, InputError, MbprojError, Place, Problem, placed_at
from mbproj.base.registry import (
    AUTOMATIC,
    PROJECTIONS,
    explicit_integrators,
    implicit_integrators,
    integrators,
    with_fixed_steps,
)
from mbproj.base.settings import HOW, SETTINGS, Settings
from mbproj.motion.steppers.tableau import tableau_of
from mbproj.motion.stiffness import steps_for_stability
from mbproj.results.output_files import SCENE, check_rewritable, write_text
from mbproj.results.views import Table, Tabled
from mbproj.scene.changes import Changes, with_simulation
from mbproj.scene.scene import Scene, read_scene_text
from mbproj.scene.text.document import read_text
from mbproj.studies.measure.measurement import Measurement, measured, time_settings
from mbproj.studies.measure.reference import Reference, error, reference, sampled, why_not
from mbproj.studies.measure.setting import Setting, as_text
from mbproj.studies.measure.solve import Mechanism, solve
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.studies.study import Study

# --- The search in a family of settings for the cheapest one that keeps the error below a goal ------------------------
# A family is an integrator with fixed steps or error control, whose fineness is one whole number.
# The search uses the method's order and then looks for coarser settings. A bench measures each setting once.


#: Exponents of the loosest and the tightest tolerance, and the number of tolerances a decade. Each has two digits.
LOOSEST, TIGHTEST, PER_DECADE = -1, -14, 16
#: The relative precision to which a fixed step is found.
RESOLUTION = 0.02
#: The part of the goal that a proposal aims at, and the largest factor in cost from one proposal to the next.
AIM, LEAP = 0.8, 4.0
#: Errors do not fall evenly, so coarser settings than the result are tried. Each costs `PACE` of the one before, down
#: to `BELOW` of the result's cost, while errors stay below `NEAR` times the goal.
BELOW, PACE, NEAR = 0.5, 0.96, 20.0


@dataclass(frozen=True)
class Family:
    """Settings that add to `base` an integrator and a fineness from 1 on. With fixed steps the fineness is the number
    of steps in an output step of `interval` s. With error control it selects a tolerance of two digits."""

    base: Setting
    integrator: str
    by_error: bool
    interval: float

    @property
    def finest(self) -> int | None:
        """The largest fineness; None where there is no bound."""
        return PER_DECADE * (LOOSEST - TIGHTEST) + 1 if self.by_error else None

    @property
    def order(self) -> int:
        """The order of the integrator; where a run chooses its integrator itself, the order of the explicit one."""
        return integrators()[with_fixed_steps(self.integrator)].order

    def setting(self, fineness: int) -> Setting:
        """The setting with this fineness."""
        if not self.by_error:
            return replace(self.base, integrator=self.integrator, step=self.interval / fineness, tolerance=None)
        return replace(self.base, integrator=self.integrator, step=None, tolerance=self.tolerance(fineness))

    def tolerance(self, fineness: int) -> float:
        """The tolerance that belongs to a fineness, with error control."""
        return float(f"{10.0 ** (LOOSEST - (fineness - 1) / PER_DECADE):.1e}")

    def at_cost(self, fineness: int, factor: float) -> int:
        """The fineness whose cost is about `factor` times that of the fineness given."""
        return round(fineness + PER_DECADE * self.order * log10(factor) if self.by_error else fineness * factor)

    def at_error(self, fineness: int, factor: float) -> int:
        """The fineness whose error is about `factor` times that of the fineness given."""
        if self.by_error:
            return round(fineness - PER_DECADE * log10(factor))
        return round(fineness * factor ** (-1.0 / self.order))

    def fixed_cost(self, fineness: int, intervals: int) -> int:
        """The number of evaluations of a run with fixed steps over `intervals` output steps."""
        return tableau_of(self.integrator).stages * fineness * intervals + 1


def families(base: Setting, interval: float, *, stiff: bool = False) -> Iterator[Family]:
    """The families of all explicit integrators, first those whose cost grows least with accuracy. Where forces may be
    `stiff`, the families of the implicit ones and of `auto` follow. `base` tells how constraints are enforced."""
    names = explicit_integrators()[::-1]
    yield from (Family(base, name, True, interval) for name in names if integrators()[name].embedded)
    yield from (Family(base, name, False, interval) for name in names)
    if stiff:
        yield from (Family(base, name, True, interval) for name in (*implicit_integrators(), AUTOMATIC))


def with_closed_joints(setting: Setting) -> Setting:
    """Return a setting that closes every joint after every step in the kernel, in the fastest formulation. It is
    `setting`, where its projection does so, or otherwise the default with GPOPM."""
    entry = PROJECTIONS[setting.projection]
    always = setting.every == 1 and setting.threshold is None and setting.project_position and setting.project_velocity
    if entry.corrects and entry.compiled and always:
        return replace(setting, formulation="auto", acceleration="bordered")
    return Setting()


@dataclass(eq=False)
class Bench:
    """A mechanism and its reference. `goal` is the largest error (m) allowed at the points with the numbers `columns`.
    `study` stores all measurements. With `by_energy`, a run whose energy `mbproj run` would warn of misses the goal."""

    mechanism: Mechanism
    reference: Reference
    goal: float
    columns: tuple[int, ...]
    study: Study = field(default_factory=Study)
    by_energy: bool = True

    def missed(self, tried: Measurement) -> float:
        """The error divided by the goal, or the energy's doubt where that is larger; at most 1 where the goal is
        kept."""
        doubt = tried.doubt if self.by_energy and tried.doubt > 1.0 else 0.0
        return max(tried.at() / self.goal, doubt)

    @property
    def until(self) -> float:
        """The end of the runs, s."""
        return float(self.reference.times[-1])

    @property
    def _end(self) -> str:
        return f" --duration {self.until!r}"

    @property
    def uncertainty(self) -> Array:
        """A bound on the reference's error at these points up to each time, (T,) m."""
        worst: Array = self.reference.uncertainty[:, self.columns].max(axis=1)
        return worst

    def shortened(self, until: float) -> Bench:
        """The bench with a reference that ends at an earlier sample time `until`, s."""
        within, whole = self.reference.times <= until * (1.0 + 1e-9), self.reference
        arrays = {name: getattr(whole, name)[within] for name in ("times", "position", "velocity", "uncertainty")}
        return replace(self, reference=replace(whole, **arrays))

    @property
    def points(self) -> tuple[str, ...]:
        """The names of the points whose error counts."""
        return tuple(self.reference.points[column] for column in self.columns)

    def measure(self, setting: Setting) -> Measurement:
        """Measure a setting at these points, unless its measurement is stored."""
        name = f"{setting.command_line()}{self._end}"
        measurement: Measurement = self.study.one(name, lambda: self.fresh(setting, self.mechanism))
        return measurement

    @property
    def measurements(self) -> list[Measurement]:
        """All measurements up to the end of the runs."""
        return [each for name, each in self.study.results.items() if name.endswith(self._end)]

    def fresh(self, setting: Setting, mechanism: Mechanism) -> Measurement:
        """Measure a setting at these points with `mechanism`, of the same scene, whether or not a measurement is
        stored."""
        return measured(solve(mechanism, setting, self.reference.times), self.reference).of(self.points)

    def kept_until(self, setting: Setting) -> float:
        """The last time (s) up to which a run with this setting keeps the goal."""
        distance = error(solve(self.mechanism, setting, self.reference.times), self.reference)
        beyond = np.flatnonzero(distance[:, self.columns].max(axis=1) > self.goal)
        times = self.reference.times
        return float(times[max(beyond[0] - 1, 0)]) if len(beyond) else float(times[-1])


@dataclass
class Bracket:
    """The bounds of the search: `coarse` misses the goal; `fine` keeps it or is beyond the budget, or is None."""

    coarse: int = 0
    fine: int | None = None

    def is_closed(self, family: Family) -> bool:
        """Whether the two bounds are as close to each other as the search needs."""
        if self.fine is None:
            return self.coarse == family.finest
        return self.fine - self.coarse <= (1 if family.by_error else max(1, int(RESOLUTION * self.fine)))

    def inside(self, fineness: int, family: Family) -> int:
        """The fineness between the bounds that is nearest to the given one."""
        fineness = max(fineness, self.coarse + 1)
        highest = self.fine - 1 if self.fine is not None else family.finest
        return max(1, fineness if highest is None else min(fineness, highest))


def cheapest(bench: Bench, family: Family, start: int, budget: float = inf) -> Measurement | None:
    """The measurement of the family's cheapest setting that keeps the goal with at most `budget` evaluations; None
    where there is none."""
    bracket = Bracket(fine=_first_over_budget(bench, family, budget))
    fineness = bracket.inside(start, family)
    best: Measurement | None = None
    while not bracket.is_closed(family):
        tried = bench.measure(family.setting(fineness))
        missed = bench.missed(tried)
        affordable = tried.evaluations <= budget or tried.evaluations == inf
        if missed <= 1.0:
            bracket.fine, best = fineness, tried if affordable else best
        elif affordable:
            bracket.coarse = fineness
        else:
            bracket.fine = fineness
            if missed > NEAR:
                return None
        fineness = bracket.inside(_proposed(family, bracket, fineness, missed), family)
    return _coarser_by_chance(bench, family, bracket, best)


def _first_over_budget(bench: Bench, family: Family, budget: float) -> int | None:
    """The coarsest fixed step that exceeds the budget; None where this is not known in advance."""
    if family.by_error or budget == inf:
        return None
    return int((budget - 1) / (family.fixed_cost(1, len(bench.reference.times) - 1) - 1)) + 1


def _proposed(family: Family, bracket: Bracket, fineness: int, ratio: float) -> int:
    """The fineness at which the goal should be met, given an error of `ratio` times the goal. It is at most a factor
    `LEAP` away in cost. Where it lies outside the bracket, return the middle of the bracket."""
    lowest, highest = (family.at_cost(fineness, cost) for cost in (1.0 / LEAP, LEAP))
    if 0.0 < ratio < inf:
        guess = min(max(family.at_error(fineness, AIM / ratio), lowest), highest)
    else:
        guess = highest if ratio > 1.0 else lowest
    if bracket.fine is not None and not bracket.coarse < guess < bracket.fine:
        return (bracket.coarse + bracket.fine) // 2
    return guess


def _coarser_by_chance(bench: Bench, family: Family, bracket: Bracket, best: Measurement | None) -> Measurement | None:
    """Look for a coarser setting that keeps the goal by chance; return the result `best` otherwise."""
    fineness = bracket.fine if best is not None and bracket.fine is not None else bracket.coarse + 1
    lowest, misses = family.at_cost(fineness, BELOW), 0
    while fineness > max(lowest, 1) and misses < 2:
        fineness = max(min(family.at_cost(fineness, PACE), fineness - 1), 1)
        tried = bench.measure(family.setting(fineness))
        missed = bench.missed(tried)
        if missed <= 1.0:
            best, lowest = tried, family.at_cost(fineness, BELOW)
        misses = misses + 1 if missed > NEAR else 0
    return best


# --- recommend() ------------------------------------------------------------------------------------------------------


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
        scene_row = [] if self.own is None else [("own", self.own)]
        return Table.of(_row(kind, each) for kind, each in [("best", self.best), *near, *scene_row])

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
    truth = reference(mechanism, times, tell=tell)
    what = {**mechanism.identity, "study": "recommend", "times": times.tolist(), "error": error, "columns": columns}
    kind = Measurement | tuple[list[Measurement], list[Measurement]]
    bench = Bench(mechanism, truth, error, columns, Study(what, kind, processes, fresh, tell))
    base = with_closed_joints(Setting.of(scene.settings))
    scene_setting = Setting.of(scene.settings) if scene.settings.step or scene.settings.tolerance else None
    first, bench = _cheapest_of_first_family(bench, base, tell)
    contenders, tried = _contenders(bench, base, first)
    usual = [] if scene_setting is None else [bench.measure(scene_setting)]
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


def _contenders(bench: Bench, base: Setting, first: Measurement) -> tuple[list[Measurement], list[Measurement]]:
    """The cheapest setting of each family, where its cost is near the least of all, fewest evaluations first; then all
    that was measured of the families after the first. Each of them is searched on its own, up to the first one's cost.
    """
    budget, end = CONTENDERS * first.evaluations, f"--duration {bench.until!r} up to {first.evaluations}"
    others = list(families(base, _interval(bench), stiff=_limited_by_stability(bench, first)))[1:]
    items = {f"{each.setting(1).command_line()} {end}, {bench.by_energy}": each for each in others}
    shared = replace(bench, study=Study()), budget
    is_long = sum(each.seconds for each in bench.measurements) > LONG
    where = 1 if bench.study.where is None and not is_long else bench.study.where
    searched = bench.study.each(_searched, shared, items, "integrators", where=where)
    contenders, tried = ([each for pair in searched for each in pair[part]] for part in (0, 1))
    contenders = [first, *contenders]
    contenders += _with_energy_row(bench, base, min(contenders, key=lambda one: one.evaluations))
    contenders.sort(key=lambda one: one.evaluations)
    return [one for one in contenders if one.evaluations <= CONTENDERS * contenders[0].evaluations], tried


def _searched(shared: tuple[Bench, float], family: Family) -> tuple[list[Measurement], list[Measurement]]:
    """The cheapest setting of a family within a budget of evaluations, if there is one, and all that was measured."""
    bench, budget, intervals = replace(shared[0], study=Study()), shared[1], len(shared[0].reference.times) - 1
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


# --- Writing a recommendation into its scene file ---------------------------------------------------------------------
# Only the `simulation` block changes.


def write_back(scene: Scene, settings: Settings) -> Path:
    """Writes `settings`, without the duration, into the scene's file and returns its path. Comments stay. The file is
    replaced in one operation.

    Raises InputError where the scene is no file, its block cannot be changed in place, or it cannot be written.
    """
    path = check_rewritable(scene.path)
    written = read_scene_text(scene.text, str(path)).settings
    place, changes = Place(str(path)), changes_to(written, settings)
    failed = Problem("the simulation block cannot be changed in place", place, f"write by hand: {_by_hand(changes)}")
    try:
        text = with_simulation(scene.text, changes)
        settings_read = read_scene_text(text, str(path)).settings
    except (ValueError, InputError) as error:
        raise InputError(failed) from error
    if Setting.of(settings_read) != Setting.of(settings) or settings_read.output_step != settings.output_step:
        raise InputError(failed)
    if read_text(path) != scene.text:
        raise InputError(Problem("has changed since it was read", place, f"write by hand: {_by_hand(changes)}"))
    mark = "\ufeff" if path.read_bytes().startswith(b"\xef\xbb\xbf") else ""
    with placed_at(place):
        return write_text(path, mark + text, SCENE, force=True, hint="write by hand")


def changes_to(before: Settings, after: Settings) -> Changes:
    """The changes of the `simulation` block, by key."""
    recommended = [entry for entry in SETTINGS.values() if entry.decides == HOW or entry.name == "output_step"]
    differing = [entry for entry in recommended if entry.of(after) != entry.of(before)]
    changes: dict[str, Any] = {entry.key: _text(entry.of(after)) for entry in differing if len(entry.path) == 1}
    if after.projection != before.projection:
        inner = {entry.key: (entry.of(after), entry.usual) for entry in recommended if len(entry.path) == 2}
        projection = {key: None if value == usual else _text(value) for key, (value, usual) in inner.items()}
        changes["projection"] = {**projection, "method": after.projection.method}
    return changes


def _text(value: Any) -> str | None:
    return None if value is None else f"[{as_text(value)}]" if isinstance(value, tuple) else as_text(value)


def _by_hand(changes: Changes) -> str:
    return ", ".join(f"{name}: {value}" for name, value in changes.items() if isinstance(value, str))
