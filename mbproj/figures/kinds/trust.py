"""The error of each marker of a certified run over time, with its uncertainty."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from mbproj.figures import fitting_names, panels
from mbproj.figures.rows import MAX_ROWS
from mbproj.figures.style import line, styled
from mbproj.results import Results
from mbproj.results.trust import Trust

#: An uncertainty below this part of the error is not visible.
SEEN = 0.05
BAND = "band: what the error may be at most"


@styled
def draw(results: Sequence[Results], labels: Sequence[str]) -> Figure:
    """Draw a row for each marker with a line for each certified result. The band above a line is where the true error
    may be."""
    certified = [(result, result.trust, label) for result, label in zip(results, labels, strict=True) if result.trust]
    names = list(dict.fromkeys(name for result, trust, _ in certified for name in _names(result, trust)))
    drawn = names[:MAX_ROWS]
    remarks = (
        [cut] if (cut := fitting_names.note("markers", len(drawn), len(names), "choose others with --marker")) else []
    )
    figure, axes = panels.panels(len(drawn), height=2.1)
    for axis, name in zip(axes[:, 0], drawn, strict=True):
        for index, (result, trust, label) in enumerate(certified):
            if name in _names(result, trust):
                k = trust.names.index(name)
                rows = (trust.time >= result.time[0]) & (trust.time <= result.time[-1])
                time, error, unsure = trust.time[rows], trust.error[rows, k], trust.uncertainty[rows, k]
                known = np.where(error > panels.FLOOR, error, np.nan)
                panels.plot_log(axis, time, known, label, index)
                if np.nanmax(unsure / known, initial=0.0) > SEEN:
                    axis.fill_between(time, known, known + unsure, color=line(index)["color"], alpha=0.2, linewidth=0)
                    remarks = list(dict.fromkeys([BAND, *remarks]))
        panels.name(axis, f"error of {name}", "m")
    return panels.finish(figure, remark="; ".join(remarks), with_legend=len(certified) > 1)


def _names(result: Results, trust: Trust) -> list[str]:
    """The points to draw; of markers, those that the results have kept."""
    chosen = result.names("markers") or trust.names
    return [name for name in trust.names if name in chosen]
