"""The violation of each joint over time, its lengths and its angles apart."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from mbproj.plot import panels, shown
from mbproj.plot.style import styled
from mbproj.results import Results

ROWS = (("violation_length", "violation (m)"), ("violation_angle", "violation (rad)"))


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """A row for lengths, a row for angles, both logarithmic; a column a result, a line a joint."""
    names, remark = shown.largest_joints(results, "joints/violation")
    figure, axes = panels.panels(2, len(results), height=2.1, share="row")
    for column, (result, label) in enumerate(zip(results, labels, strict=True)):
        for row, (member, _) in enumerate(ROWS):
            for index, name in enumerate(names):
                if name in result.names("joints"):
                    values = getattr(result.joint(name), member)
                    panels.plot_log(axes[row, column], result.time, values, name, index)
        if len(results) > 1:
            axes[0, column].set_title(panels.literal(label))
    for row, (_, unit) in enumerate(ROWS):
        axes[row, 0].set_ylabel(unit)
    return panels.finish(figure, remark=remark)
