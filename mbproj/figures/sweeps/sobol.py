"""Sobol' indices: the part of a measure's variance due to each quantity, alone and with its interactions."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.analysis.sensitivity import Indices, sobol_indices
from mbproj.figures import panels
from mbproj.figures.fitted_text import fitted
from mbproj.figures.style import line, styled
from mbproj.figures.sweeps import bars
from mbproj.figures.sweeps.chosen import SALTELLI, Chosen
from mbproj.results.sweep.table import Column

ALONE, WITH_OTHERS = "first order: alone", "total: with others too"
LIGHT = "#E69F00"


def why_not(chosen: Chosen) -> str | None:
    """The reason why no indices can be drawn; None where they can. They need Saltelli's design."""
    table = chosen.table
    if table.combine != SALTELLI:
        return f"the sweep combines by '{table.combine}': Sobol' indices take 'combine: saltelli'"
    if len(table.status) != table.samples * (len(_varying(chosen)) + 2):
        return "the cases are not those of Saltelli's design"
    return None


def _varying(chosen: Chosen) -> list[Column]:
    """The varied quantities in the order of the design."""
    return [column for column in chosen.table.varied if column.varies]


@styled
def draw(chosen: Chosen) -> Figure:
    """Draw a panel for each measure, the largest index at the top."""
    table, varying = chosen.table, _varying(chosen)
    figure, axes = bars.stacked(len(chosen.measures), len(varying), 1.6)
    all_indices = [sobol_indices(measure.values, table.samples) for measure in chosen.measures]
    for axis, measure, indices in zip(axes, chosen.measures, all_indices, strict=True):
        _pairs(axis, indices, varying)
        axis.set_title(fitted(measure.name, 4.5, 8.5), loc="left", pad=3)
    axes[-1].set_xlabel("share of the variance")
    fewest = min(indices.samples for indices in all_indices)
    lost = (
        f"{fewest} of {table.samples} samples: those with a failed case are left out" if fewest < table.samples else ""
    )
    return panels.finish(figure, remark=chosen.remark("whiskers: 95 % confidence (bootstrap)", lost))


def _pairs(axis: Axes, sobol: Indices, varying: list[Column]) -> None:
    order = bars.largest(sobol.total)
    places = np.arange(len(order), dtype=float)
    pairs = (
        (sobol.first, sobol.first_between, -0.18, line(0)["color"], ALONE),
        (sobol.total, sobol.total_between, 0.18, LIGHT, WITH_OTHERS),
    )
    for values, between, aside, colour, label in pairs:
        axis.barh(places + aside, np.nan_to_num(values[order]), height=0.34, color=colour, linewidth=0, label=label)
        bars.whiskers(axis, values[order], between[:, order], places + aside)
    bars.label(axis, [varying[number].name for number in order])
    axis.axvline(0.0, color="#000000", linewidth=0.7)
    ends = np.concatenate([sobol.first_between, sobol.total_between])
    axis.set_xlim(min(-0.05, 1.05 * np.nanmin(ends, initial=0.0)), 1.05 * np.nanmax(ends, initial=1.0))
