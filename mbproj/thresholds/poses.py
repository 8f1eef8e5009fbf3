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
        "a pose is near a singular one where its distance from dependence is below this part of the largest; "
        "farther away, the directions of branches differ",
        "tests/mechanisms/rank",
    )
    close_to_singular: float = threshold(
        0.05,
        "1",
        "numpy",
        "a step with a smaller distance, beside the largest, is repeated as two halves",
        "tests/mechanisms/rank",
    )
    apart: float = threshold(
        10.0,
        "1",
        "numpy",
        "positions leave out a combination with σ² < this × c: Newton's method may find the other branch",
        "Kantorovich",
    )
    least_violation: float = threshold(
        1e-12,
        "length, rad",
        "both",
        "corrections of velocities leave out a combination with σ³ < c, where c is at least this; positions "
        "may stay open by it",
        "what projections leave open",
    )
    passing: float = threshold(
        0.01,
        "1",
        "both",
        "a step with a smaller pivot of S may need the check by two halves; `check` calls a start with a "
        "smaller distance near a singular pose",
        "tests/mechanisms/rank",
    )
    nearing: float = threshold(
        0.5,
        "1",
        "kernel",
        "the check by two halves is made where a pivot is below `passing`, and below this part of its largest "
        "value in the step",
        "tests/mechanisms/rank",
    )
    agreement: float = threshold(
        0.05, "1", "kernel", "near a singular pose, a step and its halves may differ by this part", "as branch_change"
    )
    agreed_tolerances: float = threshold(
        100.0,
        "tolerances",
        "kernel",
        "with error control, a step near a singular pose is shortened where it differs from its two halves by more",
        "no case: tests/mechanisms/rank/test_singular_passages.py holds with 1 too",
    )
    shorter: float = threshold(
        0.7,
        "1",
        "kernel",
        "the factor by which a step near a singular pose is shortened, so that its stages lie elsewhere",
        "no power of 1/2",
    )
    most_shorter: int = threshold(
        8, "-", "kernel", "the most shortenings of a step near a singular pose", "0.7⁸ = 0.06"
    )
    branch_change: float = threshold(
        0.05,
        "1",
        "both",
        "near a singular pose, a projection that changes the velocity by more than this part has led to another branch",
        "branches cross at an angle; truncation errors are far below",
    )
    lost_velocity: float = threshold(
        0.5,
        "1",
        "both",
        "a step is lost where its projection changes the velocity by more than this part, and the "
        "displacement by more than `lost_way`",
        "half of it is error",
    )
    lost_way: float = threshold(
        0.5,
        "length a step",
        "both",
        "a step is lost where its projection changes the displacement by more, and the velocity by more than "
        "`lost_velocity`",
        "past a dead centre without mass: 100",
    )
    at_rest: float = threshold(
        1e-10,
        "length a step",
        "both",
        "a change of velocity whose displacement in a step is smaller is round-off of a mechanism at rest",
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
        "kernel",
        "a stage of a kinematic run is on its branch where Newton's method corrects less than this part of "
        "displacement and velocity",
        "a fold is met at 1/2; tests/integrate/test_kinematic.py",
    )
    told_way: float = threshold(
        1e-3,
        "length",
        "kernel",
        "away from singular poses, a stage of a kinematic run is also on its branch where its correction is shorter",
        "no case: tests/integrate/test_kinematic.py begins at rest with 1e-9 too",
    )
    crossed_way: float = threshold(
        1e-4,
        "length",
        "kernel",
        "in a kinematic step no longer than this the determinant of rows may change its sign: branches cross there",
        "lengths that are off by 1e-8 keep branches so far apart",
    )


