"""Stability maps: where each method holds, degrades and fails over one quantity that is varied."""

from mbproj.studies.stability.bisection import StabilityMap, stability

__all__ = ["StabilityMap", "stability"]
