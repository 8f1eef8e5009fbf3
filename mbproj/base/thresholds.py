"""The one record of every number that was chosen, not derived: what counts as dependent, closed, near, at rest.

Each has a value, a unit, a reason and a source. NumPy's code reads `THRESHOLDS`; the kernel gets those that it uses as
one struct with each model. `mbproj info --thresholds` prints the table. Numbers that are mathematics stand where they
are used: 4 ε, 2π, the coefficients of a method, and how many rows a message shows.
A source that begins with "no case" names a test that holds with quite another value: such a threshold may go.
"""

from __future__ import annotations

from dataclasses import Field, field
from functools import cache
from typing import Any, Literal, NamedTuple, TypeVar, final

from mbproj.base.dataclass import dataclass, declared_fields

# --- One threshold ----------------------------------------------------------------------------------------------------
# A number with its unit, its use and its source.


Number = TypeVar("Number", int, float)
#: Where a threshold is used.
UsedBy = Literal["both", "kernel", "numpy"]


def threshold(value: Number, unit: str, used_by: UsedBy, why: str, source: str) -> Number:
    """A field of a dataclass with this default. `unit`: "1" for a part of something, "-" for a count; `why`: what it
    decides, and on which side the margin is; `source`: where the value comes from."""
    metadata = {"unit": unit, "used_by": used_by, "why": why, "source": source}
    declared: Number = field(default=value, metadata=metadata)
    return declared


# --- Thresholds of contacts with stops, of curves that are followed, and of ropes -------------------------------------


@dataclass(frozen=True)
class Contact:
    """Stops and dry friction. Gaps are parts of the mechanism's length, or rad."""

    stop_slack: float = threshold(
        1e-12,
        "length or rad",
        "both",
        "a stop whose gap is below 0 by less is closed, not penetrated",
        "10 × the closure of joints",
    )
    touching: float = threshold(
        1e-11, "length or rad", "both", "stops with smaller gaps take part in the same impact", "10 × the slack"
    )
    stop_rests: float = threshold(
        1e-11, "1", "both", "a gap or friction rests below this part of the mechanism's fastest speed", "1e5 ε"
    )
    rest_acceleration: float = threshold(
        1e-6,
        "fastest²",
        "kernel",
        "a friction at rest begins to slide along its acceleration only where that is larger",
        "100 × what a step of the shortest that tells rest leaves below the slack",
    )
    rest_steps: float = threshold(
        1e-4,
        "1 / fastest",
        "kernel",
        "a friction that does not slide during a step of this length is at rest",
        "no case: tests/friction/test_at_rest.py holds with 1 too",
    )
    lowest_bounce: float = threshold(
        1e-10, "length or rad", "kernel", "a bounce that is lower ends in contact", "10 × touching"
    )
    no_push: float = threshold(
        1e-11,
        "1",
        "kernel",
        "smaller terms in the equations of impacts and contacts are 0, beside terms of size 1",
        "1e5 ε",
    )
    contact_pulls: float = threshold(
        1e-10,
        "1",
        "both",
        "a contact opens where its push is below minus this part of the largest push",
        "round-off of λ, with care",
    )
    slips: float = threshold(
        1e-9,
        "1",
        "kernel",
        "a friction slips where the force that it needs exceeds its static force less this part",
        "round-off of λ, with care",
    )
    just_slips: float = threshold(
        1e-4,
        "1",
        "kernel",
        "feet that share a load and give way again and again at one time, though no slip is seen, slip as with static "
        "forces that are less by this part",
        "a block of 5e-4 kg m² on two feet, tests/friction/planes/test_slips.py: with 1e-7 its slip is round-off",
    )
    pushes_along: float = threshold(
        1e-4,
        "fastest speed",
        "kernel",
        "a friction that pushes along a faster motion ends the run",
        "sliding in a plane keeps its direction up to 3 × straight_speed",
    )
    damped_to: float = threshold(
        1e6,
        "1",
        "kernel",
        "above this damping, relative to B, Newton's method for shared loads finds no better short step, and "
        "takes a long one",
        "no case: tests/friction/planes/test_contact_problem.py holds with 1e-10 too",
    )
    slow_motion: float = threshold(
        1e-3,
        "length or rad / interval",
        "numpy",
        "round-off of speeds is relative to at least this speed",
        "no case: tests/stops/test_compliant.py holds with 1000 too",
    )
    middle_unlike: float = threshold(
        1e-3,
        "1",
        "kernel",
        "both halves of a step are examined where a gap in its middle differs from its cubic by more than "
        "this part of the largest gap",
        "a ball that rises and falls through another in one step of DOP853",
    )
    near_miss: float = threshold(
        0.05,
        "1",
        "kernel",
        "where a force passes its bound is sought nearby if looks inside a step saw that, and a step to there has less "
        "than this part of the force at the end",
        "220 runs of cams that lift off: 9 misses without, none with; a drum brake, which never slips, costs no more",
    )
    most_halves: int = threshold(
        8,
        "-",
        "kernel",
        "the most parts within parts of a step to find stops and slips that it passes",
        "a 256th of a step of DOP853",
    )
    turned_speed: float = threshold(
        1e-7,
        "1",
        "kernel",
        "sliding in a plane has come to rest where its speed falls below this part of the fastest motion",
        "tests/friction/planes/test_floors.py: with 0.01 a point stops before its time",
    )
    straight_speed: float = threshold(
        1e-5,
        "1",
        "kernel",
        "sliding in a plane below this part of the fastest motion keeps its direction while it comes to rest or starts",
        "the direction of a speed that is round-off is none",
    )
    creates_energy: float = threshold(
        1e-9,
        "1",
        "kernel",
        "an impact that adds a larger part of the kinetic energy stops the run",
        "round-off of the energies",
    )
    on_grid: float = threshold(
        1e-6,
        "step",
        "kernel",
        "a time this near to the grid of fixed steps counts as one on the grid",
        "round-off of many steps",
    )
    met_soon: float = threshold(
        1e-7,
        "1 / fastest motion",
        "kernel",
        "a decision on contacts without an event counts as simultaneous with the last one where it follows "
        "within this time",
        "feet at the edge of what they bear decided anew each 1e-11 s",
    )
    slides_in: float = threshold(
        0.5,
        "1",
        "kernel",
        "a fixed step changes a velocity of sliding in a plane by at most this part",
        "a foot that came to rest within a step of RK4 slid on for 0.2 s",
    )
    most_meetings: int = threshold(
        100, "-", "kernel", "the most decisions on contacts at one time", "more than stops of one mechanism"
    )


