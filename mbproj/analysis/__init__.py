"""Analysis: pure functions of results. Energy, violations, comparison, summary, expectations.

The names are imported when they are first used: a run needs few of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mbproj.registry import lazily

if TYPE_CHECKING:
    from mbproj.analysis.comparison import (
        Difference,
        common_samples,
        trajectory_difference,
    )
    from mbproj.analysis.energy import EnergyDrift, energy_drift
    from mbproj.analysis.expectations import Outcome, outcomes
    from mbproj.analysis.growth import Growth
    from mbproj.analysis.summary import SeriesPeak, peak, worst

__getattr__ = lazily(
    __name__,
    {
        "comparison": "Difference common_samples trajectory_difference",
        "contacts.friction": "friction_records sticking",
        "contacts.ropes": "pushed_by_ropes",
        "energy": "EnergyDrift energy_drift",
        "expectations": "Outcome measured outcomes",
        "growth": "Growth",
        "loads": "duration_above loads_of recorded_in samples_of swings",
        "summary": "SeriesPeak peak worst",
        "trust": "usual_limit",
    },
)
