"""The look of every picture: for a report's text width, readable in black and white and by the colour-blind."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import matplotlib as mpl

Parameters = ParamSpec("Parameters")
Returned = TypeVar("Returned")

#: Width of a report's text and height of one panel, in inches.
WIDTH, PANEL_HEIGHT, LEGEND_HEIGHT = 6.3, 1.75, 0.45
DOTS_PER_INCH = 200

#: Okabe and Ito's colours in an order that also falls in lightness steps, each with a dash pattern of its own.
LINES: tuple[tuple[str, Any], ...] = (
    ("#0072B2", "-"),
    ("#D55E00", (0, (5, 1.5))),
    ("#000000", (0, (1, 1.2))),
    ("#009E73", (0, (6, 1.5, 1, 1.5))),
    ("#CC79A7", (0, (3, 1, 1, 1, 1, 1))),
    ("#E69F00", (0, (9, 2))),
    ("#56B4E9", (0, (3, 2))),
)
SHADE = "#ECECEC"

STYLE: Any = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 8.5,
    "axes.labelsize": 8.5,
    "axes.titlesize": 8.5,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "legend.handlelength": 2.8,
    "legend.columnspacing": 1.4,
    "lines.linewidth": 1.2,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.xmargin": 0.0,
    "axes.formatter.use_mathtext": True,
    "axes.formatter.limits": (-3, 4),
    "grid.color": "#D0D0D0",
    "grid.linewidth": 0.4,
    "xtick.direction": "out",
    "ytick.direction": "out",
    "mathtext.fontset": "dejavusans",
    "savefig.dpi": DOTS_PER_INCH,
    "figure.dpi": DOTS_PER_INCH,
    "svg.fonttype": "none",
    "pdf.fonttype": 42,
}


def styled(function: Callable[Parameters, Returned]) -> Callable[Parameters, Returned]:
    """`function` with this look in force, and the caller's own settings back afterwards."""

    @wraps(function)
    def inside(*arguments: Parameters.args, **options: Parameters.kwargs) -> Returned:
        with mpl.rc_context(STYLE):
            return function(*arguments, **options)

    return inside


def line(index: int) -> dict[str, Any]:
    """Colour and dashes of the line number `index`."""
    colour, dashes = LINES[index % len(LINES)]
    return {"color": colour, "linestyle": dashes}