@dataclass(frozen=True)
class Searches:
    """Searches among poses. Lengths are parts of the mechanism's length, unless a unit says otherwise."""

    few_bodies: int = threshold(
        20,
        "bodies",
        "numpy",
        "poses nearby are examined up to so many bodies; equilibria of more bodies are found by sparse matrices",
        "tens of milliseconds; the quicker",
    )
    many_directions: int = threshold(
        16, "directions", "numpy", "the most directions in the forms of branches", "their number grows as the square"
    )
    most_starts: int = threshold(40_000, "-", "numpy", "the most starts of a search for assemblies", "minutes")
    found_often: int = threshold(
        8, "-", "numpy", "a search for assemblies ends when each was found so often", "one alike is missed by e^-8"
    )
    missed: float = threshold(
        1e-3,
        "1",
        "numpy",
        "the probability to miss an assembly that draws more than the share of starts that `branches` states",
        "usual; with 1e-6 the share is twice as large",
    )
    no_motion: float = threshold(
        1e-6,
        "1, length, rad",
        "numpy",
        "components of allowed motions, and rates of modes beside the fastest one, count as 0 where they are smaller",
        "a double zero comes out as √ε",
    )
    imported_alike: float = threshold(
        1e-6,
        "1",
        "numpy",
        "an imported scene accelerates as its model does in MuJoCo where a smaller part of the largest differs",
        "tests/formats: models agree to 1e-10, chains of 100 bodies to 3e-9; what is left out makes 9e-6 and more",
    )


@dataclass(frozen=True)
class Looks:
    """Searches in functions. Changes are parts of a function's range in one window."""

    look_intervals: int = threshold(
        4096, "-", "numpy", "samples of a function in a window; narrower features can be missed", "milliseconds"
    )
    no_change: float = threshold(
        4e-4,
        "1",
        "numpy",
        "a narrow feature changes by five times this in an interval, and ends where the change is smaller than this",
        "a slow sine changes by 2.5e-4 in an interval",
    )
    quiet_stretch: int = threshold(
        8,
        "intervals",
        "numpy",
        "fewer quiet intervals do not separate two features",
        "tests/integrate/test_events.py: with 1, a pulse ends at its top",
    )
    edge_decades: int = threshold(
        3,
        "powers of ten",
        "numpy",
        "functions of lengths are searched for edges from 10^-3 to 10^3 m; functions of angles over a turn",
        "1 mm to 1 km: what moves in a mechanism",
    )
    most_kinks: int = threshold(
        1000,
        "-",
        "numpy",
        "the most kinks of one function that count; a function that changes its sign more often in a window "
        "is sampled densely enough",
        "seconds of a run",
    )


@dataclass(frozen=True)
class Linear:
    """Equilibria and linear models. Numbers are parts of sums of absolute values, unless a unit says otherwise."""

    most_dense: int = threshold(
        1200,
        "degrees of freedom, rows",
        "both",
        "linear models, steady turns, modes by dense matrices, and dense QR factors of rows have at most this size",
        "O(n³): some minutes",
    )
    good_step: float = threshold(
        0.1, "1", "numpy", "a step to an equilibrium needs this part of the expected work", "usual: 0.1"
    )
    largest_radius: float = threshold(
        1.0,
        "length, rad",
        "numpy",
        "the longest step to an equilibrium",
        "the equilibrium of steered_car.yaml: without it a step that rolls without resistance has 1e8 parts",
    )
    far_away: float = threshold(
        30.0,
        "length",
        "numpy",
        "the search for an equilibrium ends so far from the start, or after such a fall under a constant force",
        "four turns of a shaft",
    )
    proximal: float = threshold(
        1e-10,
        "1",
        "numpy",
        "the compliance of rows of large mechanisms, which iteration removes, and their relative extra stiffness",
        "√ε, with room",
    )
    same_pose: float = threshold(
        1e-5,
        "length, rad",
        "numpy",
        "assemblies or equilibria whose bodies are nearer are one; a mechanism is locked where its pose stays "
        "open by more",
        "far above what balancing leaves",
    )
    stalled: float = threshold(
        0.01,
        "1",
        "numpy",
        "steps to an equilibrium must lower the residual by this part; forces that change by less count as constant",
        "one length of a hundred takes 10 steps",
    )
    most_of_round: int = threshold(20_000, "-", "numpy", "the most instants in a round of controllers", "seconds")
    largest_ratio: int = threshold(
        10_000,
        "-",
        "numpy",
        "the largest denominator of ratios of controllers' periods, and of weights of angles",
        "wheels of 100 teeth in two stages",
    )
