"""Joint coordinates and their speeds over time."""

from __future__ import annotations

from collections.abc import Sequence

from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.errors import shortened
from mbproj.figures import fitting_names, rows
from mbproj.figures.differences import SIGN, coinciding
from mbproj.figures.rows import PanelGroup, PanelQuantity
from mbproj.figures.style import styled
from mbproj.figures.units import units_of
from mbproj.results import Results

#: The most names in one remark.
NAMED = 6


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw a row for each coordinate, its value beside its speed, with a line for each result. Coordinates that
    coincide are drawn once."""
    names = fitting_names.all_names(results, "coordinates")
    same = coinciding(results, names)
    groups = rows.fitting([_group(results, name) for name in same], results)
    remarks = [fitting_names.note("coordinates", len(groups), len(same), "choose others with --joint")]
    remarks += [
        f"{name} and {shortened(others, NAMED)} coincide"
        for name, others in list(same.items())[: len(groups)]
        if others
    ]
    return rows.draw(results, labels, groups, "; ".join(filter(None, remarks)))


def _group(results: Sequence[Results], name: str) -> PanelGroup:
    def value(result: Results) -> Array | None:
        return result.coordinate(name).value if name in result.names("coordinates") else None

    def speed(result: Results) -> Array | None:
        return result.coordinate(name).speed if name in result.names("coordinates") else None

    own = [result.coordinate(name) for result in results if name in result.names("coordinates")]
    units = units_of(own[0].unit, [each.value for each in own])
    row = PanelQuantity(name, units.value, value), PanelQuantity("speed", units.speed, speed)
    apart = PanelQuantity(SIGN, units.value, value), PanelQuantity(SIGN, units.speed, speed)
    return PanelGroup((row,), apart)
