"""Analysis: pure functions of results. Energy, violations, comparison, summary, expectations."""

from mbproj.analysis.comparison import Difference, common_samples, trajectory_difference
from mbproj.analysis.energy import EnergyDrift, energy_drift
from mbproj.analysis.expectations import Outcome, outcomes
from mbproj.analysis.summary import SeriesPeak, peak, summary, worst

__all__ = [
    "Difference",
    "EnergyDrift",
    "Outcome",
    "SeriesPeak",
    "common_samples",
    "energy_drift",
    "outcomes",
    "peak",
    "summary",
    "trajectory_difference",
    "worst",
]
