"""How curves are followed, and when a roller no longer fits one."""

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
