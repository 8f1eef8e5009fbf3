"""Steps: their size, their events, and forces that are too stiff for them."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


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
