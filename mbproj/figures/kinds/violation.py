"""The largest violation of the constraints, position and velocity, over time."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from mbproj.figures import panels
from mbproj.figures.style import styled
from mbproj.results import Results

ROWS = (
    ("diagnostics/position_violation", r"$|C|_\infty$ (m or rad)"),
    ("diagnostics/velocity_violation", r"$|\dot{C}|_\infty$ (m/s or rad/s)"),
)


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw two panels with logarithmic axes and a line for each result."""
    figure, axes = panels.panels(2, height=2.1)
    for axis, (path, name) in zip(axes[:, 0], ROWS, strict=True):
        for index, (result, label) in enumerate(zip(results, labels, strict=True)):
            panels.plot_log(axis, result.abscissa, result[path], label, index)
        axis.set_ylabel(name)
    return panels.finish(figure, with_legend=len(results) > 1)
