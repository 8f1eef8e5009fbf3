"""What the solution of the equations can bear: masses far apart, bodies with no mass, small pivots."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Elimination:
    """Parts of other masses, moments and pivots."""

    no_inertia: float = threshold(
        1e-14, "1", "both", "a principal moment below this part of the body's largest is none", "45 ε"
    )
    no_mass: float = threshold(1e-15, "1", "kernel", "a mass below this part of the heaviest body's is none", "5 ε")
    asymmetry: float = threshold(
        1e-12, "1", "kernel", "an inertia that is less symmetric is refused", "chosen: a guard"
    )
    most_cancelled: float = threshold(
        1e8, "1", "kernel", "a leaf with so many times its parent's inertia is not eliminated", "half of the digits"
    )
    parallel: float = threshold(1e-20, "1", "kernel", "vectors with a smaller squared sine are parallel", "chosen")
    lent_part: float = threshold(
        1e-6,
        "1",
        "kernel",
        "this part of the mean mass is lent to bodies without mass",
        "quick to settle: an error falls a millionfold each pass",
    )
    most_settling: int = threshold(100, "-", "kernel", "passes in which lent masses are taken back", "chosen")
    settled_part: float = threshold(
        1e-28, "1", "kernel", "they are taken back where the square of the change is below this", "1e-14²"
    )
    settled_enough: float = threshold(
        1e-16, "1", "kernel", "or below this, where round-off lets it fall no further", "1e-8²"
    )
    ill_conditioned: float = threshold(
        1e-4, "1", "kernel", "a smaller pivot of S asks for refinement: S squares the condition", "12 digits left"
    )
    refined_part: float = threshold(
        1e-13, "1", "both", "refinement ends when it changes λ by less than this part", "450 ε"
    )
    most_refining: int = threshold(8, "-", "both", "passes of refinement", "measured: 3 are enough")
    fewest_shared: int = threshold(
        6,
        "-",
        "kernel",
        "joints of the loops that share a shaft take it apart",
        "the band holds half of the full block's numbers",
    )
    fewest_passed: int = threshold(
        4,
        "-",
        "kernel",
        "a body between two joints moves by that which takes so many freedoms",
        "instructions of ladders: a quarter less with 4 and 5, 4 % more with 2",
    )
