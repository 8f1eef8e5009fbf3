"""When a mechanism touches its stops, and when it stays there."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Contact:
    """Gaps are parts of the mechanism's length, or rad."""

    stop_slack: float = threshold(
        1e-12,
        "length or rad",
        "numpy",
        "a gap that is less far below 0 is closed, no more",
        "10 × the closure of joints",
    )
    touching: float = threshold(
        1e-11, "length or rad", "numpy", "stops with smaller gaps are struck together", "10 × the slack"
    )
    stop_rests: float = threshold(
        1e-11, "1", "numpy", "a gap that changes by less, beside the speeds of the mechanism, rests", "1e5 ε"
    )
    lowest_bounce: float = threshold(
        1e-10, "length or rad", "numpy", "a lower bounce is none: it ends in contact", "10 × touching"
    )
    no_push: float = threshold(
        1e-11, "1", "numpy", "beside terms of size 1 in the equations of impacts and contact, this is none", "1e5 ε"
    )
    contact_pulls: float = threshold(
        1e-10,
        "1",
        "numpy",
        "a contact is released below minus this part of its largest push",
        "round-off of λ, with care",
    )
    creates_energy: float = threshold(
        1e-9, "1", "numpy", "an impact that adds more of the kinetic energy stops the run", "round-off of the energies"
    )
    on_grid: float = threshold(
        1e-6, "step", "numpy", "a time that is nearer to one of the steps' grid is that time", "round-off of many steps"
    )
    most_meetings: int = threshold(
        100, "-", "numpy", "so many things may happen to stops at one time", "more than stops of one mechanism"
    )
