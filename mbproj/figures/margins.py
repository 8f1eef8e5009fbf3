"""The legend above the panels and the small print below them. The figure grows by their height."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil
from typing import Any

from matplotlib.figure import Figure, SubFigure

from mbproj.figures.fitted_text import fitted, width
from mbproj.figures.style import STYLE, legend_size, print_size, styled

#: The free width at both sides of the page together, inches.
SIDES = 0.3
#: The height of a line of text, in font sizes.
LINE = 1.3
#: The most lines of one remark, and of one label in the legend.
MOST_LINES, MOST_LEGEND_LINES = 4, 2
#: The width beside the text of a legend's entry, in font sizes: the line sample, its gap, and the gap of columns.
BESIDE = STYLE["legend.handlelength"] + 0.8 + STYLE["legend.columnspacing"]


@styled
def small_print(figure: Figure, text: str) -> None:
    """Put `text` below the panels, above earlier small print. An empty text does nothing."""
    if not text:
        return
    lines = fitted(text, figure.get_figwidth() - SIDES, print_size(), MOST_LINES)
    below = figure.get_supxlabel()
    figure.supxlabel(f"{lines}\n{below}" if below else lines, fontsize=print_size(), color="#555555")
    _grow(figure, len(lines.split("\n")) * LINE * print_size() / 72.0)


@styled
def put_legend(figure: Figure | SubFigure, entries: Mapping[str, Any]) -> None:
    """Put a legend above the panels, from handles by label, in as many columns as fit."""
    if not entries:
        return
    whole = figure.get_figure(root=True) if isinstance(figure, SubFigure) else figure
    assert whole is not None
    room, beside = whole.get_figwidth() - SIDES, BESIDE * legend_size() / 72.0
    texts = [_entry(label, room - beside) for label in entries]
    widest = max(width(line, legend_size()) for text in texts for line in text.split("\n"))
    columns = max(1, min(len(texts), int(room / (widest + beside))))
    columns = ceil(len(texts) / ceil(len(texts) / columns))
    figure.legend(list(entries.values()), texts, loc="outside upper center", ncols=columns)
    lines = max(text.count("\n") + 1 for text in texts) * ceil(len(texts) / columns)
    _grow(whole, (1.5 * lines + 0.5) * legend_size() / 72.0)


def _entry(label: str, room: float) -> str:
    """The label as the legend shows it. A label with mathematics is one of mbproj's and short, so that it is not
    wrapped."""
    plain = label.replace(r"\$", "")
    return label if "$" in plain else fitted(label.replace(r"\$", "$"), room, legend_size(), MOST_LEGEND_LINES)


def _grow(figure: Figure, height: float) -> None:
    figure.set_figheight(figure.get_figheight() + height)
