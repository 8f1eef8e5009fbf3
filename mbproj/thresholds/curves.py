"""How curves are followed, when a roller no longer fits one, and where a rope no longer lies on its sheaves."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Curves:
    """1 - κφ is the part of a curve's length that a point at the distance φ passes over."""

    least_undercut: float = threshold(
        0.05, "1", "numpy", "where 1 - κφ falls below, a roller does not fit its curve", "the row bends by 20 κ there"
    )
    place_turn: float = threshold(
        0.1,
        "rad",
        "numpy",
        "a curve turns by less from one place to the next, and by so much beyond the end of a piece that is held",
        "8 nodes of Gauss: 1e-16",
    )
    overlap: float = threshold(
        1e-6,
        "1",
        "both",
        "two curves that touch overlap elsewhere by this part of the length of the first",
        "a gear of 0.1 m: 0.6 µm",
    )


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
