"""Error against work of long runs, a row of panels a mechanism: over evaluations, and over processor time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from mbproj.show.figures.style import LINES, page_width, styled

#: Height of a row of panels, inches.
ROW = 1.5
METHODS = (
    ("dop853", False, "DOP853"),
    ("dop853", True, "DOP853, energy row"),
    ("rk4", False, "RK4"),
    ("rk4", True, "RK4, energy row"),
    ("Gauss 4", False, "Gauss 4"),
    ("Gauss 6", False, "Gauss 6"),
    ("Gauss 8", False, "Gauss 8"),
    ("RATTLE", False, "RATTLE"),
)
#: mbproj's methods in one colour each, filled with the row; symplectic ones in others.
COLOURS, MARKS = (0, 0, 1, 1, 3, 4, 5, 2), "oossD^vx"


@styled
def drawn(rows: Sequence[dict[str, Any]], path: Path) -> Figure:
    """All runs, as PNG."""
    cases = list(dict.fromkeys(row["case"] for row in rows))
    figure = Figure(figsize=(page_width(), ROW * len(cases) + 0.7), layout="constrained")
    panels = figure.subplots(len(cases), 2, sharex="col", squeeze=False)
    for line, case in enumerate(cases):
        own = [row for row in rows if row["case"] == case]
        for panel, cost in zip(panels[line], ("evaluations", "seconds"), strict=True):
            for (method, with_row, label), colour, mark in zip(METHODS, COLOURS, MARKS, strict=True):
                found = [row for row in own if (row["method"], row["row"]) == (method, with_row)]
                panel.loglog(
                    [row[cost] for row in found],
                    [max(row["error"], row["certain"]) for row in found],
                    color=LINES[colour][0],
                    linestyle="-" if with_row else (0, (4, 2)),
                    marker=mark,
                    markersize=4,
                    markerfacecolor=LINES[colour][0] if with_row else "white",
                    label=label if line == 0 and cost == "seconds" else None,
                )
            panel.margins(0.08)
        panels[line, 0].set_ylabel(
            f"{case.replace(' ', chr(10), 1) if len(case) > 14 else case}\nerror ({own[0]['unit']})"
        )
        panels[line, 1].sharey(panels[line, 0])
    panels[-1, 0].set_xlabel("evaluations")
    panels[-1, 1].set_xlabel("processor time (s)")
    figure.legend(loc="outside lower center", ncol=4)
    figure.savefig(path)
    return figure
