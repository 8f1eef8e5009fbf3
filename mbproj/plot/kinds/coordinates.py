"""Joint coordinates and their speeds over time."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from mbproj.plot import panels, shown
from mbproj.plot.style import styled
from mbproj.results import Results


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """A row a coordinate, value and speed side by side, a line a result."""
    names, remark = shown.rows(results, "coordinates", "--joint")
    figure, axes = panels.panels(len(names), 2)
    for (left, right), name in zip(axes, names, strict=True):
        for index, (result, label) in enumerate(zip(results, labels, strict=True)):
            if name in result.names("coordinates"):
                coordinate = result.coordinate(name)
                panels.plot(left, result.time, coordinate.value, label, index)
                panels.plot(right, result.time, coordinate.speed, label, index)
                left.set_ylabel(panels.literal(f"{name} ({coordinate.unit})"))
                right.set_ylabel(f"speed ({coordinate.unit}/s)")
    units = [left.get_ylabel().rpartition("(")[2] for left in axes[:, 0]]
    for unit in set(units):
        for column in (0, 1):
            panels.hold_still([axes[row, column] for row, own in enumerate(units) if own == unit])
    return panels.finish(figure, remark=remark, with_legend=len(results) > 1)
