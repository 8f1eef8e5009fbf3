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
    fewest_starts: int = threshold(
        400, "-", "numpy", "assemblies are looked for from so many starts at least", "one in 100 is missed by e^-4"
    )
    most_starts: int = threshold(40_000, "-", "numpy", "and from so many at most", "minutes")
    found_often: int = threshold(
        8, "-", "numpy", "the search ends when each assembly was found so often", "one alike is missed by e^-8"
    )
    far_arm: float = threshold(
        1e3,
        "length",
        "numpy",
        "with larger arms, the rank of a joint's rows is looked at",
        "leaves 6 digits to dependent",
    )
    dense_bodies: int = threshold(
        50,
        "bodies",
        "numpy",
        "of more bodies, rows are factored as sparse matrices, and lock-ups are not looked for",
        "equal times, SciPy's import with it",
    )
    no_motion: float = threshold(
        1e-6, "length, rad", "numpy", "a direction of which joints allow less leads to no pose nearby", "chosen"
    )
