"""Where the texts of a figure are: what leaves the page, and what lies over something else."""

from __future__ import annotations

from itertools import combinations

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.transforms import Bbox

#: A text with its place in pixels.
Placed = tuple[str, Bbox]
#: Pixels by which boxes of texts may overlap: letters do not fill them.
SLACK = 2.0


def texts(figure: Figure) -> list[Placed]:
    """Every text that is drawn. Drawing is what takes the time."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    drawn: list[Text] = []
    for axes in (axes for axes in figure.axes if axes.get_visible()):
        drawn += [axes.xaxis.label, axes.yaxis.label, axes.title, *axes.texts]
        drawn += [axes.xaxis.get_offset_text(), axes.yaxis.get_offset_text()]
        for axis in (axes.xaxis, axes.yaxis):
            low, high = sorted(axis.get_view_interval())
            ticks = [*axis.get_major_ticks(), *axis.get_minor_ticks()]
            drawn += [tick.label1 for tick in ticks if low <= tick.get_loc() <= high and tick.label1.get_visible()]
    for legend in [*figure.legends, *(legend for part in figure.subfigs for legend in part.legends)]:
        drawn += legend.get_texts()
    if figure._supxlabel is not None:
        drawn.append(figure._supxlabel)
    return [(text.get_text(), text.get_window_extent(renderer)) for text in drawn if text.get_text().strip()]


def outside(figure: Figure, drawn: list[Placed]) -> list[str]:
    """The texts that are not wholly on the page."""
    page = figure.bbox.padded(1.0)
    return [
        text
        for text, box in drawn
        if not (page.x0 <= box.x0 and box.x1 <= page.x1 and page.y0 <= box.y0 and box.y1 <= page.y1)
    ]


def overlapping(drawn: list[Placed]) -> list[tuple[str, str]]:
    """Pairs of texts of which one lies over the other."""
    found = []
    for (one, first), (other, second) in combinations(drawn, 2):
        wide = min(first.x1, second.x1) - max(first.x0, second.x0)
        high = min(first.y1, second.y1) - max(first.y0, second.y0)
        if wide > SLACK and high > SLACK:
            found.append((one, other))
    return found
