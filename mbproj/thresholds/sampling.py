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
    look_changes: int = threshold(
        50, "-", "numpy", "what changes its sign more often in a window is seen well enough at these times", "chosen"
    )
    no_change: float = threshold(
        4e-4,
        "1",
        "numpy",
        "a narrow feature changes by five times this in an interval, and ends where less changes",
        "a slow sine changes by 2.5e-4; tests/functions/test_narrow.py",
    )
    quiet_stretch: int = threshold(8, "intervals", "numpy", "fewer quiet ones part no two features", "chosen")
    edges_from: float = threshold(
        1e-3, "m", "numpy", "functions of lengths are looked at for edges up to here, then by powers of ten", "chosen"
    )
    edges_powers: int = threshold(6, "-", "numpy", "by so many of them; functions of angles over a turn", "up to 1 km")
    most_kinks: int = threshold(1000, "-", "numpy", "so many kinks of one function count at most", "seconds of a run")
