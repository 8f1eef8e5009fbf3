"""What stands in a figure: lines by their labels, the legend, the labels of the axes."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure


def lines(axis: Axes) -> dict[str, np.ndarray]:
    return {line.get_label(): line.get_ydata() for line in axis.lines}


def legend(figure: Figure) -> list[str]:
    return [text.get_text() for shown in figure.legends for text in shown.get_texts()]


def ylabels(figure: Figure) -> list[str]:
    return [axis.get_ylabel() for axis in figure.axes]
