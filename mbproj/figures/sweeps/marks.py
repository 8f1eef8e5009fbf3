"""The marks of failed cases."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes

from mbproj.arrays import Array

FAILED = "failed"
CROSS: dict[str, Any] = {
    "marker": "x",
    "markersize": 4.5,
    "markeredgewidth": 1.1,
    "color": "#D55E00",
    "linestyle": "none",
    "zorder": 3,
}


def crosses(axis: Axes, x: Array, y: Array) -> None:
    """Draw a cross for each failed case, if there are any."""
    if len(x):
        axis.plot(x, y, label=FAILED, **CROSS)


def crosses_below(axis: Axes, x: Array) -> None:
    """Draw crosses at the lower edge, for cases without a value."""
    if len(x):
        axis.plot(x, [0.03] * len(x), label=FAILED, transform=axis.get_xaxis_transform(), clip_on=False, **CROSS)
