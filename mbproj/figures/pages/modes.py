"""Pictures of modes: eigenvalues in the complex plane, shapes by joint coordinate and body, traces over a parameter."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.figures import panels
from mbproj.figures.style import AXIS_HEIGHT, line, page_width, styled
from mbproj.figures.words import literal
from mbproj.results.linear.modes_file import StoredModes

#: Modes whose shapes are drawn, and bars in one of them.
MOST_SHAPES, MOST_BARS = 8, 12
HEIGHT = 3.0


@styled
def eigenvalues(modes: StoredModes) -> Figure:
    """A dot for each mode: growth to the right, frequency upwards; numbers are those of the table."""
    figure = Figure(figsize=(page_width(), HEIGHT + AXIS_HEIGHT), layout="constrained")
    axis = figure.subplots()
    axis.axvline(0.0, color="#777777", linewidth=0.8)
    axis.plot(modes.eigenvalue.real, modes.frequency, "o", markersize=4, color=line(0)["color"])
    for number, (value, frequency) in enumerate(zip(modes.eigenvalue, modes.frequency, strict=True), start=1):
        axis.annotate(f" {number}", (float(value.real), float(frequency)), fontsize=7)
    axis.set(xlabel="growth rate Re λ (1/s)", ylabel="frequency |Im λ| / 2π (Hz)")
    _room(axis, modes.eigenvalue.real, modes.frequency)
    return panels.finish(figure, remark=_remark(modes), with_legend=False)


@styled
def shapes(modes: StoredModes) -> Figure:
    """One row a mode. Left: how far each joint coordinate moves beside the largest, in phase or against it. Right: the
    parts of its kinetic energy."""
    count = min(len(modes.eigenvalue), MOST_SHAPES)
    figure = Figure(figsize=(page_width(), max(1, count) * 1.3 + AXIS_HEIGHT), layout="constrained")
    axes = figure.subplots(max(1, count), 2, squeeze=False)
    for mode in range(count):
        left, right = axes[mode]
        change = modes.coordinate_shape[mode]
        if not np.abs(change).any():
            left.text(0.5, 0.5, "no joint coordinate moves", ha="center", transform=left.transAxes, fontsize=7)
        else:
            largest = change[int(np.argmax(np.abs(change)))]
            _bars(left, modes.coordinates, (change / largest).real)
            left.set_xlim(-1.05, 1.05)
        _bars(right, modes.kinetic_names, modes.kinetic_share[mode])
        right.set_xlim(0.0, 1.05)
        value = modes.eigenvalue[mode]
        left.set_ylabel(f"mode {mode + 1}\n{modes.frequency[mode]:.4g} Hz\n{value.real:.3g}/s", rotation=0, ha="right")
    axes[-1][0].set_xlabel("joint coordinates, relative")
    axes[-1][1].set_xlabel("parts of the kinetic energy")
    left_out = len(modes.eigenvalue) - count
    remark = f"more modes in the file: {left_out}" if left_out else ""
    return panels.finish(figure, remark="; ".join(filter(None, (remark, _remark(modes)))), with_legend=False)


@styled
def traces(modes: StoredModes) -> Figure:
    """Frequencies and growth rates over the parameter (Campbell's diagram), and the root locus below."""
    figure = Figure(figsize=(page_width(), 3 * 1.9 + AXIS_HEIGHT), layout="constrained")
    frequency, growth, locus = figure.subplots(3, 1)
    growth.sharex(frequency)
    for number in range(modes.trace.shape[1]):
        values = modes.trace[:, number]
        look = line(number)
        frequency.plot(modes.trace_value, np.abs(values.imag) / (2.0 * np.pi), **look)
        growth.plot(modes.trace_value, values.real, **look)
        locus.plot(values.real, values.imag, marker="o", markersize=2, **look)
    name = literal(modes.varied[0])
    frequency.set_ylabel("frequency (Hz)")
    growth.set(ylabel="growth rate (1/s)", xlabel=name)
    locus.set(xlabel="Re λ (1/s)", ylabel="Im λ (rad/s)")
    for axis in (growth, locus):
        axis.margins(0.03, 0.06)
    locus.axvline(0.0, color="#777777", linewidth=0.8)
    _room(locus, modes.trace.real, modes.trace.imag)
    return panels.finish(figure, remark=f"{_remark(modes)}; a line a mode", with_legend=False)


#: The pictures by name.
PICTURES: Mapping[str, Callable[[StoredModes], Figure]] = MappingProxyType(
    {"eigenvalues": eigenvalues, "shapes": shapes, "traces": traces}
)


def why_not(kind: str, modes: StoredModes) -> str | None:
    """Why a picture does not apply; None where it does."""
    if kind == "traces" and not len(modes.trace_value):
        return "no parameter was varied: mbproj modes --vary"
    if kind != "traces" and not len(modes.eigenvalue):
        return "the mechanism has no modes"
    return None


def _bars(axis: Axes, names: Sequence[str], values: Array) -> None:
    order = np.sort(np.argsort(-np.abs(values), kind="stable")[:MOST_BARS])
    axis.barh(range(len(order)), values[order], height=0.7, color=line(0)["color"])
    axis.set_yticks(range(len(order)), [literal(names[index]) for index in order], fontsize=6)
    axis.invert_yaxis()


def _room(axis: Axes, *spans: Array) -> None:
    """Room around what is drawn, also where all of it is round-off beside the other direction."""
    across, upward = (span[np.isfinite(span)] for span in spans)
    size = max(float(np.abs(across).max(initial=0.0)), 1e-3 * float(np.abs(upward).max(initial=0.0)), 1e-12)
    axis.set_xlim(-1.15 * size, 1.15 * size)
    axis.margins(y=0.08)


def _remark(modes: StoredModes) -> str:
    where = modes.where if modes.where.isalpha() else f"t = {modes.time:.6g} s"
    return f"{modes.title or 'modes'}, at {where}"
