"""Passing near a singular pose: what is left out there, and which steps are not believed."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Passages:
    """With c for the violation of a combination of rows at the distance σ from dependence."""

    near_singular: float = threshold(
        0.1,
        "1",
        "numpy",
        "a pose is near a singular one at this part of the largest distance; above it, directions are apart",
        "tests/mechanisms/rank",
    )
    close_to_singular: float = threshold(
        0.05,
        "1",
        "numpy",
        "a step that comes nearer, beside the largest distance, is repeated as two halves",
        "tests/mechanisms/rank",
    )
    apart: float = threshold(
        10.0,
        "1",
        "numpy",
        "positions leave a combination out where σ² < this × c: Newton's method may find the other branch",
        "Kantorovich",
    )
    least_violation: float = threshold(
        1e-12,
        "length, rad",
        "both",
        "velocities leave a combination out where σ³ < c, which is at least this; positions may stay open by it",
        "what projections leave open",
    )
    passing: float = threshold(
        0.01,
        "1",
        "both",
        "a step with a smaller pivot of S may need the check by halves; `check` calls a start at a smaller "
        "distance near a singular pose",
        "tests/mechanisms/rank",
    )
    nearing: float = threshold(
        0.5, "1", "kernel", "and does where the pivot falls below this part within it", "tests/mechanisms/rank"
    )
    agreement: float = threshold(
        0.05, "1", "kernel", "step and halves may differ by this part of the velocity or of the way", "as branch_change"
    )
    agreed_tolerances: float = threshold(
        100.0,
        "tolerances",
        "kernel",
        "and with error control by so many, or the step is made shorter",
        "no case: tests/mechanisms/rank/test_singular_passages.py holds with 1 too",
    )
    shorter: float = threshold(
        0.7, "1", "kernel", "by this factor, so that its stages lie elsewhere", "no power of 1/2"
    )
    most_shorter: int = threshold(8, "-", "kernel", "so many times", "0.7⁸ = 0.06")
    branch_change: float = threshold(
        0.05,
        "1",
        "both",
        "a projection that changes the velocity by more, near a singular pose, has met another branch",
        "branches cross at an angle; truncation errors are far below",
    )
    lost_velocity: float = threshold(
        0.5, "1", "both", "a step is lost whose projection changes the velocity by more, ...", "half of it is error"
    )
    lost_way: float = threshold(
        0.5, "length a step", "both", "... and what it moves in a step by more", "past a dead centre without mass: 100"
    )
    at_rest: float = threshold(
        1e-10,
        "length a step",
        "both",
        "what moves less is at rest, and its direction is round-off",
        "no case: tests/mechanisms/rank/test_singular_passages.py holds with 1e-3 too",
    )
    rest_rate: float = threshold(
        1e-6,
        "1/s",
        "kernel",
        "a mechanism that moves by less than its length times this is at rest",
        "no case: tests/mechanisms/rank/test_singular_passages.py holds with 0.01 too",
    )
    told_part: float = threshold(
        0.1,
        "1",
        "both",
        "a stage of a kinematic run is on its branch where Newton's method corrects less of way and velocity",
        "a fold is met at 1/2; tests/integrate/kinematic",
    )
    told_way: float = threshold(
        1e-3,
        "length",
        "both",
        "or no more than this, away from singular poses: motions begin at rest",
        "no case: tests/integrate/kinematic/test_motions.py begins at rest with 1e-9 too",
    )
    crossed_way: float = threshold(
        1e-4,
        "length",
        "both",
        "the determinant of rows may change its sign in such a step: the motion passes where branches cross",
        "lengths that are off by 1e-8 keep branches so far apart",
    )
    turning_step: float = threshold(
        1e-6,
        "intervals of samples",
        "numpy",
        "a kinematic step that is shorter is at a turning point",
        "no case: tests/integrate/kinematic/test_motions.py turns back with 1e-12 and 0.3 too",
    )
