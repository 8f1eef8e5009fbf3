"""`integrator: auto`: when it looks whether another method would be quicker, and when it takes it."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Automatic:
    """Steps are those that were tried."""

    look_explicit: int = threshold(
        200,
        "steps",
        "numpy",
        "explicit steps between two looks at the fastest mode",
        "chosen: what a look costs is little beside them",
    )
    look_implicit: int = threshold(40, "steps", "numpy", "implicit steps between two looks", "the same")
    trial_steps: int = threshold(
        20, "steps", "numpy", "so many steps of the other method are a trial; the second half counts", "5 reach a size"
    )
    quicker: float = threshold(
        1.5, "1", "numpy", "another method goes on that gets on by this factor faster for its evaluations", "hysteresis"
    )
    implicit_cost: float = threshold(
        2.0, "1", "numpy", "an evaluation in an implicit step costs so many explicit ones", "measured: up to 2.4"
    )
    longest_wait: int = threshold(
        6, "-", "numpy", "a trial that does not pay doubles the steps until the next look, so often at most", "chosen"
    )
