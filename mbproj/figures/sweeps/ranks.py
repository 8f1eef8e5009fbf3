"""Rank correlations of the measures with the varied quantities, as a tornado chart."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.analysis.sensitivity import rank_correlation, rank_interval
from mbproj.figures import panels
from mbproj.figures.fitted_text import fitted
from mbproj.figures.style import line, styled
from mbproj.figures.sweeps import bars
from mbproj.figures.sweeps.chosen import Chosen
from mbproj.results.sweep.layout import SAMPLED
from mbproj.results.sweep.table import Column

#: The fewest cases that tell something.
FEWEST = 4


def why_not(chosen: Chosen) -> str | None:
    """The reason why no ranks can be drawn; None where they can."""
    if not chosen.numbers:
        return "no number varies"
    if max(np.count_nonzero(np.isfinite(measure.values)) for measure in chosen.measures) < FEWEST:
        return f"fewer than {FEWEST} cases have values"
    return None


@styled
def draw(chosen: Chosen) -> Figure:
    """Draw a panel for each measure, the strongest correlation at the top."""
    figure, axes = bars.stacked(len(chosen.measures), len(chosen.numbers))
    for axis, measure in zip(axes, chosen.measures, strict=True):
        _tornado(axis, chosen, measure)
    axes[-1].set_xlabel("Spearman's rank correlation")
    sampled = chosen.table.combine in SAMPLED
    words = sum(not column.is_number for column in chosen.over)
    return panels.finish(
        figure,
        remark=chosen.remark(
            "whiskers: 95 % confidence" if sampled else "",
            f"left out: {words} that vary and are no numbers" if words else "",
        ),
        with_legend=False,
    )


def _tornado(axis: Axes, chosen: Chosen, measure: Column) -> None:
    known = np.isfinite(measure.values[chosen.independent])
    y = measure.values[chosen.independent][known]
    correlations = np.array([rank_correlation(each.values[chosen.independent][known], y) for each in chosen.numbers])
    order = bars.largest(correlations)
    shown, places = correlations[order], np.arange(len(order), dtype=float)
    colours = [line(0)["color"] if value >= 0.0 else line(1)["color"] for value in shown]
    axis.barh(places, np.nan_to_num(shown), height=0.66, color=colours, linewidth=0)
    if chosen.table.combine in SAMPLED:
        between = np.array([rank_interval(value, len(y)) for value in shown]).T
        bars.whiskers(axis, shown, between, places)
    bars.label(axis, [chosen.numbers[number].name for number in order])
    axis.axvline(0.0, color="#000000", linewidth=0.7)
    axis.set_xlim(-1.05, 1.05)
    axis.set_title(fitted(measure.name, 4.5, 8.5), loc="left", pad=3)
