"""How functions of time are looked at for kinks and narrow features, before a run."""

from __future__ import annotations

from mbproj.dataclass import dataclass
from mbproj.thresholds.entry import threshold


@dataclass(frozen=True)
class Looks:
    """Changes are parts of what a function ranges over in one window."""

    look_intervals: int = threshold(
        4096, "-", "numpy", "a window is looked at so many times; what is narrower can be missed", "milliseconds"
    )
    no_change: float = threshold(
        4e-4,
        "1",
        "numpy",
        "a narrow feature changes by five times this in an interval, and ends where less changes",
        "a slow sine changes by 2.5e-4 in an interval",
    )
    quiet_stretch: int = threshold(
        8,
        "intervals",
        "numpy",
        "fewer quiet ones part no two features",
        "tests/integrate/test_time_events.py: with 1, a pulse ends at its top",
    )
    edge_decades: int = threshold(
        3,
        "powers of ten",
        "numpy",
        "functions of lengths are looked at for edges from 10^-3 to 10^3 m; functions of angles over a turn",
        "1 mm to 1 km: what moves in a mechanism",
    )
    most_kinks: int = threshold(
        1000,
        "-",
        "numpy",
        "so many kinks of one function count at most; what changes its sign more often in a window is seen well enough",
        "seconds of a run",
    )
