"""The one record of every number that was chosen, not derived: what counts as dependent, closed, near, at rest.

Each has a value, a unit, a reason and a source. NumPy's code reads `THRESHOLDS`; the kernel gets those that it uses as
one struct with each model. `mbproj info --thresholds` prints the table. Numbers that are mathematics stand where they
are used: 4 ε, 2π, the coefficients of a method, and how many rows a message shows.
A source that begins with "no case" names a test that holds with quite another value: such a threshold may go.
"""

from __future__ import annotations

from dataclasses import Field
from functools import cache
from typing import Any, NamedTuple, final

from mbproj.dataclass import dataclass, given_fields
from mbproj.thresholds.contact import Contact, Curves, Ropes
from mbproj.thresholds.entry import threshold
from mbproj.thresholds.poses import Linear, Looks, Passages, Searches
from mbproj.thresholds.solution import Closing, Dependence, Elimination, Invariants
from mbproj.thresholds.steps import Automatic, Steps

__all__ = ["THRESHOLDS", "ThresholdRow", "Thresholds", "of_the_kernel", "table"]


@dataclass(frozen=True)
class Common:
    """The scales of round-off, from a few operations on doubles to what has lost half of its digits."""

    no_digits: float = threshold(
        1e-13,
        "1",
        "both",
        "a smaller part of the largest has no digits left: pivots, moments, masses, changes of an iteration",
        "450 ε; Skeel 1980 of backward errors",
    )
    rounding: float = threshold(
        1e-12,
        "1",
        "both",
        "a smaller part of the largest is round-off of long sums, of numbers that somebody typed, or of a "
        "mechanism at rest",
        "4500 ε; typed numbers have 15 digits",
    )
    same_written: float = threshold(
        1e-9,
        "1, m, rad",
        "both",
        "places, times, directions and poses that differ by less, over 1 or over their size, are the same; so are "
        "slopes",
        "files have 10 digits or more: mechanisms that `mbproj equilibrium` writes and reads again",
    )
    half_digits: float = threshold(
        1e-8,
        "1",
        "both",
        "a smaller part is none where errors enter by their square or as a difference; a curve that turns by less "
        "has no corner",
        "√ε",
    )
    short_way: float = threshold(
        0.05,
        "length, rad",
        "numpy",
        "a pose so far away is another one, of the same branch",
        "far from round-off, near to a joint's turn; tests/integrate/test_lock_up.py",
    )
    long_way: float = threshold(
        0.2,
        "length, rad",
        "numpy",
        "a walk, a sample of poses and a first step to an equilibrium go so far at once",
        "linear models hold for tenths of a radian",
    )
    rounded: float = threshold(
        1e-3,
        "1",
        "both",
        "a smaller part is that of numbers which somebody rounded or measured: no direction, slope, distance or share",
        "a wrist rounded to 0.1 mm: 8e-5",
    )
    most_passes: int = threshold(
        100,
        "-",
        "both",
        "passes of an iteration that ends before by its own test; steps of a search along a motion",
        "3 to 30 are usual; with 300, `branches` of bricard takes 1.5 times as long",
    )


@final
@dataclass(frozen=True)
class Thresholds(
    Common,
    Automatic,
    Linear,
    Contact,
    Looks,
    Searches,
    Steps,
    Invariants,
    Closing,
    Passages,
    Elimination,
    Curves,
    Ropes,
    Dependence,
):
    """All of them, each under its name."""

    def __init__(self, **others: float) -> None:
        """As chosen, but for `others`. A function with each of them as a parameter would take 6 ms to compile."""
        chosen = {name: entry.default for name, entry in _DECLARED.items()}
        unknown = others.keys() - chosen.keys()
        if unknown:
            raise TypeError(f"there is no threshold '{min(unknown)}'")
        vars(self).update(chosen | others)


#: As the groups declare them. `fields` would look at each declaration twice, 5 ms in each process.
_DECLARED: dict[str, Field[Any]] = {
    name: entry for group in reversed(Thresholds.__mro__[:-1]) for name, entry in given_fields(group).items()
}
THRESHOLDS = Thresholds()


class ThresholdRow(NamedTuple):
    """One threshold; `used_by` says whether NumPy's code, the kernel's, or both have it."""

    name: str
    value: float
    unit: str
    used_by: str
    why: str
    source: str


def table() -> list[ThresholdRow]:
    """All thresholds, group by group."""
    return [
        ThresholdRow(
            name,
            getattr(THRESHOLDS, name),
            **{key: entry.metadata[key] for key in ("unit", "used_by", "why", "source")},
        )
        for name, entry in _DECLARED.items()
    ]


def of_the_kernel(thresholds: Thresholds = THRESHOLDS) -> dict[str, Any]:
    """Those that the kernel uses, by name."""
    return {name: getattr(thresholds, name) for name in _kernel_names()}


@cache
def _kernel_names() -> tuple[str, ...]:
    return tuple(row.name for row in table() if row.used_by != "numpy")
