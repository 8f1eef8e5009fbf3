"""`integrator: auto`: when it looks whether another method would be quicker, and when it takes it."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Automatic:
    """Steps are those that were tried."""

    look_steps: int = threshold(
        20, "steps", "numpy", "the least between two looks at how fast a run gets on", "chosen: what a trial costs"
    )
    look_part: float = threshold(
        0.05, "1", "numpy", "looks are this part of the steps so far apart", "what a look costs is little beside them"
    )
    slowed: float = threshold(
        0.5, "1", "numpy", "a run that has slowed down to this part tries the other method", "chosen: above scatter"
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
        6, "-", "numpy", "a trial that does not pay doubles the steps until the next one, so often at most", "chosen"
    )
