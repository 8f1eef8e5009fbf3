"""Searches around a pose: which other poses are looked at, and what counts as one plane or one point."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Searches:
    """Lengths in parts of the mechanism's own unless a unit says otherwise."""

    nearby_first: float = threshold(0.03, "length, rad", "numpy", "poses nearby are first sought so far away", "chosen")
    nearby_second: float = threshold(0.15, "length, rad", "numpy", "and then so much further", "chosen")
    nearby_closed: float = threshold(
        1e-13, "length, rad", "numpy", "poses nearby are closed to this", "far below what makes rows independent"
    )
    few_bodies: int = threshold(20, "bodies", "numpy", "poses nearby are looked at for so many", "tens of milliseconds")
    many_directions: int = threshold(
        16, "directions", "numpy", "the forms of branches are not set up for more", "their number grows as the square"
    )
    most_branch_passes: int = threshold(60, "-", "numpy", "passes of Newton's method to a branch", "chosen")
    first_damping: float = threshold(
        0.01, "residual²", "numpy", "poses from random starts are closed with this damping at first", "chosen"
    )
    least_damping: float = threshold(1e-12, "residual²", "numpy", "and with no less", "chosen")
    lost_damping: float = threshold(1e8, "residual²", "numpy", "one that needs more is given up", "chosen")
    most_closing: int = threshold(80, "-", "numpy", "or one that needs so many steps", "most need 10 to 30")
    fewest_starts: int = threshold(
        400, "-", "numpy", "assemblies are looked for from so many starts at least", "one in 100 is missed by e^-4"
    )
    most_starts: int = threshold(40_000, "-", "numpy", "and from so many at most", "minutes")
    found_often: int = threshold(
        8, "-", "numpy", "the search ends when each assembly was found so often", "one alike is missed by e^-8"
    )
    same_assembly: float = threshold(
        1e-5, "length, rad", "numpy", "poses that differ by less are one assembly", "√ε is left at a double root"
    )
    locked_step: float = threshold(
        0.05, "length, rad", "numpy", "motions are followed to a lock-up in steps of this", "chosen"
    )
    locked_steps: int = threshold(200, "-", "numpy", "of which there are so many at most", "seconds")
    locked_far: float = threshold(
        0.2, "length, rad", "numpy", "a motion that makes more in one of them jumps", "4 × locked_step"
    )
    locked_bodies: int = threshold(40, "bodies", "numpy", "a lock-up of more is not looked for", "minutes")
    lost_mass: float = threshold(
        1e-3, "1", "numpy", "a motion whose inertia falls to this part has lost it", "speeds grow 30-fold"
    )
    lost_mass_steps: int = threshold(
        40, "-", "numpy", "where it loses it is looked for in so many steps, of locked_step / 5 or more", "seconds"
    )
    locked_closed: float = threshold(1e-12, "length, rad", "numpy", "what closes is closed to this", "chosen")
    locked_open: float = threshold(
        1e-5, "length, rad", "numpy", "what is open by more cannot be closed", "it misses by what the motions moved"
    )
    one_direction: float = threshold(1e-9, "rad", "numpy", "directions with a smaller sine are one", "chosen")
    in_plane: float = threshold(
        1e-12,
        "1",
        "numpy",
        "vectors are parallel or normal, and depths equal, up to this",
        "typed numbers have 15 digits",
    )
    far_apart: float = threshold(
        0.1, "1", "numpy", "directions with a larger sine are far from dependent, at any length", "√0.01, chosen"
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
        "of more bodies, rows are factored as sparse matrices",
        "equal times, SciPy's import with it",
    )
    free_shift: float = threshold(
        1e-13,
        "1",
        "numpy",
        "rows of a large piece that resist by less, squared, do not hold it",
        "450 ε: no digits left",
    )
    one_point: float = threshold(1e-14, "m", "numpy", "points that are nearer, over 1 m + their size, are one", "45 ε")
    no_normal: float = threshold(
        1e-3,
        "rad",
        "numpy",
        "vectors with a smaller sine do not give the normal of a plane",
        "it would lose three digits",
    )
    no_normal_part: float = threshold(
        1e-9, "1", "numpy", "a smaller part of a unit vector, normal to an axis, is none", "as one_direction"
    )
    half_turn: float = threshold(
        1e-12, "1", "numpy", "a cosine that is nearer to -1 is a half turn", "its axis has lost half of the digits"
    )
    no_motion: float = threshold(
        1e-6, "length, rad", "numpy", "a direction of which joints allow less leads to no pose nearby", "chosen"
    )
    starts_inside: float = threshold(
        1e-9, "length, rad", "numpy", "a start that is less beyond a stop touches it", "round-off of typed numbers"
    )