@dataclass(frozen=True)
class Curves:
    """Curves that are followed. 1 - κφ is the path of a point at the distance φ, divided by that of its foot."""

    least_undercut: float = threshold(
        0.05, "1", "numpy", "a roller does not fit its curve where 1 - κφ is smaller", "the row bends by 20 κ there"
    )
    place_turn: float = threshold(
        0.1,
        "rad",
        "numpy",
        "the largest turn of a curve from one place to the next, and beyond the end of a piece that a foot is held on",
        "8 nodes of Gauss: 1e-16",
    )
    overlap: float = threshold(
        1e-6,
        "1",
        "both",
        "two curves that touch overlap elsewhere where one is inside the other by this part of the first one's length",
        "a gear of 0.1 m: 0.6 µm",
    )


@dataclass(frozen=True)
class Ropes:
    """The limits of a rope's path, at the scene's pose and in a run."""

    wrong_side: float = threshold(
        5.5,
        "rad",
        "numpy",
        "a rope whose wrap, without whole turns, is larger is on the wrong side of its circle",
        "315 deg: a straight rope beside it",
    )
    fleet_angle: float = threshold(
        0.0873, "rad", "numpy", "the largest angle of a rope to the plane of its sheaves", "5 deg, as winches allow"
    )
    drawn_in: float = threshold(
        0.02,
        "1",
        "numpy",
        "a run has ended because of a span of a rope where the span is shorter than this part of its radii",
        "measured: a bob that is drawn into its wheel ends 1e-6 to 5e-3 radii before",
    )
    least_span: float = threshold(
        1e-3, "1", "numpy", "a span shorter than this part of the radii counts as vanished", "the row bends by 1/λ"
    )


# --- Poses ------------------------------------------------------------------------------------------------------------
# Poses: passing near a singular one, searches around one, and equilibria, modes and linear models at one.


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


