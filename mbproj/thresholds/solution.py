"""The solution of the joints' equations: when joints count as closed, and when rows depend on each other. Also limits
of masses and pivots, and of the rows of energy and momenta.
"""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Closing:
    """Lengths are in m, or in the mechanism's own length where that is below 1 m."""

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
        "a row that is open by so much of its coordinates is closed to round-off; the sides of a kink in time lie "
        "so far apart",
        "sums of 4 numbers",
    )
    paper_tolerance: float = threshold(
        1e-12, "kg m²", "both", "the default of the paper's test ΔqᵀMΔq", "paper, sect. 5"
    )
    round_off_grains: float = threshold(
        64.0,
        "ε",
        "both",
        "a violation of so many ε of a row's coordinates, or energy of its terms, may be round-off; events nearer "
        "in ε of time are one",
        "tests/projection/test_schedule.py: with 1, projections do not end at round-off",
    )
    slow: float = threshold(
        0.1, "1", "kernel", "a pass that leaves a larger part asks for a new factor", "simplified Newton"
    )
    widest_turn: float = threshold(
        0.5,
        "rad",
        "both",
        "no correction turns a body by more; a motion moves by no more in a part of a short move",
        "Conn, Gould & Toint 2000, sect. 7; 16 turns in 2 ms: parts of 6.6 rad do not close in full",
    )
    tighter: float = threshold(
        0.25,
        "1",
        "both",
        "from one trial to the next turns are limited to this part",
        "tests/projection/test_damping.py: uneven chains do not close in 12 passes with 0.5 and `stiffer` 10",
    )
    stiffer: float = threshold(
        100.0,
        "1",
        "both",
        "the moment of a body that turns too far grows by this, times how much too far",
        "tests/projection/test_damping.py: uneven chains do not close in 12 passes with 10 and `tighter` 0.5",
    )
    open_limit: float = threshold(
        1e-6,
        "length, rad",
        "both",
        "no run goes on with a larger violation after a failed projection",
        "no case: tests/projection/test_fallback.py holds with 1e-12 too",
    )
    lost_limit: float = threshold(
        1.0, "length, rad", "both", "no run goes on with a larger violation", "the mechanism itself"
    )
    assembled: float = threshold(
        1e-10,
        "length, rad",
        "numpy",
        "a pose with a smaller violation is assembled",
        "poses of tests/dynamics/test_assembly.py close to 1e-15",
    )
    large: int = threshold(
        100,
        "bodies",
        "numpy",
        "dense factors of more bodies are not made to assemble, to diagnose, for modes, or in a plane",
        "singular values of the rows of 100 bodies: 0.1 s, of 500: 16 s",
    )


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


@dataclass(frozen=True)
class Elimination:
    """Numbers are parts of other masses, moments and pivots."""

    lent_part: float = threshold(
        1e-6,
        "1",
        "both",
        "this part of the mean mass, or moment, is lent to bodies without",
        "quick to settle: an error falls a millionfold each pass",
    )
    fewest_shared: int = threshold(
        6,
        "-",
        "kernel",
        "joints of the loops that share a shaft take it apart",
        "the band holds half of the full block's numbers",
    )
    fewest_passed: int = threshold(
        4,
        "-",
        "kernel",
        "a body between two joints moves by that which takes so many freedoms",
        "instructions of ladders: a quarter less with 4 and 5, 4 % more with 2",
    )


@dataclass(frozen=True)
class Invariants:
    """Rows of energy and momenta, which the projection keeps beside the joints' rows."""

    row_rests: float = threshold(
        0.25,
        "1",
        "both",
        "with a smaller part of the speed that a step changes, the row is singular",
        "a quarter of a step from rest",
    )
    row_suspicious: float = threshold(
        1e-5,
        "energy exchanged",
        "numpy",
        "where the row gives more a step in the mean, the motion may be wrong",
        "a heavy top at 20 ms: 4e-5, wrong; a crank-rocker at 40 ms: 2e-7, right",
    )
    row_refused: float = threshold(
        0.01,
        "1",
        "both",
        "a correction of a larger part of what a step changes is refused: that is no step's error",
        "3e-3 in a double pendulum with RK4 at 50 ms; 0.15 in a heavy top at 5 ms, which is wrong",
    )
    row_tolerated: float = threshold(
        10.0,
        "tolerance",
        "both",
        "so many tolerances are a step's error: a correction within them is never refused; T within them of W is rest",
        "a quarter car that comes to rest",
    )
