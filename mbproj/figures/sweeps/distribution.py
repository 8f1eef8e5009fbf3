"""The distribution of each measure: a histogram with its mean, deviation and quantiles."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from mbproj.arrays import Array
from mbproj.figures import panels
from mbproj.figures.style import line, page_height, page_width, print_size, styled
from mbproj.figures.sweeps.chosen import Chosen
from mbproj.figures.sweeps.scales import name
from mbproj.results.sweep.table import Column

#: The height of a single panel, and of one of several, inches.
TALL, LOW = 2.9, 2.1
#: The quantiles that are drawn.
QUANTILES = (0.05, 0.5, 0.95)
#: The fewest and the most bars of a histogram.
BARS = (8, 60)
FILL = "#A9CBE4"


def why_not(chosen: Chosen) -> str | None:
    """The reason why no distribution can be drawn: too few values. None where one can."""
    if all(np.count_nonzero(np.isfinite(measure.values)) < 2 for measure in chosen.measures):
        return "fewer than two cases have values"
    return None


@styled
def draw(chosen: Chosen) -> Figure:
    """Draw a row for each measure."""
    count = len(chosen.measures)
    figure = Figure(
        figsize=(page_width(), min(count * (TALL if count == 1 else LOW), page_height())), layout="constrained"
    )
    for axis, measure in zip(figure.subplots(count, 1, squeeze=False)[:, 0], chosen.measures, strict=True):
        _histogram(axis, chosen, measure)
    remark = chosen.remark(f"lines: {', '.join(f'{100 * share:g} %' for share in QUANTILES)} quantiles")
    return panels.finish(figure, remark=remark, with_legend=False)


def _histogram(axis: Axes, chosen: Chosen, measure: Column) -> None:
    scale, values = chosen.scaled(measure)
    values = values[chosen.independent]
    values = values[np.isfinite(values)]
    axis.set_xlabel(name(measure, page_width() - 1.0, 1))
    axis.set_ylabel("cases")
    if len(values) < 2 or np.ptp(values) == 0.0:
        said = f"all cases: {values[0]:.6g}" if len(values) else "no case has a value"
        axis.text(0.5, 0.5, said, ha="center", transform=axis.transAxes, fontsize=print_size())
        return
    axis.hist(values, bins=bars(values), color=FILL, edgecolor="#FFFFFF", linewidth=0.4)
    at = np.quantile(values, QUANTILES)
    for index, value in enumerate(at):
        axis.axvline(value, **(line(2) if index == 1 else line(1)) | {"linewidth": 1.0})
    numbers = ", ".join(_digits(value, values) for value in at)
    said = (
        f"mean {_digits(values.mean(), values)}, deviation {values.std(ddof=1):.3g}; quantiles {numbers} {scale.unit}"
    )
    axis.set_title(said, loc="left", fontsize=print_size(), pad=3)


def bars(values: Array) -> int:
    """The number of bars of a histogram, by Freedman and Diaconis' width."""
    quarter = np.subtract(*np.quantile(values, [0.75, 0.25]))
    width = 2.0 * quarter / len(values) ** (1.0 / 3.0)
    return int(np.clip(np.ptp(values) / width if width > 0.0 else BARS[0], *BARS))


def _digits(value: float, values: Array) -> str:
    """A value with enough digits to tell it apart: three of the values' deviation."""
    places = int(max(0, 2 - np.floor(np.log10(values.std(ddof=1)))))
    return f"{value:.{min(places, 12)}f}"
