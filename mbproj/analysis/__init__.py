"""Analysis: pure functions of results. Energy, violations, comparison, summary, expectations.

The names are imported when they are first used: a run needs few of them.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mbproj.analysis.comparison import Difference, common_samples, trajectory_difference
    from mbproj.analysis.energy import EnergyDrift, energy_drift
    from mbproj.analysis.expectations import Outcome, outcomes
    from mbproj.analysis.summary import SeriesPeak, peak, worst

_HOME_OF = {
    **dict.fromkeys(("Difference", "common_samples", "trajectory_difference"), "mbproj.analysis.comparison"),
    **dict.fromkeys(("EnergyDrift", "energy_drift"), "mbproj.analysis.energy"),
    **dict.fromkeys(("Outcome", "outcomes"), "mbproj.analysis.expectations"),
    **dict.fromkeys(("SeriesPeak", "peak", "worst"), "mbproj.analysis.summary"),
}
__all__ = [
    "Difference",
    "EnergyDrift",
    "Outcome",
    "SeriesPeak",
    "common_samples",
    "energy_drift",
    "outcomes",
    "peak",
    "trajectory_difference",
    "worst",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'mbproj.analysis' has no attribute '{name}'")
    return getattr(import_module(_HOME_OF[name]), name)
