"""Position and velocity of each marker over time."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from mbproj.plot import panels, shown, untrusted
from mbproj.plot.style import styled
from mbproj.results import Results


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """One result: a row a marker, lines x, y, z. Several: a row a component, a line a result."""
    names, remark = shown.rows(results, "markers", "--marker")
    figure = _components(results[0], names) if len(results) == 1 else _overlaid(results, labels, names)
    return panels.finish(figure, remark=remark)


def mark_untrusted(figure: Figure, results: Sequence[Results], limit: float) -> str:
    """Shade each marker's panels from its own time on. What was done, in words."""
    names, _ = shown.rows(results, "markers", "--marker")
    each = len(figure.axes) // len(names)
    own = {name: figure.axes[each * k : each * (k + 1)] for k, name in enumerate(names)}
    return untrusted.shade(own, results, limit)


def _components(result: Results, names: Sequence[str]) -> Figure:
    figure, axes = panels.panels(len(names), 2)
    for (left, right), name in zip(axes, names, strict=True):
        marker = result.marker(name)
        for index, component in enumerate("xyz"):
            panels.plot(left, result.time, marker.position[:, index], component, index)
            panels.plot(right, result.time, marker.velocity[:, index], component, index)
        left.set_ylabel(panels.literal(f"position of {name} (m)"))
        right.set_ylabel(panels.literal(f"velocity of {name} (m/s)"))
    return figure


def _overlaid(results: Sequence[Results], labels: Sequence[str], names: Sequence[str]) -> Figure:
    figure, axes = panels.panels(3 * len(names), 2)
    for row, name in enumerate(names):
        block = axes[3 * row : 3 * row + 3]
        for index, (result, label) in enumerate(zip(results, labels, strict=True)):
            if name not in result.names("markers"):
                continue
            marker = result.marker(name)
            for component in range(3):
                panels.plot(block[component][0], result.time, marker.position[:, component], label, index)
                panels.plot(block[component][1], result.time, marker.velocity[:, component], label, index)
        for letter, (left, right) in zip("xyz", block, strict=True):
            left.set_ylabel(panels.literal(name) + f": ${letter}$ (m)")
            right.set_ylabel(panels.literal(name) + f": $v_{letter}$ (m/s)")
        panels.hold_still(block[:, 0])
        panels.hold_still(block[:, 1])
    return figure
