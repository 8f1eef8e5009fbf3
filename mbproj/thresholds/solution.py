"""The solution of the joints' equations: when joints count as closed, and when rows depend on each other.

Also limits of masses and pivots, and of the rows of energy and momenta.
"""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Closing:
    """Closed joints. Lengths are in m, or in units of the mechanism's length where that is below 1 m."""

    closed_to: float = threshold(
        1e-13,
        "m, rad",
        "both",
        "the smallest default tolerance of the violation test; poses nearby are closed to it",
        "450 ε",
    )
    closed_grains: float = threshold(
        4.0,
        "ε",
        "both",
        "a row that is open by at most so many ε of its coordinates is closed to round-off; also the distance "
        "in time of the two sides of a kink",
        "sums of 4 numbers",
    )
    paper_tolerance: float = threshold(
        1e-12, "kg m²", "both", "the default of the paper's test ΔqᵀMΔq", "paper, sect. 5"
    )
    round_off_grains: float = threshold(
        64.0,
        "ε",
        "both",
        "a violation below so many ε of a row's coordinates, or an energy below so many ε of its terms, may "
        "be round-off; events nearer in ε of time are one",
        "tests/projection/test_methods.py: with 1, projections do not end at round-off",
    )
    slow: float = threshold(
        0.1, "1", "kernel", "a pass that leaves a larger part of the violation needs a new factor", "simplified Newton"
    )
    widest_turn: float = threshold(
        0.5,
        "rad",
        "both",
        "no correction turns a body by more; in a part of a short move no motion changes by more",
        "Conn, Gould & Toint 2000, sect. 7; 16 turns in 2 ms: parts of 6.6 rad do not close in full",
    )
    tighter: float = threshold(
        0.25,
        "1",
        "both",
        "from one trial correction to the next the limit of turns is multiplied by this",
        "tests/projection/test_hard_to_close.py: uneven chains do not close in 12 passes with 0.5 and `stiffer` 10",
    )
    stiffer: float = threshold(
        100.0,
        "1",
        "both",
        "the moment of inertia of a body that turns too far is multiplied by this, times turn / limit",
        "tests/projection/test_hard_to_close.py: uneven chains do not close in 12 passes with 10 and `tighter` 0.5",
    )
    open_limit: float = threshold(
        1e-6,
        "length, rad",
        "both",
        "a run ends where a failed projection leaves a larger violation",
        "no case: tests/projection/test_hard_to_close.py holds with 1e-12 too",
    )
    lost_limit: float = threshold(
        1.0, "length, rad", "both", "a run ends at a larger violation", "the mechanism itself"
    )
    assembled: float = threshold(
        1e-10,
        "length, rad",
        "numpy",
        "a pose with a smaller violation counts as assembled",
        "poses of tests/dynamics/test_assembly.py close to 1e-15",
    )
    large: int = threshold(
        100,
        "bodies",
        "numpy",
        "above this number of bodies, assembly, diagnosis, modes and planar reduction make no dense factors",
        "singular values of the rows of 100 bodies: 0.1 s, of 500: 16 s",
    )


@dataclass(frozen=True)
class Dependence:
    """Distances are those of a row of unit length from the span of the others; the kernel sees their squares."""

    dependent: float = threshold(
        1e-9,
        "1",
        "numpy",
        "a row at a smaller distance from the span of the others depends on them, and a run with such rows "
        "does not start; equations and forces balance to this part",
        "√ε, with room",
    )
    in_doubt: float = threshold(
        1e-6,
        "1",
        "numpy",
        "rows nearer to the span of the others, but beyond round-off, depend on them where they stay so near and "
        "closed, to `dependent`, in motions that do not hold them",
        "a four-bar with an axis that is tilted by 5e-8 rad moves, with one tilted by 1e-7 it locks",
    )
    near_branch: float = threshold(
        0.05,
        "1",
        "both",
        "a pose with a smaller squared distance of a row, beside the usual one, may be near a singular one",
        "tests/mechanisms/rank",
    )
    decline: float = threshold(
        0.2,
        "1",
        "kernel",
        "the usual rows are replaced where a pivot is below this part of its usual value",
        "tests/mechanisms/rank: steps past a later pose err",
    )
    choice_from: float = threshold(
        0.6,
        "1",
        "kernel",
        "the search for the rows to hold begins with this least squared distance, and halves it from trial to trial",
        "no power of 1/2; with 0.99 locomotive.yaml, continued, holds other rows at some poses",
    )
    tied: float = threshold(
        0.99,
        "1",
        "both",
        "rows with at least this part of the largest pivot are equal: the first of them is held",
        "no power of 1/2, which symmetric mechanisms have",
    )
    most_walked: int = threshold(
        32, "-", "numpy", "the most poses of the walk for the usual rows", "6 rad: a turn of a crank"
    )
    walked_bodies: int = threshold(
        2000, "-", "numpy", "the most bodies × poses in the walk for the usual rows", "as long as reading such a scene"
    )
    seldom: float = threshold(
        0.1,
        "1",
        "numpy",
        "rows are judged by this quantile of their pivots over the poses of the walk",
        "bricard.yaml: judged by the median, four times as many steps have to look for other rows",
    )
    serve_alike: float = threshold(
        0.5,
        "1",
        "numpy",
        "rows whose pivots are at least this part of the best ones are equal: the first are held",
        "bricard.yaml: of rows that symmetry makes equal round-off chose with 0.99",
    )
    no_part: float = threshold(
        1e-8, "1", "both", "a reaction is unique where the choice of rows changes it by a smaller part", "√ε"
    )


@dataclass(frozen=True)
class Elimination:
    """Numbers are parts of other masses, moments and pivots."""

    lent_part: float = threshold(
        1e-6,
        "1",
        "both",
        "bodies without mass, or moment of inertia, get this part of the mean in the factor; iteration "
        "removes its effect",
        "quick to settle: an error falls a millionfold each pass",
    )
    fewest_shared: int = threshold(
        6,
        "-",
        "kernel",
        "a shaft that so many joints of loops share is taken apart in the factor",
        "the band holds half of the full block's numbers",
    )
    fewest_passed: int = threshold(
        4,
        "-",
        "kernel",
        "a body between two joints is carried by a joint that takes at least so many of its freedoms",
        "instructions of ladders: a quarter less with 4 and 5, 4 % more with 2",
    )


@dataclass(frozen=True)
class Invariants:
    """Rows of energy and momenta, which the projection keeps beside the joints' rows."""

    row_rests: float = threshold(
        0.25,
        "1",
        "kernel",
        "the energy row is singular where the speed is below this part of its change in a step",
        "a quarter of a step from rest",
    )
    row_suspicious: float = threshold(
        1e-5,
        "energy exchanged",
        "numpy",
        "the motion may be wrong where the energy row adds more per step in the mean",
        "a heavy top at 20 ms: 4e-5, wrong; a crank-rocker at 40 ms: 2e-7, right",
    )
    row_refused: float = threshold(
        0.01,
        "1",
        "both",
        "a correction of more than this part of the change in a step is refused: no step errs so much",
        "3e-3 in a double pendulum with RK4 at 50 ms; 0.15 in a heavy top at 5 ms, which is wrong",
    )
    row_tolerated: float = threshold(
        10.0,
        "tolerance",
        "kernel",
        "a correction within so many tolerances is a step's error, and never refused; a T within them of W "
        "counts as rest",
        "a quarter car that comes to rest",
    )
