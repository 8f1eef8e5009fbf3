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
        "a row at a smaller distance from the span of the others depends on them; right-hand sides agree to this; "
        "no start is made",
        "√ε, with room",
    )
    smallest_pivot: float = threshold(
        1e-13, "1", "kernel", "a smaller pivot of S, as a part of its diagonal entry, has no digits left", "450 ε"
    )
    near_dependent: float = threshold(
        1e-8,
        "1",
        "kernel",
        "a row at a smaller squared distance is left out at this pose: round-off leaves ε over "
        "the square of the others' distance",
        "√ε",
    )
    near_branch: float = threshold(
        0.05,
        "1",
        "both",
        "a pose with a smaller squared distance, beside the usual one, is looked at closely",
        "tests/mechanisms/rank",
    )
    choice_from: float = threshold(
        0.6, "1", "kernel", "the rows to hold are looked for from this squared distance on", "as tied"
    )
    choice_step: float = threshold(
        0.5,
        "1",
        "kernel",
        "and then at this part of the last one, so that those held are no better than need be",
        "chosen",
    )
    choice_to: float = threshold(
        1e-14,
        "1",
        "kernel",
        "down to this squared distance; below it, more rows are dependent than are redundant",
        "100 ε / 2",
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
        "kernel",
        "rows with this part of the largest pivot are equals: the first is held",
        "no power of 1/2, which symmetric mechanisms have",
    )
    most_dense_rows: int = threshold(
        1000, "-", "kernel", "the dense QR factor of more rows would take longer than anybody waits", "O(rows³)"
    )
    most_walked: int = threshold(32, "-", "numpy", "poses of such a walk", "6 rad: a turn of a crank")
    fewest_walked: int = threshold(4, "-", "numpy", "poses of such a walk of a large mechanism", "chosen")
    walked_bodies: int = threshold(
        2000, "-", "numpy", "bodies times poses of such a walk, between these", "as long as reading such a scene"
    )
    seldom: float = threshold(
        0.1, "1", "numpy", "the usual rows are judged by poses of the walk of which so many are worse", "chosen"
    )
    serve_alike: float = threshold(
        0.5, "1", "numpy", "rows whose pivots have this part of the best ones' are equals: the first are held", "chosen"
    )
    no_part: float = threshold(
        1e-8, "1", "both", "a smaller part of a reaction that depends on the choice of rows is none", "√ε"
    )
