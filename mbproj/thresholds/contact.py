"""Thresholds of contacts with stops, of curves that are followed, and of ropes."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Contact:
    """Gaps are parts of the mechanism's length, or rad."""

    stop_slack: float = threshold(
        1e-12,
        "length or rad",
        "both",
        "a gap that is less far below 0 is closed, no more",
        "10 × the closure of joints",
    )
    touching: float = threshold(
        1e-11, "length or rad", "both", "stops with smaller gaps are struck together", "10 × the slack"
    )
    stop_rests: float = threshold(
        1e-11, "1", "both", "a gap that changes by less, beside the speeds of the mechanism, rests", "1e5 ε"
    )
    rest_acceleration: float = threshold(
        1e-6,
        "fastest²",
        "kernel",
        "a friction at a joint whose rate is given begins to slide as its acceleration says, if that is larger",
        "100 × what a step of the shortest that tells rest leaves below the slack",
    )
    rest_steps: float = threshold(
        1e-4,
        "1 / fastest",
        "kernel",
        "a friction that does not slide over such a step is at rest",
        "no case: tests/friction/test_at_rest.py holds with 1 too",
    )
    lowest_bounce: float = threshold(
        1e-10, "length or rad", "kernel", "a lower bounce is none: it ends in contact", "10 × touching"
    )
    no_push: float = threshold(
        1e-11, "1", "kernel", "beside terms of size 1 in the equations of impacts and contact, this is none", "1e5 ε"
    )
    contact_pulls: float = threshold(
        1e-10,
        "1",
        "both",
        "a contact is released below minus this part of its largest push",
        "round-off of λ, with care",
    )
    slips: float = threshold(
        1e-9,
        "1",
        "kernel",
        "a friction that needs all of its static force but this part slips",
        "round-off of λ, with care",
    )
    springs_give: float = threshold(
        1e-6,
        "1 / smallest mass",
        "kernel",
        "springs that stand for rigid feet which slip give so much; which feet slip is found where all bear less "
        "by ten times it",
        "√ε, with care",
    )
    damped_to: float = threshold(
        1e6,
        "1",
        "kernel",
        "with more damping, beside B, Newton's method has no share of a load on a short way and leaps",
        "no case: tests/friction/planes/test_margins.py holds with 1e-10 too",
    )
    slow_motion: float = threshold(
        1e-3,
        "length or rad / interval",
        "numpy",
        "round-off of speeds is that of motions at least as fast",
        "no case: tests/stops/test_at_rest.py holds with 1000 too",
    )
    middle_unlike: float = threshold(
        1e-3,
        "1",
        "kernel",
        "a gap in the middle of a step that is off its cubic by more, beside the largest, is looked at on each half",
        "a ball that rises and falls through another in one step of DOP853",
    )
    most_halves: int = threshold(
        8, "-", "kernel", "a step is halved so often to see what it passes", "a 256th of a step of DOP853"
    )
    turned_speed: float = threshold(
        1e-7,
        "1",
        "kernel",
        "sliding in a plane that is slower, beside the fastest motion, has come to rest",
        "tests/friction/planes/test_floors.py: with 0.01 a point stops before its time",
    )
    straight_speed: float = threshold(
        1e-5,
        "1",
        "kernel",
        "sliding in a plane that is slower, beside the fastest motion, and becomes slower still, keeps its direction",
        "the direction of a speed that is round-off is none",
    )
    creates_energy: float = threshold(
        1e-9, "1", "kernel", "an impact that adds more of the kinetic energy stops the run", "round-off of the energies"
    )
    on_grid: float = threshold(
        1e-6,
        "step",
        "kernel",
        "a time that is nearer to one of the steps' grid is that time",
        "round-off of many steps",
    )
    met_soon: float = threshold(
        1e-7,
        "1 / fastest motion",
        "kernel",
        "a decision on contacts without an event, sooner after the last one, is at the same time as that",
        "feet at the edge of what they bear decided anew each 1e-11 s",
    )
    slides_in: float = threshold(
        0.5,
        "1",
        "kernel",
        "a fixed step changes a velocity of sliding in a plane by no more than this part of it",
        "a foot that came to rest within a step of RK4 slid on for 0.2 s",
    )
    most_meetings: int = threshold(
        100, "-", "kernel", "so many things may happen to stops at one time", "more than stops of one mechanism"
    )


@dataclass(frozen=True)
class Curves:
    """1 - κφ is the part of a curve's length that a point at the distance φ passes over."""

    least_undercut: float = threshold(
        0.05, "1", "numpy", "where 1 - κφ falls below, a roller does not fit its curve", "the row bends by 20 κ there"
    )
    place_turn: float = threshold(
        0.1,
        "rad",
        "numpy",
        "a curve turns by less from one place to the next, and by so much beyond the end of a piece that is held",
        "8 nodes of Gauss: 1e-16",
    )
    overlap: float = threshold(
        1e-6,
        "1",
        "both",
        "two curves that touch overlap elsewhere by this part of the length of the first",
        "a gear of 0.1 m: 0.6 µm",
    )


@dataclass(frozen=True)
class Ropes:
    """The limits of a rope's path, at the scene's pose and in a run."""

    wrong_side: float = threshold(
        5.5,
        "rad",
        "numpy",
        "a wrap of more, without whole turns, is on the wrong side",
        "315 deg: a straight rope beside it",
    )
    fleet_angle: float = threshold(
        0.0873, "rad", "numpy", "a rope leans out of the plane of its sheaves by no more", "5 deg, as winches allow"
    )
    drawn_in: float = threshold(
        0.02,
        "1",
        "numpy",
        "where a run cannot go on, a span shorter than this part of its radii is why",
        "measured: a bob that is drawn into its wheel ends 1e-6 to 5e-3 radii before",
    )
    least_span: float = threshold(
        1e-3, "1", "numpy", "a span shorter than this part of the radii is none", "the row bends by 1/λ"
    )
