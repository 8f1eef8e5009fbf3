"""What the solution of the equations can bear: masses far apart, bodies with no mass, small pivots."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Elimination:
    """Parts of other masses, moments and pivots."""

    lent_part: float = threshold(
        1e-6,
        "1",
        "both",
        "this part of the mean mass, or moment, is lent to bodies without",
        "quick to settle: an error falls a millionfold each pass",
    )
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
