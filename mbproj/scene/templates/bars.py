"""Bars that hang on each other: chains and trees, in a plane or in space."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from mbproj.templates.pendulum import closed_and_kept
from mbproj.templates.values import Values

CHAIN = {"links": "5", "length": "1 m", "mass": "1 kg", "angle": "60 deg"}
TREE = {"links": "7", "length": "1 m", "mass": "1 kg", "angle": "30 deg"}

#: Settings that suit any number of bars of any length.
SIMULATION = (
    "simulation:",
    "  duration: 15 * sqrt(length / g)        # a few swings of one bar",
    "  tolerance: 1.0e-9",
    "  integrator: dop853",
    "  output_step: 0.015 * sqrt(length / g)",
)


class _Bar(NamedTuple):
    """A bar: its parent's number (-1: the ground); the side to which it leans (+1 or -1); how many joints are above its
    own; the place of its upper end, in units of the parameters `across` and `down`."""

    parent: int
    side: int
    depth: int
    across: int
    down: int


def chain(values: Values, spatial: bool) -> Iterator[str]:
    """Yield the lines of a chain: bars in a row."""
    links = values.count("links")
    yield "# Bars in a row, the first on the ground, straight at the start. The motion is chaotic: look at when two"
    yield "# runs with different tolerances part (mbproj compare-results)."
    yield from _scene("Chain", values, _placed_bars([(number - 1, 1) for number in range(links)]), spatial)
    yield "  stretched: {marker: end, quantity: position, component: norm, at: maximum, source: the bars are rigid,"
    yield "              below: reach * (1 + 1e-12)}"


def tree(values: Values, spatial: bool) -> Iterator[str]:
    """Yield the lines of a binary tree of bars."""
    links = values.count("links")
    yield "# A binary tree: two bars hang on the end of each, one to either side."
    family = [((number - 1) // 2, 1 if number % 2 == 0 else -1) for number in range(links)]
    yield from _scene("Tree", values, _placed_bars(family), spatial)


def _placed_bars(family: Iterable[tuple[int, int]]) -> list[_Bar]:
    """The bars with their places, from the (parent, side) of each; a parent stands before its children."""
    bars: list[_Bar] = []
    for parent, side in family:
        above = bars[parent] if parent >= 0 else None
        bars.append(
            _Bar(parent, side, 0, 0, 0)
            if above is None
            else _Bar(parent, side, above.depth + 1, above.across + above.side, above.down + 1)
        )
    return bars


def _scene(title: str, values: Values, bars: list[_Bar], spatial: bool) -> Iterator[str]:
    where = "in space" if spatial else "in a plane"
    yield from ("mbproj: 1", f"title: {title} of {len(bars)} {where}", "gravity: [0, 0, -g]", "parameters:")
    yield "  g: 9.81 m/s^2"
    yield from values.parameters("length", "mass", "angle")
    yield "  radius: length / 50                    # of the bars"
    yield "  across: length * sin(angle)            # from one end of a bar to the other"
    yield "  down: length * cos(angle)"
    levels = 1 + max(bar.depth for bar in bars)
    yield f"  reach: {levels} * length".ljust(41) + "# of as many bars as hang on each other"
    yield f"  energy: {len(bars)} * mass * g * reach".ljust(41) + "# J, of the size of what the run exchanges"
    if spatial and levels > 1:
        kick = f"  kick: 0.3 * sqrt(g / reach) / {levels // 2}".ljust(41)
        yield f"{kick}# of every second joint at the start, out of the plane"
    yield from SIMULATION
    yield "bodies:                                  # a bar's axis is its body x, which points to its lower end"
    for number, bar in enumerate(bars):
        x, z = bar.across + bar.side / 2, bar.down + 0.5
        yield f"  bar{number + 1}:"
        yield "    mass: mass"
        yield "    shape: {cylinder: {radius: radius, length: length, axis: x}}"
        yield f"    position: [{x:g} * across, 0, -{z:g} * down]"
        yield f"    orientation: {{axis: [0, 1, 0], angle: 90 deg {'-' if bar.side > 0 else '+'} angle}}"
    yield "joints:"
    for number, bar in enumerate(bars):
        yield from _pin(number, bar, spatial)
    last = len(bars)
    yield "markers:"
    yield f"  end: {{body: bar{last}, location: {{bar{last}: [length/2, 0, 0]}}}}"
    yield "expect:"
    yield from closed_and_kept("1.0e-8", "energy", levels * values.number["length"])


def _pin(number: int, bar: _Bar, spatial: bool) -> Iterator[str]:
    """Yield the lines of the joint of a bar. It turns about y; in space every second one turns about the bar's normal
    in the x-z plane."""
    out_of_plane = spatial and bar.depth % 2 == 1
    normal = f"[cos(angle), 0, {'' if bar.side > 0 else '-'}sin(angle)]"
    axis = f"{normal}, speed: kick" if out_of_plane else "[0, 1, 0]"
    parent = f"bar{bar.parent + 1}" if bar.parent >= 0 else "ground"
    yield f"  pin{number + 1}: {{type: revolute, bodies: [{parent}, bar{number + 1}],"
    yield f"    location: [{bar.across} * across, 0, -{bar.down} * down], axis: {axis}}}"
