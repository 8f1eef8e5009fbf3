"""Pictures of linear models: modes, by eigenvalues, shapes and traces over a parameter, and Bode diagrams."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.base.arrays import Array, Numbers
from mbproj.results.linear_files import StoredModel, StoredModes
from mbproj.show.figures import panels
from mbproj.show.figures.fitted_text import literal
from mbproj.show.figures.style import AXIS_HEIGHT, line, page_width, styled

# --- Modes: eigenvalues in the complex plane, shapes by joint coordinate and body, traces over a parameter ------------

#: The most modes whose shapes are drawn, and the most bars of one shape.
MOST_SHAPES, MOST_BARS = 8, 12
HEIGHT = 3.0
#: Dots closer than these parts of the panel, across and upward, share one label.
CLOSE = np.array([0.05, 0.055])
#: Components of a shape below this part of the largest are not listed. On the side of the stability line without dots,
#: this part of the other side's width is shown.
SEEN, BESIDE = 0.02, 0.08


@styled
def eigenvalues(modes: StoredModes) -> Figure:
    """Draw a dot for each mode: growth to the right, frequency upward. Numbers are those of the table."""
    figure = Figure(figsize=(page_width(), HEIGHT + AXIS_HEIGHT), layout="constrained")
    axis = figure.subplots()
    axis.axvline(0.0, color="#777777", linewidth=0.8)
    axis.plot(modes.eigenvalue.real, modes.frequency, "o", markersize=4, color=line(0)["color"])
    axis.set(xlabel="growth rate Re λ (1/s)", ylabel="frequency |Im λ| / 2π (Hz)")
    _room(axis, modes.eigenvalue.real, modes.frequency)
    for place, numbers in _labelled(axis, modes.eigenvalue.real, modes.frequency):
        axis.annotate(_number_ranges(numbers), place, (5, 0), textcoords="offset points", va="center", fontsize=7)
    return panels.finish(figure, remark=_remark(modes), with_legend=False)


@styled
def shapes(modes: StoredModes) -> Figure:
    """Draw a row for each mode. Left: the joint coordinates relative to the largest, in phase or opposite; where none
    moves, the displacements of bodies. Right: the parts of its kinetic energy."""
    count = min(len(modes.eigenvalue), MOST_SHAPES)
    figure = Figure(figsize=(page_width(), max(1, count) * 1.3 + AXIS_HEIGHT), layout="constrained")
    axes = figure.subplots(max(1, count), 2, squeeze=False)
    for mode in range(count):
        left, right = axes[mode]
        change, moving = modes.coordinate_shape[mode], modes.coordinates
        if not np.abs(change).any():
            change, moving = _of_bodies(modes, mode)
        if not np.abs(change).any():
            left.text(0.5, 0.5, "no body moves", ha="center", transform=left.transAxes, fontsize=7)
        else:
            largest = change[int(np.argmax(np.abs(change)))]
            _bars(left, moving, (change / largest).real)
            left.set_xlim(-1.05, 1.05)
        _bars(right, modes.kinetic_names, modes.kinetic_share[mode])
        right.set_xlim(0.0, 1.05)
        value = modes.eigenvalue[mode]
        left.set_ylabel(f"mode {mode + 1}\n{modes.frequency[mode]:.4g} Hz\n{value.real:.3g}/s", rotation=0, ha="right")
    of_joints = np.abs(modes.coordinate_shape[:count]).any(axis=1)
    words = {"joint coordinates": of_joints.any(), "shifts and turns of bodies": not of_joints.all()}
    axes[-1][0].set_xlabel(f"{' or '.join(word for word, is_used in words.items() if is_used)}, relative")
    axes[-1][1].set_xlabel("parts of the kinetic energy")
    left_out = len(modes.eigenvalue) - count
    remark = f"more modes in the file: {left_out}" if left_out else ""
    return panels.finish(figure, remark="; ".join(filter(None, (remark, _remark(modes)))), with_legend=False)


@styled
def traces(modes: StoredModes) -> Figure:
    """Draw frequencies and growth rates over the parameter (Campbell diagram), and the root locus below."""
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
MODES_PICTURES: Mapping[str, Callable[[StoredModes], Figure]] = MappingProxyType(
    {"eigenvalues": eigenvalues, "shapes": shapes, "traces": traces}
)


def why_not(kind: str, modes: StoredModes) -> str | None:
    """The reason why a picture does not apply; None where it does."""
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


def _of_bodies(modes: StoredModes, mode: int) -> tuple[Numbers, list[str]]:
    """The largest displacements and rotations of bodies in a mode. Rotations count at an arm of a tenth of the bodies'
    spread."""
    arm = 0.1 * float(np.linalg.norm(np.ptp(modes.position, axis=0))) or 0.1
    scaled = modes.displacement[mode] * ([1.0] * 3 + [arm] * 3)
    names = [f"{body} {word} {axis}" for body in modes.bodies for word in ("along", "about") for axis in "xyz"]
    change = scaled.reshape(-1)
    seen = np.flatnonzero(np.abs(change) >= SEEN * np.abs(change).max(initial=0.0))
    return change[seen], [names[index] for index in seen]


def _labelled(axis: Axes, across: Array, upward: Array) -> Iterator[tuple[tuple[float, float], list[int]]]:
    """Yield the place of each label and the numbers of its modes. Modes whose dots are close share one label."""
    (left, right), (low, high) = axis.get_xlim(), axis.get_ylim()
    places = np.column_stack([(across - left) / (right - left), (upward - low) / (high - low)])
    groups: list[list[int]] = []
    for index, place in enumerate(places):
        near = next((group for group in groups if (np.abs(places[group[-1]] - place) < CLOSE).all()), None)
        if near is None:
            groups.append([index])
        else:
            near.append(index)
    for group in groups:
        last = group[int(np.argmax(across[group]))]
        middle = float(np.mean(upward[group]))
        yield (float(across[last]), middle), [index + 1 for index in group]


def _number_ranges(numbers: Sequence[int]) -> str:
    """The numbers as a text: 1, 2, 3, 5 becomes 1-3, 5."""
    runs: list[list[int]] = []
    for number in numbers:
        if runs and number == runs[-1][-1] + 1:
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(f"{run[0]}-{run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs)


def _room(axis: Axes, *spans: Array) -> None:
    """Set limits around the dots, with some of the empty side of the stability line, also where one direction is only
    round-off."""
    across, upward = (span[np.isfinite(span)] for span in spans)
    least = max(1e-3 * float(np.abs(upward).max(initial=0.0)), 1e-12)
    low, high = min(float(across.min(initial=0.0)), -least), max(float(across.max(initial=0.0)), least)
    low, high = min(low, -BESIDE * high), max(high, -BESIDE * low)
    axis.set_xlim(low - 0.08 * (high - low), high + 0.08 * (high - low))
    axis.margins(y=0.08)


def _remark(modes: StoredModes) -> str:
    where = modes.where if modes.where.isalpha() else f"t = {modes.time:.6g} s"
    return f"{modes.title or 'modes'}, at {where}"


# --- Bode diagrams of a linear model ----------------------------------------------------------------------------------
# Gain and phase of every output over the frequency of every input.


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
MODEL_PICTURES: Mapping[str, Callable[[StoredModel], Figure]] = MappingProxyType({"bode": bode})
