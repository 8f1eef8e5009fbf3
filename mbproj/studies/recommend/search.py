"""The search in a family of settings for the cheapest one that keeps the error below a goal.

A family is an integrator with fixed steps or error control, whose fineness is one whole number.

The search uses the method's order and then looks for coarser settings. A bench measures each setting once.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import field, replace
from math import inf, log10

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.integrate.steppers.tableau import tableau_of
from mbproj.registry import (
    AUTOMATIC,
    PROJECTIONS,
    explicit_integrators,
    implicit_integrators,
    integrators,
    with_fixed_steps,
)
from mbproj.studies.measure.measurement import Measurement, measured
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.reference import Reference, error
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import solve
from mbproj.studies.store import ValueCache

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
    `kept` stores all measurements. With `by_energy`, a run whose energy `mbproj run` would warn of misses the goal."""

    mechanism: Mechanism
    reference: Reference
    goal: float
    columns: tuple[int, ...]
    kept: ValueCache = field(default_factory=ValueCache)
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
        kept, whole = self.reference.times <= until * (1.0 + 1e-9), self.reference
        arrays = {name: getattr(whole, name)[kept] for name in ("times", "position", "velocity", "uncertainty")}
        return replace(self, reference=replace(whole, **arrays))

    @property
    def points(self) -> tuple[str, ...]:
        """The names of the points whose error counts."""
        return tuple(self.reference.points[column] for column in self.columns)

    def measure(self, setting: Setting) -> Measurement:
        """Measure a setting at these points, unless its measurement is stored."""
        key = f"{setting.command_line()}{self._end}"
        if key not in self.kept:
            self.kept.add(key, self.fresh(setting, self.mechanism))
        measurement: Measurement = self.kept[key]
        return measurement

    @property
    def measurements(self) -> list[Measurement]:
        """All measurements up to the end of the runs."""
        return [each for key, each in self.kept.items() if key.endswith(self._end)]

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
