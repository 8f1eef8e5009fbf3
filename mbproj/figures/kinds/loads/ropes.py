"""The length of each rope over time, and the tensions of its portions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from mbproj.figures import rows, shown
from mbproj.figures.differences import SIGN
from mbproj.figures.kinds.driven import DatasetColumns
from mbproj.figures.rows import PanelGroup, PanelQuantity, Row
from mbproj.figures.style import styled
from mbproj.figures.units import AxisUnit, units_of
from mbproj.results import Results

TENSION = AxisUnit("N", "N")


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw the length of each rope, and the tensions of its portions: a row for each rope, or, with several results, a
    row for each portion."""
    names = shown.all_names(results, "tensions")
    ropes = list(dict.fromkeys(name.rpartition(".")[0] for name in names))
    own = [tuple(name for name in names if name.rpartition(".")[0] == rope) for rope in ropes]
    groups = rows.fitting([_of(results, *each) for each in zip(ropes, own, strict=True)], results)
    return rows.draw(results, labels, groups, shown.cut("ropes", len(groups), len(ropes), "`mbproj export` writes all"))


def _of(results: Sequence[Results], rope: str, names: tuple[str, ...]) -> PanelGroup:
    read = DatasetColumns("coordinates", (f"{rope}.length",), "coordinate")
    pulls = DatasetColumns("tensions", names, "tension")
    unit = units_of("m", [np.asarray(values) for result in results if (values := read(result)) is not None]).value
    length = PanelQuantity(f"{rope}: length", unit, read)
    if len(names) == 1 or len(results) == 1:
        lines = tuple((name, number) for number, name in enumerate(names)) if len(names) > 1 else ()
        listed: list[Row] = [(length, PanelQuantity("tension", TENSION, pulls, lines))]
    else:
        each = [PanelQuantity(name, TENSION, DatasetColumns("tensions", (name,), "tension")) for name in names]
        listed = [(length, each[0]), *((None, other) for other in each[1:])]
    return PanelGroup(tuple(listed), (PanelQuantity(SIGN, unit, read), PanelQuantity(SIGN, TENSION, pulls)))
