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
    """Of the panels that are shown, each as one line."""
    return [axis.get_ylabel().replace("\n", " ") for axis in figure.axes if axis.get_visible()]


def steep(values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The pendulum's block with z from zero on and ten times as much, so that one panel shows all of a marker."""
    position, velocity = values["markers/position"], values["markers/velocity"]
    position[..., 2] = 10.0 * (position[..., 2] - position[:1, :, 2])
    velocity[..., 2] *= 10.0
    return values
