"""Polar diagrams of the joints' forces, and the forces of motions over the cycle."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.analysis.loads import loads_of, recorded_in
from mbproj.figures import fitting_names, panels
from mbproj.figures.panels import by_turns, in_degrees, label_of
from mbproj.figures.style import line, page_width, styled
from mbproj.results import Results

#: The mark where a force is largest.
DOT = {"marker": "o", "markersize": 4}
#: The height of the panel of motions, as a part of the height of the polar diagram.
BELOW = 0.55


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw the force vector of each joint in the plane in which forces vary most, with a dot where it is largest.

    A panel below shows the force or torque of each motion over the coordinate of the first motion. An angle is in
    degrees modulo a turn."""
    most = max(1, fitting_names.MAX_LINES // len(results))
    names, remark = fitting_names.largest_joints(results, "joints/reaction_force", most)
    motions = fitting_names.all_names(results, "motions")[:most]
    ratios = [1.0, BELOW] if motions else [1.0]
    figure = Figure(figsize=(page_width(), 0.65 * page_width() * sum(ratios)), layout="constrained")
    polar, *below = figure.subplots(len(ratios), 1, height_ratios=ratios, squeeze=False)[:, 0]
    _polar(polar, results, labels, names)
    for axis in below:
        _over_the_cycle(axis, results, labels, motions, len(names))
    return panels.finish(figure, remark=remark)


def _polar(axis: Axes, results: Sequence[Results], labels: Sequence[str], names: Sequence[str]) -> None:
    first, second = _plane(results, names)
    axis.set_aspect("equal", adjustable="datalim")
    for number, (result, label) in enumerate(zip(results, labels, strict=True)):
        largest = {load.name: load.time for load in loads_of(result) if load.quantity == "reaction_force"}
        for place, name in enumerate(names):
            if name not in result.names("joints"):
                continue
            force, look = result.joint(name).reaction_force, place + number * len(names)
            text = name if len(results) == 1 else f"{name}, {label}"
            panels.plot(axis, force[:, first], force[:, second], text, look)
            row = int(np.argmin(np.abs(result.time - largest.get(name, 0.0))))
            axis.plot(force[row, first], force[row, second], **(line(look) | DOT))
    axis.set_xlabel(f"reaction force, {'xyz'[first]} (N)")
    axis.set_ylabel(f"{'xyz'[second]} (N)")


def _plane(results: Sequence[Results], names: Sequence[str]) -> tuple[int, int]:
    """The two axes along which the forces vary most, in the order x, y, z."""
    spans = [
        np.ptp(result.joint(name).reaction_force, axis=0)
        for result in results
        for name in names
        if name in result.names("joints")
    ]
    first, second = sorted(np.argsort(-np.max(spans, axis=0), kind="stable")[:2].tolist())
    return first, second


def _over_the_cycle(
    axis: Axes, results: Sequence[Results], labels: Sequence[str], motions: Sequence[str], looks: int
) -> None:
    """Draw the force or torque of each motion over the coordinate of the first, with a gap where a new turn begins."""
    for number, (result, label) in enumerate(zip(results, labels, strict=True)):
        cycle = recorded_in(result).cycle()
        for place, name in enumerate(motions):
            if cycle is None or name not in result.names("motions"):
                continue
            text = f"{name} ({_unit(result, name)})" + ("" if len(results) == 1 else f", {label}")
            at, force = in_degrees(cycle.values, cycle.unit), result.motion(name).force
            line_of = by_turns(at, force) if cycle.unit == "rad" else (at, force)
            panels.plot(axis, *line_of, text, looks + place + number * len(motions))
            axis.set_xlabel(label_of(cycle.name, cycle.unit))
    axis.set_ylabel("force or torque of motions")


def _unit(result: Results, name: str) -> str:
    units = dict(zip(result.names("motions"), result.names("motion_units"), strict=True))
    return "N m" if units[name] == "rad" else "N"
