"""A page of bars: the change in percent of each measure where a number of the scene changes by one percent."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.figures import panels
from mbproj.figures.fitted_text import fitted
from mbproj.figures.style import line, page_width, styled
from mbproj.results.views.table import Table

#: The height of a bar and of the rest of a panel, and the room for the name of a number, inches; the most bars.
BAR, AROUND, NAME, MOST = 0.22, 0.75, 1.6, 20


@styled
def draw_sensitivities(table: Table) -> Figure:
    """Draw a panel for each measure of the table of `mbproj sensitivity`, its largest elasticity on top. A measure of 0
    has no elasticity; its panel tells so."""
    measures = list(dict.fromkeys(row[0] for row in table.rows))
    rows = {name: [row for row in table.rows if row[0] == name] for name in measures}
    heights = [AROUND + BAR * min(len(of), MOST) for of in rows.values()]
    figure = Figure(figsize=(page_width(), sum(heights)), layout="constrained")
    axes = figure.subplots(len(measures), 1, squeeze=False, height_ratios=heights)[:, 0]
    for axis, (name, of) in zip(axes, rows.items(), strict=True):
        _bars(axis, name, of)
    axes[-1].set_xlabel("elasticity: change in percent where the number changes by one percent")
    cut = max(map(len, rows.values())) - MOST
    remark = f"without the {cut} smallest of a measure" if cut > 0 else ""
    return panels.finish(figure, remark=remark, with_legend=False)


def _bars(axis: Axes, name: str, rows: list[tuple[Any, ...]]) -> None:
    """Draw the bars of one measure. The columns of `rows` are measure, number, value, slope, uncertainty, elasticity,
    unit."""
    seen = [row for row in rows if np.isfinite(row[5])][:MOST]
    axis.set_title(f"{name} = {rows[0][2]:.6g}", loc="left", fontsize=8)
    if not seen:
        axis.text(0.5, 0.5, "its value is 0: no elasticity", ha="center", va="center", transform=axis.transAxes)
        axis.set_yticks([])
        return
    values = np.array([row[5] for row in seen], dtype=float)
    colours = [line(0)["color"] if value >= 0.0 else line(1)["color"] for value in values]
    axis.barh(range(len(seen)), values, color=colours, height=0.7)
    axis.axvline(0.0, color="#444444", linewidth=0.6)
    axis.set_yticks(range(len(seen)), [fitted(row[1], NAME, 8.0) for row in seen])
    axis.invert_yaxis()
    axis.margins(x=0.05)
    axis.grid(visible=False, axis="y")
