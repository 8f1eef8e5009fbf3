"""Pure functions of results: energy, violations, comparison, summary."""

from mbproj.analysis.comparison import Difference, common_samples, trajectory_difference
from mbproj.analysis.energy import EnergyDrift, energy_drift
from mbproj.analysis.summary import summary
from mbproj.analysis.violations import Peak, peak, worst

__all__ = [
    "Difference",
    "EnergyDrift",
    "Peak",
    "common_samples",
    "energy_drift",
    "peak",
    "summary",
    "trajectory_difference",
    "worst",
]
