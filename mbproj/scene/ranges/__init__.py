"""Ranges of a quantity: values one by one, evenly spaced ones, a distribution; read from files and the command line."""

from mbproj.scene.ranges.grammar import BOUNDS, RANGE, given_range, named_range
from mbproj.scene.ranges.values import Item, Listed, Normal, Points, Range, Spaced, Uniform

__all__ = [
    "BOUNDS",
    "RANGE",
    "Item",
    "Listed",
    "Normal",
    "Points",
    "Range",
    "Spaced",
    "Uniform",
    "given_range",
    "named_range",
]
