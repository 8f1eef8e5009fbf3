"""What many parts of mbproj share: how small is nothing, how near is the same, how far is another pose."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


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
