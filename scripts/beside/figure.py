"""Error against work, a row of panels a problem: over evaluations, where they are counted, and over processor time."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from mbproj.show.figures.style import LINES, page_width, styled

#: Height of a row of panels, inches.
ROW = 1.5
MARKS = "osD^vxP*<>"
WITH_ROW = ", energy row"


@styled
def drawn(rows: Sequence[dict[str, Any]], path: Path) -> Figure:
    """All runs, as PNG: a colour a program; filled is what has the row of the energy, beside the same without it."""
    problems = list(dict.fromkeys(row["problem"] for row in rows))
    programs = list(dict.fromkeys(row["program"] for row in rows))
    colours = list(dict.fromkeys(name.removesuffix(WITH_ROW) for name in programs))
    figure = Figure(figsize=(page_width(), ROW * len(problems) + 0.7), layout="constrained")
    panels = figure.subplots(len(problems), 2, sharex="col", squeeze=False)
    for line, problem in enumerate(problems):
        own = [row for row in rows if row["problem"] == problem]
        for panel, cost in zip(panels[line], ("evaluations", "seconds"), strict=True):
            for name in programs:
                found = [row for row in own if row["program"] == name and row[cost]]
                number, filled = colours.index(name.removesuffix(WITH_ROW)), name.endswith(WITH_ROW)
                colour = LINES[number % len(LINES)][0]
                panel.loglog(
                    [row[cost] for row in found],
                    [max(row["error"], row.get("certain", 0.0)) for row in found],
                    color=colour,
                    linestyle="-" if filled else (0, (4, 2)),
                    marker=MARKS[number % len(MARKS)],
                    markersize=4,
                    markerfacecolor=colour if filled else "white",
                    label=name if line == 0 and cost == "seconds" else None,
                )
            panel.margins(0.08)
        title = re.split(r",| from | with | whose ", problem)[0]
        broken = title.replace(" ", "\n", 1) if len(title) > 14 else title
        panels[line, 0].set_ylabel(f"{broken}\nerror ({own[0]['unit']})")
        panels[line, 1].sharey(panels[line, 0])
    panels[-1, 0].set_xlabel("evaluations")
    panels[-1, 1].set_xlabel("processor time (s)")
    figure.legend(loc="outside lower center", ncol=3)
    figure.savefig(path)
    return figure
