"""The paths of the markers, in the coordinate plane in which they extend most."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from mbproj.plot import panels, shown, untrusted
from mbproj.plot.style import LEGEND_HEIGHT, WIDTH, styled
from mbproj.results import Results

#: Where a path starts.
DOT: dict[str, Any] = {"marker": "o", "markersize": 3}
#: How much is left of the colour of what is not to be trusted.
PALE = 0.25


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """One panel with equal scales: a line a marker and result, a dot where it starts."""
    names, remark = shown.rows(results, "markers", "--marker")
    figure = Figure(figsize=(WIDTH, 0.8 * WIDTH + LEGEND_HEIGHT), layout="constrained")
    axis = figure.subplots()
    first, second = _plane(results, names)
    for number, (result, label) in enumerate(zip(results, labels, strict=True)):
        for place, name in enumerate(names):
            if name not in result.names("markers"):
                continue
            path, text = result.marker(name).position, name if len(results) == 1 else f"{name}, {label}"
            panels.plot(axis, path[:, first], path[:, second], text, place + number * len(names), markevery=[0], **DOT)
    axis.set_aspect("equal", adjustable="datalim")
    axis.set_xlabel(f"{'xyz'[first]} (m)")
    axis.set_ylabel(f"{'xyz'[second]} (m)")
    return panels.finish(figure, remark=remark)


def mark_untrusted(figure: Figure, results: Sequence[Results], limit: float) -> str:
    """Draw what a marker does after its own time pale. What was done, in words."""
    names, _ = shown.rows(results, "markers", "--marker")
    drawn = [(result, name) for result in results for name in names if name in result.names("markers")]
    pale = False
    for line, (result, name) in zip(list(figure.axes[0].lines), drawn, strict=True):
        since = untrusted.since(result, limit, name)
        if since is not None:
            pale, late = True, result.time >= since
            x, y = (np.asarray(values) for values in line.get_data())
            figure.axes[0].plot(x[late], y[late], color=line.get_color(), alpha=PALE, linewidth=0.8)
            line.set_data(np.where(late, np.nan, x), np.where(late, np.nan, y))
    return f"pale: {untrusted.exceeds(limit)}" if pale else ""


def _plane(results: Sequence[Results], names: Sequence[str]) -> tuple[int, int]:
    """The two axes along which the markers travel most, in the order x, y, z."""
    travelled = [
        np.ptp(result.marker(name).position, axis=0)
        for result in results
        for name in names
        if name in result.names("markers")
    ]
    extent = np.max(travelled, axis=0)
    first, second = sorted(np.argsort(-extent, kind="stable")[:2].tolist())
    return first, second
