"""Thresholds of contacts with stops, of curves that are followed, and of ropes."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


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
