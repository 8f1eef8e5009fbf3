"""When the energy balance and the momenta are left, or refused, as rows of the velocity projection."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Invariants:
    """Of what the projection keeps beside the joints' rows."""

    row_rests: float = threshold(
        0.25,
        "1",
        "both",
        "with a smaller part of the speed that a step changes, the row is singular",
        "a quarter of a step from rest",
    )
    row_suspicious: float = threshold(
        1e-5,
        "energy exchanged",
        "numpy",
        "where the row gives more a step in the mean, the motion may be wrong",
        "a heavy top at 20 ms: 4e-5, wrong; a crank-rocker at 40 ms: 2e-7, right",
    )
    row_refused: float = threshold(
        0.01,
        "1",
        "both",
        "a correction of a larger part of what a step changes is refused: that is no step's error",
        "3e-3 in a double pendulum with RK4 at 50 ms; 0.15 in a heavy top at 5 ms, which is wrong",
    )
    row_tolerated: float = threshold(
        10.0,
        "tolerance",
        "both",
        "so many tolerances are a step's error: a correction within them is never refused; T within them of W is rest",
        "a quarter car that comes to rest",
    )
