"""Searches: poses around a pose, what counts as one plane or point, kinks of functions of time before a run."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Searches:
    """Lengths in parts of the mechanism's own unless a unit says otherwise."""

    few_bodies: int = threshold(
        20,
        "bodies",
        "numpy",
        "poses nearby are looked at for so many; the equilibria of more are found by sparse matrices",
        "tens of milliseconds; the quicker",
    )
    many_directions: int = threshold(
        16, "directions", "numpy", "the forms of branches are not set up for more", "their number grows as the square"
    )
    most_starts: int = threshold(40_000, "-", "numpy", "and from so many at most", "minutes")
    found_often: int = threshold(
        8, "-", "numpy", "the search ends when each assembly was found so often", "one alike is missed by e^-8"
    )
    no_motion: float = threshold(
        1e-6,
        "1, length, rad",
        "numpy",
        "a motion that joints allow less is none; nor is a mode that is so slow, or grows so slowly, beside the "
        "fastest",
        "a double zero comes out as √ε",
    )


@dataclass(frozen=True)
class Looks:
    """Changes are parts of what a function ranges over in one window."""

    look_intervals: int = threshold(
        4096, "-", "numpy", "a window is looked at so many times; what is narrower can be missed", "milliseconds"
    )
    no_change: float = threshold(
        4e-4,
        "1",
        "numpy",
        "a narrow feature changes by five times this in an interval, and ends where less changes",
        "a slow sine changes by 2.5e-4 in an interval",
    )
    quiet_stretch: int = threshold(
        8,
        "intervals",
        "numpy",
        "fewer quiet ones part no two features",
        "tests/integrate/test_time_events.py: with 1, a pulse ends at its top",
    )
    edge_decades: int = threshold(
        3,
        "powers of ten",
        "numpy",
        "functions of lengths are looked at for edges from 10^-3 to 10^3 m; functions of angles over a turn",
        "1 mm to 1 km: what moves in a mechanism",
    )
    most_kinks: int = threshold(
        1000,
        "-",
        "numpy",
        "so many kinks of one function count at most; what changes its sign more often in a window is seen well enough",
        "seconds of a run",
    )
