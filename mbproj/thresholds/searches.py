"""Searches around a pose: which other poses are looked at, and what counts as one plane or one point."""

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
