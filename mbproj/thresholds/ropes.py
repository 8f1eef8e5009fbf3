"""Where a rope no longer lies on its sheaves as the path says."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Ropes:
    """What ends a run with a rope, and what a path at the scene's pose may be."""

    wrong_side: float = threshold(
        5.5,
        "rad",
        "numpy",
        "a wrap of more, without whole turns, is on the wrong side",
        "315 deg: a straight rope beside it",
    )
    fleet_angle: float = threshold(
        0.0873, "rad", "numpy", "a rope leans out of the plane of its sheaves by no more", "5 deg, as winches allow"
    )
    drawn_in: float = threshold(
        0.02,
        "1",
        "numpy",
        "where a run cannot go on, a span shorter than this part of its radii is why",
        "measured: a bob that is drawn into its wheel ends 1e-6 to 5e-3 radii before",
    )
    least_span: float = threshold(
        1e-3, "1", "numpy", "a span shorter than this part of the radii is none", "the row bends by 1/λ"
    )
