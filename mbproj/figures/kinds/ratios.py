"""Velocity ratios and mechanical advantages of joint coordinates to an input, and transmission angles."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from mbproj.analysis.observed import mechanical_advantage, transmission_angle, velocity_ratio
from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.figures import fitting_names, rows
from mbproj.figures.margins import small_print
from mbproj.figures.rows import PanelGroup, PanelQuantity
from mbproj.figures.style import styled
from mbproj.figures.units import DEGREES, AxisUnit
from mbproj.results import Results

#: A mechanical advantage is cut off at this multiple of its median, because it is infinite at a dead centre.
CUT = 20.0


@dataclass(frozen=True)
class _Ratio:
    """A reader of a ratio (T,) of a coordinate to the input; None where a result lacks either."""

    output: str
    forces: bool

    def __call__(self, result: Results) -> Array | None:
        if self.output not in result.names("coordinates") or result.shown_over is None:
            return None
        pair = result.coordinate(self.output).speed, result.shown_over.rate
        if not self.forces:
            return velocity_ratio(*pair)
        advantage = mechanical_advantage(*pair)
        finite = np.isfinite(advantage)
        most = CUT * float(np.median(np.abs(advantage[finite]))) if finite.any() else np.inf
        return np.where(np.abs(advantage) <= most, advantage, np.nan)


@styled
def draw_ratios(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw a row for each joint coordinate: its velocity ratio to the input, and the mechanical advantage."""
    over = next(result.shown_over for result in results if result.shown_over is not None)
    names = [name for name in fitting_names.all_names(results, "coordinates") if name != over.name]
    groups = rows.fitting([_group(results, name, over.unit) for name in names], results)
    cut = fitting_names.note("coordinates", len(groups), len(names), "choose others with --joint")
    said = f"gaps of the mechanical advantage: more than {CUT:g} times its median, near a dead centre"
    return rows.draw(results, labels, groups, "; ".join(filter(None, [cut, said])))


def _group(results: Sequence[Results], name: str, input_unit: str) -> PanelGroup:
    unit = next(result.coordinate(name).unit for result in results if name in result.names("coordinates"))
    alike = unit == input_unit
    of_speeds, of_forces = ("", "") if alike else ("m/rad", "rad/m") if unit == "m" else ("rad/m", "m/rad")
    ratio = PanelQuantity(f"{name}: velocity ratio", AxisUnit(of_speeds, ""), _Ratio(name, False), held=False)
    advantage = PanelQuantity("mechanical advantage", AxisUnit(of_forces, ""), _Ratio(name, True), held=False)
    return PanelGroup(((ratio, advantage),))


@dataclass(frozen=True)
class _Angle:
    """A reader of a transmission angle (T,); None where a result lacks one of the markers."""

    corners: tuple[str, str, str]

    def __call__(self, result: Results) -> Array | None:
        if not set(self.corners) <= set(result.names("markers")):
            return None
        return transmission_angle(*(result.marker(name).position for name in self.corners))


@styled
def draw_transmission(
    results: Sequence[Results], labels: Sequence[str], corners: Sequence[tuple[str, str, str]]
) -> Figure:
    """Draw a row for each transmission angle, in degrees from 0 to 90."""
    groups = [
        PanelGroup(
            ((PanelQuantity(f"at {own[1]}, to {own[0]} and {own[2]}", DEGREES.value, _Angle(own), held=False),),)
        )
        for own in corners
    ]
    figure = rows.draw(results, labels, rows.fitting(groups, results))
    for axis in figure.axes:
        axis.set_ylim(0.0, 90.0)
        axis.set_yticks([0.0, 30.0, 60.0, 90.0])
    small_print(figure, "transmission angle: 90° is best; below about 40° a mechanism tends to jam")
    return figure
