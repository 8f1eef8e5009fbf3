"""Motions over time: the joint coordinate that each prescribes, and the driving force or torque."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from mbproj.plot.driven import rows
from mbproj.plot.style import styled
from mbproj.results import Results


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """A row a motion, a line a result."""
    return rows(results, labels, "motions", "value")
