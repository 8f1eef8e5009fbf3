"""The forces, torques and power of actuators along a motion."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.figures import panels
from mbproj.figures.panels import by_turns, in_degrees, label_of
from mbproj.figures.style import styled
from mbproj.figures.units import tick_degrees
from mbproj.results.loads.largest import Cycle

#: The words on the panels, by unit.
WORDS = {"N": "force", "N m": "torque"}


@styled
def draw_actuators(
    time: Array, names: Sequence[str], units: Sequence[str], force: Array, power: Array, over: Cycle | None, remark: str
) -> Figure:
    """Draw a panel of forces (T, k), one of torques and one of power, as far as there are any. The axis is time in s,
    or a coordinate; an angle is in degrees modulo a turn."""
    kinds = [unit for unit in WORDS if unit in units]
    figure, axes = panels.panels(len(kinds) + 1, height=2.1)
    at = time if over is None else in_degrees(over.values, over.unit)
    for place, name in enumerate(names):
        for axis, values in ((axes[kinds.index(units[place]), 0], force), (axes[-1, 0], power)):
            line = (at, values[:, place]) if over is None else by_turns(at, values[:, place])
            panels.plot(axis, *line, name, place)
    for axis, unit in zip(axes[:, 0], [*kinds, "W"], strict=True):
        panels.name(axis, WORDS.get(unit, "power"), unit)
    if over is not None:
        axes[-1, 0].set_xlabel(label_of(over.name, over.unit))
        if over.unit == "rad":
            tick_degrees(axes[-1, 0], along_x=True)
    return panels.finish(figure, remark=remark)
