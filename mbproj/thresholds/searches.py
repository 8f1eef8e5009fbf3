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
    lost_damping: float = threshold(1e8, "residual²", "numpy", "one that needs more is given up", "chosen")
    fewest_starts: int = threshold(
        400, "-", "numpy", "assemblies are looked for from so many starts at least", "one in 100 is missed by e^-4"
    )
    most_starts: int = threshold(40_000, "-", "numpy", "and from so many at most", "minutes")
    found_often: int = threshold(
        8, "-", "numpy", "the search ends when each assembly was found so often", "one alike is missed by e^-8"
    )
    locked_steps: int = threshold(200, "-", "numpy", "of which there are so many at most", "seconds")
    lost_mass: float = threshold(
        1e-3, "1", "numpy", "a motion whose inertia falls to this part has lost it", "speeds grow 30-fold"
    )
    lost_mass_steps: int = threshold(
        40, "-", "numpy", "where it loses it is looked for in so many steps, of short_way / 5 or more", "seconds"
    )
    locked_open: float = threshold(
        1e-5, "length, rad", "numpy", "what is open by more cannot be closed", "it misses by what the motions moved"
    )
    one_direction: float = threshold(
        1e-9, "rad", "numpy", "directions with a smaller sine are one", "typed directions have 10 digits"
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
    no_normal: float = threshold(
        1e-3,
        "rad",
        "numpy",
        "vectors with a smaller sine do not give the normal of a plane",
        "it would lose three digits",
    )
    no_motion: float = threshold(
        1e-6, "length, rad", "numpy", "a direction of which joints allow less leads to no pose nearby", "chosen"
    )
