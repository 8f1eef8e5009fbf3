"""The search in a family for the cheapest setting that keeps an error. It uses the method's order and then looks for
coarser settings."""

from __future__ import annotations

from math import inf

from mbproj.dataclass import dataclass
from mbproj.studies.measure.measurement import Measurement
from mbproj.studies.recommend.bench import Bench
from mbproj.studies.recommend.families import Family

#: The relative precision to which a fixed step is found.
RESOLUTION = 0.02
#: The part of the goal that a proposal aims at, and the largest factor in cost from one proposal to the next.
AIM, LEAP = 0.8, 4.0
#: Errors do not fall evenly, so coarser settings than the result are tried. Each costs `PACE` of the one before, down
#: to `BELOW` of the result's cost, while errors stay below `NEAR` times the goal.
BELOW, PACE, NEAR = 0.5, 0.96, 20.0


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
    found: Measurement | None = None
    while not bracket.is_closed(family):
        tried = bench.measure(family.setting(fineness))
        missed = bench.missed(tried)
        affordable = tried.evaluations <= budget or tried.evaluations == inf
        if missed <= 1.0:
            bracket.fine, found = fineness, tried if affordable else found
        elif affordable:
            bracket.coarse = fineness
        else:
            bracket.fine = fineness
            if missed > NEAR:
                return None
        fineness = bracket.inside(_proposed(family, bracket, fineness, missed), family)
    return _coarser_by_chance(bench, family, bracket, found)


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


def _coarser_by_chance(bench: Bench, family: Family, bracket: Bracket, found: Measurement | None) -> Measurement | None:
    """Look for a coarser setting that keeps the goal by chance; return the result `found` otherwise."""
    fineness = bracket.fine if found is not None and bracket.fine is not None else bracket.coarse + 1
    lowest, misses = family.at_cost(fineness, BELOW), 0
    while fineness > max(lowest, 1) and misses < 2:
        fineness = max(min(family.at_cost(fineness, PACE), fineness - 1), 1)
        tried = bench.measure(family.setting(fineness))
        missed = bench.missed(tried)
        if missed <= 1.0:
            found, lowest = tried, family.at_cost(fineness, BELOW)
        misses = misses + 1 if missed > NEAR else 0
    return found
