"""Steps: their size, their events, and forces that are too stiff for them."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Steps:
    """Errors are in parts of the tolerance."""

    safety: float = threshold(
        0.9, "1", "both", "the step is this part of what the error estimate allows", "Hairer, Nørsett & Wanner, II.4"
    )
    smallest_change: float = threshold(0.2, "1", "both", "no step is a smaller part of the last", "DOPRI5's code")
    largest_change: float = threshold(10.0, "1", "both", "nor a larger multiple", "DOPRI5's code")
    least_error: float = threshold(
        1e-10, "tolerances", "both", "a smaller error counts as this in the next step's size", "a guard against 0"
    )
    least_error_before: float = threshold(
        1e-4, "tolerances", "both", "and as this in the memory of the controller", "DOPRI5's code"
    )
    split_parts: int = threshold(
        16,
        "1",
        "numpy",
        "a short move or pulse that fewer fixed steps do not resolve is made in so many parts, or more",
        "a smooth step of 0.1 ms by RK4: 25 % off in one part, 4e-6 in 16",
    )
    split_to: float = threshold(
        1e-4, "1", "numpy", "to be resolved, its integral may be so much off", "by RK4 it is 20 times less"
    )
    located: float = threshold(
        0.01,
        "tolerances × steps",
        "kernel",
        "events in the state are located to this part of a step",
        "below the error",
    )
    most_polishing: int = threshold(
        5, "1", "kernel", "a step to an event in the state is made again so often at most", "Newton's method takes 2"
    )
    widest_polishing: float = threshold(
        0.1, "steps", "kernel", "a correction of that time beyond this is not made", "grazing: no root is near"
    )
    bracketed: float = threshold(
        1e-10, "steps", "kernel", "the extension shows an event to this part of a step", "Newton's method follows"
    )
    beside: float = threshold(
        1e-3,
        "steps",
        "kernel",
        "so far on either side of an event is told where a law's argument leads, and how fast",
        "no case: tests/integrate/test_state_events.py holds with 0.1 too",
    )
    chatter: float = threshold(
        1e-4,
        "samples",
        "kernel",
        "a law chatters that passes its edge again within this part of the time of a sample",
        "tests/integrate/test_state_events.py: with 1e-10, a run whose law chatters does not stop in a minute",
    )
    most_chatter: int = threshold(
        100, "1", "kernel", "so many times in a row: it never settles", "no run gets to its end at this rate"
    )
    turns_told: float = threshold(
        0.5, "rad", "both", "a step tells turns where a pose is nearer to where the rates lead", "RK4 errs by 0.04 rad"
    )
    most_turned: float = threshold(
        3.0,
        "rad",
        "both",
        "a bushing or the span of a rope may turn so far: half a turn has no rotation vector, and the angle of a "
        "span jumps there",
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
        "errors that grow by this factor over a run spoil it; its square is not told as a number",
        "half of the digits of a tolerance of 1e-6",
    )
    near_limit: float = threshold(
        0.6, "1", "numpy", "stability holds the step at this part of its limit", "measured: error control ends there"
    )
    named: float = threshold(
        0.5,
        "1",
        "numpy",
        "what has this part of the largest share is named; so are coordinates that change by so much",
        "words only",
    )
    smooth_span: float = threshold(
        10.0,
        "steps",
        "numpy",
        "motion is looked at for smoothness over so many",
        "tests/integrate/test_stiffness.py: over 1, a vibration that is the motion is told as stiff",
    )
    below_tolerances: float = threshold(
        50.0, "tolerances", "numpy", "a mode at the limit of stability leaves less", "measured: 0.1 to 50"
    )
    stiff_for_step: float = threshold(
        0.1,
        "1",
        "numpy",
        "a force enters Newton's matrix of an implicit step from this h|λ| on, and is looked at by the study of "
        "stiffness",
        "slower ones contract",
    )
    newton_part: float = threshold(
        0.05,
        "tolerances",
        "kernel",
        "Newton's method leaves so much of a stage",
        "tests/integrate/implicit/test_steps.py: 10 errs within steps",
    )
    newton_fixed: float = threshold(
        1e-14,
        "1",
        "kernel",
        "it leaves no less of a state, and this with fixed steps",
        "energy of stiff springs shows 1e-13",
    )
    newton_floor: float = threshold(
        1e-9,
        "1",
        "kernel",
        "changes below this part of a state that shrink no more are round-off",
        "ε k / c of a stage",
    )
    most_newton: int = threshold(
        40, "1", "kernel", "Newton's method has failed after so many changes", "3 to 8 are usual, 20 of coupled stages"
    )
    first_contraction: float = threshold(
        0.3,
        "1",
        "kernel",
        "a stage's first change of Newton's method counts with this contraction; a worse one asks for a new matrix",
        "measured on prototypes",
    )
    least_contraction: float = threshold(
        0.01, "1", "kernel", "a smaller one is chance", "Hairer & Wanner II, sect. IV.8"
    )
    softened: float = threshold(
        0.5,
        "1",
        "kernel",
        "errors are filtered with a law as stiff as at the stage where it is softer than this part",
        "a mass that comes to stick within a step",
    )
    fewest_grains: float = threshold(
        16.0,
        "grains of time",
        "numpy",
        "time does not resolve a step of fewer",
        "no case: tests/integrate/test_stiffness.py holds with 1e9 too; the kernel's is in schedule.hpp",
    )
    free_passes: int = threshold(
        4,
        "-",
        "kernel",
        "after so many passes no law becomes less stiff, so that Newton's method ends",
        "tests/integrate/implicit/test_halving.py: with 1000, Radau IIA solves no part of a step of a belt",
    )
    most_steps: float = threshold(
        1e8,
        "steps",
        "numpy",
        "a study that varies the step, or the duration, makes no run of more",
        "ten minutes a run",
    )
    most_halvings: int = threshold(
        10,
        "-",
        "both",
        "a fixed step that is not solved or does not resolve a short move, and a correction that does not help, "
        "are halved so often",
        "tests/integrate/implicit/test_halving.py: 1 is too few for a mass that comes to stick",
    )
    branch_halvings: int = threshold(
        4, "-", "kernel", "a fixed step that passes a singular pose is halved so often", "errors fall by 16³"
    )
    unresolved_vibration: float = threshold(
        1.0,
        "ω h",
        "numpy",
        "an implicit step damps what is faster; steps of half of it, which a note proposes, follow the vibration",
        "ESDIRK4 and Radau IIA keep 0.9998 of it",
    )
    hardly_damped: float = threshold(
        0.2,
        "1",
        "numpy",
        "a mode that decays or grows by less than this part of its frequency is a vibration",
        "no case: tests/integrate/implicit/test_notes.py holds with 1e-9 too",
    )
    marks_apart: float = threshold(
        9.0, "times it takes", "numpy", "so long after one mark of a run the next is kept", "a tenth of a run's time"
    )


@dataclass(frozen=True)
class Automatic:
    """The integrator `auto`. Steps are those that were tried."""

    look_steps: int = threshold(
        20,
        "steps",
        "numpy",
        "the least between two looks at how fast a run gets on",
        "tests/integrate/implicit/test_automatic.py: a clamp is too late seen as stiff with 1000, `slowed` 0.01, "
        "no wait",
    )
    look_part: float = threshold(
        0.05, "1", "numpy", "looks are this part of the steps so far apart", "what a look costs is little beside them"
    )
    slowed: float = threshold(
        0.5,
        "1",
        "numpy",
        "a run that has slowed down to this part tries the other method",
        "tests/integrate/implicit/test_automatic.py: with 0.01 and `look_steps` 1000, a clamp is seen too late",
    )
    trial_steps: int = threshold(
        5, "steps", "numpy", "a trial looks after so many steps of the other method", "5 reach a size"
    )
    trial_parts: int = threshold(4, "-", "numpy", "so often at most", "a step grows by 1e5 from an explicit one")
    trial_part: float = threshold(
        0.1, "1", "numpy", "part of the evaluations that trials may take, beside the first two", "an aim of 1.25 in all"
    )
    quicker: float = threshold(
        1.25,
        "1",
        "numpy",
        "another method goes on that gets on by this factor faster, and a trial while it does so",
        "above the scatter of step sizes",
    )
    implicit_cost: float = threshold(
        2.5, "1", "numpy", "an evaluation in an implicit step costs so many explicit ones", "measured: 1.2 to 4.7"
    )
    longest_wait: int = threshold(
        6,
        "-",
        "numpy",
        "a trial that does not pay doubles the steps until the next one, so often at most",
        "tests/integrate/implicit/test_automatic.py, with `look_steps`",
    )
