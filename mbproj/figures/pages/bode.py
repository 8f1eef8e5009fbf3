"""Bode diagrams of a linear model: gain and phase of every output over the frequency of every input."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from matplotlib.figure import Figure

from mbproj.arrays import Array, Numbers
from mbproj.figures import panels
from mbproj.figures.fitted_text import literal
from mbproj.figures.style import AXIS_HEIGHT, line, page_width, styled
from mbproj.results.linear.model_file import StoredModel

#: The points of a curve, the most lines in a picture, and the decades beyond the slowest and the fastest mode.
POINTS, MOST_LINES, DECADES = 600, 14, 1.0


def frequencies(model: StoredModel) -> Array:
    """Frequencies in Hz, from a decade below the slowest mode to a decade above the fastest."""
    speeds = np.abs(np.linalg.eigvals(model.A)) / (2.0 * np.pi)
    moving = speeds[speeds > 1e-9 * max(float(speeds.max(initial=0.0)), 1e-300)]
    low, high = (float(moving.min()), float(moving.max())) if len(moving) else (0.1, 10.0)
    return np.logspace(np.log10(low) - DECADES, np.log10(high) + DECADES, POINTS)


def response(model: StoredModel, frequency: Array) -> Numbers:
    """The frequency response C (iω - A)⁻¹ B + D at each frequency in Hz, (F, outputs, inputs)."""
    at = 2j * np.pi * frequency[:, None, None] * np.eye(len(model.A)) - model.A
    return model.C @ np.linalg.solve(at, np.broadcast_to(model.B, (len(frequency), *model.B.shape))) + model.D


@styled
def bode(model: StoredModel) -> Figure:
    """Draw a line for each pair of an input and an output."""
    frequency = frequencies(model)
    gains = response(model, frequency)
    figure = Figure(figsize=(page_width(), 2 * 2.2 + AXIS_HEIGHT), layout="constrained")
    gain, phase = figure.subplots(2, 1, sharex=True)
    pairs = [(row, column) for row in range(len(model.outputs)) for column in range(len(model.inputs))]
    for number, (row, column) in enumerate(pairs[:MOST_LINES]):
        values = gains[:, row, column]
        unit = f"{model.output_units[row]} per {model.input_units[column]}"
        label = literal(f"{model.outputs[row]} by {model.inputs[column]} ({unit})")
        size = np.abs(values)
        gain.plot(frequency, np.where(size > 0.0, size, np.nan), label=label, **line(number))
        phase.plot(frequency, np.degrees(np.unwrap(np.angle(values))), **line(number))
    gain.set(xscale="log", yscale="log", ylabel="gain")
    phase.set(ylabel="phase (degrees)", xlabel="frequency (Hz)")
    left = len(pairs) - MOST_LINES
    where = model.where if model.where.isalpha() else f"t = {model.time:.6g} s"
    remark = f"{model.title or 'linear model'}, at {where}" + (
        f"; pairs that are not drawn: {left}" if left > 0 else ""
    )
    return panels.finish(figure, remark=remark)


#: The pictures by name.
PICTURES: Mapping[str, Callable[[StoredModel], Figure]] = MappingProxyType({"bode": bode})
