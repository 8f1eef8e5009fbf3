"""Forces over time: the length or joint coordinate that each acts along, and its size."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from mbproj.plot.driven import rows
from mbproj.plot.style import styled
from mbproj.results import Results


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """A row a force, a line a result."""
    return rows(results, labels, "forces", "coordinate")
