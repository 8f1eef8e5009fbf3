"""The cheapest setting of a family that keeps an error: by the method's order, and with a look beyond the result."""

from __future__ import annotations

from math import inf

from mbproj.dataclass import dataclass
from mbproj.studies.measure.measurement import Measurement
from mbproj.studies.recommend.bench import Bench
from mbproj.studies.recommend.families import Family

#: A fixed step is found to this part.
RESOLUTION = 0.02
#: The part of the goal that a proposal aims at, and at most so much finer or coarser in one go, in cost.
AIM, LEAP = 0.8, 4.0
#: Errors do not fall evenly. Beyond the result, down to this part of its cost, each pace this part of the last,
#: settings are tried as long as errors are at most so many times the goal.
BELOW, PACE, NEAR = 0.5, 0.96, 20.0


@dataclass
class Bracket:
    """What is known of a family's fineness: this one is too coarse, and one finer than `fine` is not wanted: it either
    keeps the goal, or is beyond the budget."""

    coarse: int = 0
    fine: int | None = None

    def is_closed(self, family: Family) -> bool:
        """Whether the two are as near to each other as is asked for."""
        if self.fine is None:
            return self.coarse == family.finest
        return self.fine - self.coarse <= (1 if family.by_error else max(1, int(RESOLUTION * self.fine)))

    def inside(self, fineness: int, family: Family) -> int:
        """The nearest fineness that is open."""
        fineness = max(fineness, self.coarse + 1)
        highest = self.fine - 1 if self.fine is not None else family.finest
        return max(1, fineness if highest is None else min(fineness, highest))


def cheapest(bench: Bench, family: Family, start: int, budget: float = inf) -> Measurement | None:
    """The cheapest of the family, measured, that keeps the goal for at most `budget` evaluations; None without one."""
    bracket = Bracket(fine=_first_beyond(bench, family, budget))
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
    return _beyond(bench, family, bracket, found)


def _first_beyond(bench: Bench, family: Family, budget: float) -> int | None:
    """The coarsest fixed step that is beyond the budget; None where that is to be found out."""
    if family.by_error or budget == inf:
        return None
    return int((budget - 1) / (family.fixed_cost(1, len(bench.reference.times) - 1) - 1)) + 1


def _proposed(family: Family, bracket: Bracket, fineness: int, ratio: float) -> int:
    """Where the goal should be met, from an error `ratio` times the goal; in the middle of what is left where that
    lands outside, and not farther than a leap."""
    lowest, highest = (family.at_cost(fineness, cost) for cost in (1.0 / LEAP, LEAP))
    if 0.0 < ratio < inf:
        guess = min(max(family.at_error(fineness, AIM / ratio), lowest), highest)
    else:
        guess = highest if ratio > 1.0 else lowest
    if bracket.fine is not None and not bracket.coarse < guess < bracket.fine:
        return (bracket.coarse + bracket.fine) // 2
    return guess


def _beyond(bench: Bench, family: Family, bracket: Bracket, found: Measurement | None) -> Measurement | None:
    """What is found, or something coarser that keeps the goal by chance."""
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
