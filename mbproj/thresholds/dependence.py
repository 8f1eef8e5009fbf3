"""When rows of C_q depend on each other, and which of them a run holds."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Dependence:
    """Distances are those of a row of unit length from the span of the others; the kernel sees their squares."""

    dependent: float = threshold(
        1e-9,
        "1",
        "numpy",
        "a row at a smaller distance from the span of the others depends on them; no start is made; equations and "
        "forces balance to this",
        "√ε, with room",
    )
    near_branch: float = threshold(
        0.05,
        "1",
        "both",
        "a pose with a smaller squared distance, beside the usual one, is looked at closely",
        "tests/mechanisms/rank",
    )
    decline: float = threshold(
        0.2,
        "1",
        "kernel",
        "the usual rows do not serve where a pivot is below this part of what it usually is",
        "tests/mechanisms/rank: steps past a later pose err",
    )
    tied: float = threshold(
        0.99,
        "1",
        "both",
        "rows with this part of the largest pivot are equals: the first is held; so are choices of rows over a walk",
        "no power of 1/2, which symmetric mechanisms have",
    )
    most_walked: int = threshold(32, "-", "numpy", "poses of such a walk", "6 rad: a turn of a crank")
    walked_bodies: int = threshold(
        2000, "-", "numpy", "bodies times poses of such a walk, between these", "as long as reading such a scene"
    )
    no_part: float = threshold(
        1e-8, "1", "both", "a smaller part of a reaction that depends on the choice of rows is none", "√ε"
    )
