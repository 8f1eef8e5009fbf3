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
    choice_from: float = threshold(
        0.6,
        "1",
        "kernel",
        "the rows to hold are looked for from this squared distance on, and then from halves of it",
        "no power of 1/2; with 0.99 locomotive.yaml, continued, holds other rows at some poses",
    )
    tied: float = threshold(
        0.99,
        "1",
        "kernel",
        "rows with this part of the largest pivot are equals: the first is held",
        "no power of 1/2, which symmetric mechanisms have",
    )
    most_walked: int = threshold(32, "-", "numpy", "poses of such a walk", "6 rad: a turn of a crank")
    walked_bodies: int = threshold(
        2000, "-", "numpy", "bodies times poses of such a walk, between these", "as long as reading such a scene"
    )
    seldom: float = threshold(
        0.1,
        "1",
        "numpy",
        "the usual rows are judged by poses of the walk of which so many are worse",
        "bricard.yaml: judged by the median, runs that start at other poses of its motion hold other rows",
    )
    serve_alike: float = threshold(
        0.5,
        "1",
        "numpy",
        "rows whose pivots have this part of the best ones' are equals: the first are held",
        "bricard.yaml, as above: with 0.99 it is round-off that chooses",
    )
    no_part: float = threshold(
        1e-8, "1", "both", "a smaller part of a reaction that depends on the choice of rows is none", "√ε"
    )
