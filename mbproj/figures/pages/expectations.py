"""A picture of many expectations: the part of its allowed error that each uses, the largest on top."""

from __future__ import annotations

from collections.abc import Mapping

from matplotlib.figure import Figure

from mbproj.figures import panels
from mbproj.figures.fitted_text import fitted
from mbproj.figures.style import line, page_width, styled

#: The height of a row and of the rest, and the room for a name, inches; the most rows.
ROW, AROUND, NAME, MOST = 0.2, 0.75, 2.6, 40
#: Smaller and larger parts are drawn at these.
LEAST, LARGEST = 1e-9, 1e6


@styled
def draw_expectations(shares: Mapping[str, float]) -> Figure:
    """Draw a dot for each expectation by its name, at the part of its allowed error that it uses. An expectation beyond
    the line at 1 is not met. A part below 1e-9, or none at all, is drawn at 1e-9; a missing sample is drawn at 1e6."""
    shown = sorted(shares.items(), key=lambda item: -item[1])[:MOST]
    figure = Figure(figsize=(page_width(), AROUND + ROW * len(shown)), layout="constrained")
    axis = figure.subplots()
    axis.set_xscale("log")
    for place, (_, share) in enumerate(shown):
        axis.plot([min(max(share, LEAST), LARGEST)], [place], "o", markersize=4, color=line(share > 1.0)["color"])
    axis.axvline(1.0, color="#444444", linewidth=1.0)
    axis.margins(x=0.05)
    axis.set_yticks(range(len(shown)), [fitted(name, NAME, 8.0) for name, _ in shown])
    axis.invert_yaxis()
    axis.set_xlabel("error / allowed error")
    cut = len(shares) - len(shown)
    remark = f"without the {cut} expectations that use the smallest parts" if cut else ""
    return panels.finish(figure, remark=remark, with_legend=False)