# --- The solution of the joints' equations ----------------------------------------------------------------------------
# When joints count as closed, and when rows depend on each other.
# Also limits of masses and pivots, and of the rows of energy and momenta.


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
    most_driven: float = threshold(
        1e6,
        "length or rad",
        "numpy",
        "a motion that prescribes more in a step, or between samples where the step is free, is refused",
        "10 s of computing: a turn takes 66 µs; tests/integrate/test_kinematic.py",
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


# --- Steps: their size, their events, and forces that are too stiff for them ------------------------------------------


@dataclass(frozen=True)
class Steps:
    """Steps of integrators. Errors are in tolerances."""

    safety: float = threshold(
        0.9, "1", "both", "the next step, as a part of what the error estimate allows", "Hairer, Nørsett & Wanner, II.4"
    )
    smallest_change: float = threshold(0.2, "1", "both", "the least ratio of a step to the last", "DOPRI5's code")
    largest_change: float = threshold(10.0, "1", "both", "the largest ratio of a step to the last", "DOPRI5's code")
    least_error: float = threshold(
        1e-10, "tolerances", "both", "a smaller error counts as this in the size of the next step", "a guard against 0"
    )
    least_error_before: float = threshold(
        1e-4, "tolerances", "both", "a smaller error counts as this in the controller's memory", "DOPRI5's code"
    )
    split_parts: int = threshold(
        16,
        "1",
        "numpy",
        "a short move or pulse that fewer fixed steps do not resolve is made in at least so many parts",
        "a smooth step of 0.1 ms by RK4: 25 % off in one part, 4e-6 in 16",
    )
    split_to: float = threshold(
        1e-4, "1", "numpy", "the largest relative error of a resolved move's integral", "by RK4 it is 20 times less"
    )
    located: float = threshold(
        0.01,
        "tolerances × steps",
        "kernel",
        "events in the state are located to this part of a step",
        "below the error",
    )
    most_polishing: int = threshold(
        5, "1", "kernel", "a step to an event in the state is repeated at most so many times", "Newton's method takes 2"
    )
    widest_polishing: float = threshold(
        0.1, "steps", "kernel", "a larger correction of an event's time is not made", "grazing: no root is near"
    )
    bracketed: float = threshold(
        1e-10, "steps", "kernel", "the extension of a step locates events to this part", "Newton's method follows"
    )
    beside: float = threshold(
        1e-3,
        "steps",
        "kernel",
        "the argument of a law is evaluated so far on either side of an event, for its direction and its rate",
        "no case: tests/integrate/test_events.py holds with 0.1 too",
    )
    chatter: float = threshold(
        1e-4,
        "samples",
        "kernel",
        "a law chatters where it passes its edge again within this part of the time between samples",
        "tests/integrate/test_events.py: with 1e-10, a run whose law chatters does not stop in a minute",
    )
    most_chatter: int = threshold(
        100, "1", "kernel", "a law that chatters so often in a row never settles", "no run gets to its end at this rate"
    )
    turns_told: float = threshold(
        0.5, "rad", "both", "a step counts turns up to this difference of pose and rates", "RK4 errs by 0.04 rad"
    )
    most_turned: float = threshold(
        3.0,
        "rad",
        "both",
        "the largest turn of a bushing, or of the span of a rope in a step: at half a turn there is no "
        "rotation vector, and the angle of a span jumps",
        "no step skips the rest",
    )
    suspicious_drift: float = threshold(
        1e-4,
        "energy exchanged",
        "numpy",
        "where the energy drifts by more, the motion may be wrong",
        "the spatial slider-crank by RK4 drifts by 4.9e-4 in 2 s: tests/cli/test_run.py",
    )
    spoilt: float = threshold(
        1e3,
        "1",
        "numpy",
        "errors that grow by this factor over a run spoil it; growth by more than its square is not told as a number",
        "half of the digits of a tolerance of 1e-6",
    )
    near_limit: float = threshold(
        0.6, "1", "numpy", "stability limits the step from this part of its limit", "measured: error control ends there"
    )
    named: float = threshold(
        0.5,
        "1",
        "numpy",
        "a message names parts that are at least this part of the largest, and coordinates that change by as "
        "much; a note is given where at least this part of the samples call for it",
        "words only",
    )
    smooth_span: float = threshold(
        10.0,
        "steps",
        "numpy",
        "the number of steps over which the smoothness of a motion is examined",
        "tests/integrate/test_stiffness.py: over 1, a vibration that is the motion is told as stiff",
    )
    below_tolerances: float = threshold(
        50.0, "tolerances", "numpy", "a smooth motion differs by less from a polynomial", "measured: 0.1 to 50"
    )
    stiff_for_step: float = threshold(
        0.1,
        "1",
        "numpy",
        "a force enters Newton's matrix of an implicit step, and the study of stiffness, from this h|λ| on",
        "slower ones contract",
    )
    newton_part: float = threshold(
        0.05,
        "tolerances",
        "kernel",
        "Newton's method for a stage ends where its error is below so many tolerances",
        "tests/integrate/implicit/test_steps.py: 10 errs within steps",
    )
    newton_fixed: float = threshold(
        1e-14,
        "1",
        "kernel",
        "the error at which Newton's method for a stage ends with fixed steps, and the least one with error control",
        "energy of stiff springs shows 1e-13",
    )
    newton_floor: float = threshold(
        1e-9,
        "1",
        "kernel",
        "changes below this part of a state that do not shrink by half any more are round-off",
        "ε k / c of a stage",
    )
    most_newton: int = threshold(
        40,
        "1",
        "kernel",
        "Newton's method for a stage has failed after so many passes",
        "3 to 8 are usual, 20 of coupled stages",
    )
    first_contraction: float = threshold(
        0.3,
        "1",
        "kernel",
        "the contraction that is assumed for Newton's first change in a stage; a worse one needs a new matrix",
        "measured on prototypes",
    )
    least_contraction: float = threshold(
        0.01, "1", "kernel", "a smaller contraction of Newton's method counts as this", "Hairer & Wanner II, sect. IV.8"
    )
    softened: float = threshold(
        0.5,
        "1",
        "kernel",
        "errors are filtered with the stiffness of a law at a stage where it has fallen below this part",
        "a mass that comes to stick within a step",
    )
    fewest_grains: float = threshold(
        16.0,
        "grains of time",
        "numpy",
        "the shortest step, in units of the resolution of time",
        "no case: tests/integrate/test_stiffness.py holds with 1e9 too; the kernel's is in schedule.hpp",
    )
    free_passes: int = threshold(
        4,
        "-",
        "kernel",
        "after so many passes no law becomes less stiff, so that Newton's method ends",
        "tests/integrate/implicit/test_steps.py: with 1000, Radau IIA solves no part of a step of a belt",
    )
    most_steps: float = threshold(
        1e8,
        "steps",
        "numpy",
        "a run has at most so many steps in a study that varies the step or the duration",
        "ten minutes a run",
    )
    most_halvings: int = threshold(
        10,
        "-",
        "both",
        "the most halvings of a fixed step that is not solved or does not resolve a short move, and of a "
        "correction that does not help",
        "tests/integrate/implicit/test_steps.py: 1 is too few for a mass that comes to stick",
    )
    branch_halvings: int = threshold(
        4, "-", "kernel", "a fixed step that passes a singular pose is halved so many times", "errors fall by 16³"
    )
    unresolved_vibration: float = threshold(
        1.0,
        "ω h",
        "numpy",
        "an implicit step damps faster vibrations; a note proposes half of this step, which follows them",
        "ESDIRK4 and Radau IIA keep 0.9998 of it",
    )
    hardly_damped: float = threshold(
        0.2,
        "1",
        "numpy",
        "a mode that decays or grows by less than this part of its frequency is a vibration",
        "no case: tests/integrate/implicit/test_energy.py holds with 1e-9 too",
    )
    marks_apart: float = threshold(
        9.0, "times it takes", "numpy", "the time from one mark of a run to the next", "a tenth of a run's time"
    )


@dataclass(frozen=True)
class Automatic:
    """The integrator `auto`. Steps are those that were tried."""

    look_steps: int = threshold(
        20,
        "steps",
        "numpy",
        "the fewest steps between two looks at the speed of a run",
        "tests/integrate/implicit/test_automatic.py: a clamp is too late seen as stiff with 1000, `slowed` 0.01, "
        "no wait",
    )
    look_part: float = threshold(
        0.05,
        "1",
        "numpy",
        "steps between looks at a run's speed, as a part of all steps",
        "what a look costs is little beside them",
    )
    slowed: float = threshold(
        0.5,
        "1",
        "numpy",
        "a run that has slowed down to this part tries the other method",
        "tests/integrate/implicit/test_automatic.py: with 0.01 and `look_steps` 1000, a clamp is seen too late",
    )
    trial_steps: int = threshold(
        5, "steps", "numpy", "the steps of the other method between two looks of a trial", "5 reach a size"
    )
    trial_parts: int = threshold(
        4, "-", "numpy", "the most looks of a trial", "a step grows by 1e5 from an explicit one"
    )
    trial_part: float = threshold(
        0.1, "1", "numpy", "trials may take this part of the evaluations, beside the first two", "an aim of 1.25 in all"
    )
    quicker: float = threshold(
        1.25,
        "1",
        "numpy",
        "a run changes to a method that is faster by this factor; a trial goes on while its speed grows by it",
        "above the scatter of step sizes",
    )
    implicit_cost: float = threshold(
        2.5, "1", "numpy", "the cost of an evaluation in an implicit step, in explicit ones", "measured: 1.2 to 4.7"
    )
    longest_wait: int = threshold(
        6,
        "-",
        "numpy",
        "each trial that does not pay doubles the number of steps to the next one, at most so many times",
        "tests/integrate/implicit/test_automatic.py, with `look_steps`",
    )


# --- The one record of every number that was chosen, not derived ------------------------------------------------------


@dataclass(frozen=True)
class Common:
    """The scales of round-off, from a few operations on doubles to what has lost half of its digits."""

    no_digits: float = threshold(
        1e-13,
        "1",
        "both",
        "a smaller part of the largest has no digits left: pivots, moments, masses, changes of an iteration",
        "450 ε; Skeel 1980 of backward errors",
    )
    rounding: float = threshold(
        1e-12,
        "1",
        "both",
        "a smaller part of the largest is round-off of long sums, of numbers that somebody typed, or of a "
        "mechanism at rest",
        "4500 ε; typed numbers have 15 digits",
    )
    same_written: float = threshold(
        1e-9,
        "1, m, rad",
        "both",
        "places, times, directions and poses that differ by less, over 1 or over their size, are the same; so are "
        "slopes",
        "files have 10 digits or more: mechanisms that `mbproj equilibrium` writes and reads again",
    )
    half_digits: float = threshold(
        1e-8,
        "1",
        "both",
        "a smaller part is none where errors enter by their square or as a difference; a curve that turns by less "
        "has no corner",
        "√ε",
    )
    short_way: float = threshold(
        0.05,
        "length, rad",
        "numpy",
        "a pose so far away is another one, of the same branch",
        "far from round-off, near to a joint's turn; tests/integrate/test_lock_up.py",
    )
    long_way: float = threshold(
        0.2,
        "length, rad",
        "numpy",
        "a walk, a sample of poses and a first step to an equilibrium go so far at once",
        "linear models hold for tenths of a radian",
    )
    rounded: float = threshold(
        1e-3,
        "1",
        "both",
        "a smaller part is that of numbers which somebody rounded or measured: no direction, slope, distance or share",
        "a wrist rounded to 0.1 mm: 8e-5",
    )
    most_passes: int = threshold(
        100,
        "-",
        "both",
        "passes of an iteration that ends before by its own test; steps of a search along a motion",
        "3 to 30 are usual; with 300, `branches` of bricard takes 1.5 times as long",
    )


@final
@dataclass(frozen=True)
class Thresholds(
    Common,
    Automatic,
    Linear,
    Contact,
    Looks,
    Searches,
    Steps,
    Invariants,
    Closing,
    Passages,
    Elimination,
    Curves,
    Ropes,
    Dependence,
):
    """All of them, each under its name."""

    def __init__(self, **others: float) -> None:
        """As chosen, but for `others`. A function with each of them as a parameter would take 6 ms to compile."""
        chosen = {name: entry.default for name, entry in _DECLARED.items()}
        unknown = others.keys() - chosen.keys()
        if unknown:
            raise TypeError(f"there is no threshold '{min(unknown)}'")
        vars(self).update(chosen | others)


#: As the groups declare them. `fields` would look at each declaration twice, 5 ms in each process.
_DECLARED: dict[str, Field[Any]] = {
    name: entry for group in reversed(Thresholds.__mro__[:-1]) for name, entry in declared_fields(group).items()
}
THRESHOLDS = Thresholds()


class ThresholdRow(NamedTuple):
    """One threshold; `used_by` says whether NumPy's code, the kernel's, or both have it."""

    name: str
    value: float
    unit: str
    used_by: str
    why: str
    source: str


def threshold_table() -> list[ThresholdRow]:
    """All thresholds, group by group."""
    return [
        ThresholdRow(
            name,
            getattr(THRESHOLDS, name),
            **{key: entry.metadata[key] for key in ("unit", "used_by", "why", "source")},
        )
        for name, entry in _DECLARED.items()
    ]


def of_the_kernel(thresholds: Thresholds = THRESHOLDS) -> dict[str, Any]:
    """Those that the kernel uses, by name."""
    return {name: getattr(thresholds, name) for name in _kernel_names()}


@cache
def _kernel_names() -> tuple[str, ...]:
    return tuple(row.name for row in threshold_table() if row.used_by != "numpy")
