"""Poses: passing near a singular one, searches around one, and equilibria, modes and linear models at one."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Passages:
    """Passages near singular poses. σ is the distance of a combination of rows from dependence, c its violation."""

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


@dataclass(frozen=True)
class Searches:
    """Searches among poses. Lengths are parts of the mechanism's length, unless a unit says otherwise."""

    few_bodies: int = threshold(
        20,
        "bodies",
        "numpy",
        "poses nearby are looked at for so many; the equilibria of more are found by sparse matrices",
        "tens of milliseconds; the quicker",
    )
    many_directions: int = threshold(
        16, "directions", "numpy", "the forms of branches are not set up for more", "their number grows as the square"
    )
    most_starts: int = threshold(40_000, "-", "numpy", "and from so many at most", "minutes")
    found_often: int = threshold(
        8, "-", "numpy", "the search ends when each assembly was found so often", "one alike is missed by e^-8"
    )
    no_motion: float = threshold(
        1e-6,
        "1, length, rad",
        "numpy",
        "a motion that joints allow less is none; nor is a mode that is so slow, or grows so slowly, beside the "
        "fastest",
        "a double zero comes out as √ε",
    )


@dataclass(frozen=True)
class Looks:
    """Searches in functions. Changes are parts of a function's range in one window."""

    look_intervals: int = threshold(
        4096, "-", "numpy", "a window is looked at so many times; what is narrower can be missed", "milliseconds"
    )
    no_change: float = threshold(
        4e-4,
        "1",
        "numpy",
        "a narrow feature changes by five times this in an interval, and ends where less changes",
        "a slow sine changes by 2.5e-4 in an interval",
    )
    quiet_stretch: int = threshold(
        8,
        "intervals",
        "numpy",
        "fewer quiet ones part no two features",
        "tests/integrate/test_time_events.py: with 1, a pulse ends at its top",
    )
    edge_decades: int = threshold(
        3,
        "powers of ten",
        "numpy",
        "functions of lengths are looked at for edges from 10^-3 to 10^3 m; functions of angles over a turn",
        "1 mm to 1 km: what moves in a mechanism",
    )
    most_kinks: int = threshold(
        1000,
        "-",
        "numpy",
        "so many kinks of one function count at most; what changes its sign more often in a window is seen well enough",
        "seconds of a run",
    )


@dataclass(frozen=True)
class Linear:
    """Equilibria and linear models. Numbers are parts of sums of absolute values, unless a unit says otherwise."""

    most_dense: int = threshold(
        1200,
        "degrees of freedom, rows",
        "both",
        "linear models, steady turns, modes that need dense matrices have no more; nor has a dense QR factor of rows",
        "O(n³): some minutes",
    )
    good_step: float = threshold(
        0.1, "1", "numpy", "a step is taken where the forces do so much of the work that was expected", "usual: 0.1"
    )
    largest_radius: float = threshold(
        1.0,
        "length, rad",
        "numpy",
        "no step to a balance is longer",
        "the equilibrium of steered_car.yaml: without it a step that rolls without resistance has 1e8 parts",
    )
    far_away: float = threshold(
        30.0,
        "length",
        "numpy",
        "what has no equilibrium so far from the start, or falls so far by a force that does not change, has none",
        "four turns of a shaft",
    )
    proximal: float = threshold(
        1e-10,
        "1",
        "numpy",
        "rows of large mechanisms give way by so much, which is taken out again; their stiffness is raised by so much",
        "√ε, with room",
    )
    same_pose: float = threshold(
        1e-5,
        "length, rad",
        "numpy",
        "assemblies or equilibria whose bodies are nearer are one; a pose that is open by more is locked",
        "far above what balancing leaves",
    )
    stalled: float = threshold(
        0.01,
        "1",
        "numpy",
        "steps have to lower what is left by so much of it; a force that changes by less is the same",
        "one length of a hundred takes 10 steps",
    )
    most_of_round: int = threshold(20_000, "-", "numpy", "a round of controllers has no more instants", "seconds")
    largest_ratio: int = threshold(
        10_000,
        "-",
        "numpy",
        "ratios of periods of controllers, and of weights of angles, are fractions of numbers up to so many",
        "wheels of 100 teeth in two stages",
    )
