"""The look of every picture: for a report's text width, readable in black and white and by the colour-blind."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

import matplotlib as mpl

Parameters = ParamSpec("Parameters")
Returned = TypeVar("Returned")

#: Width of a report's text, height of one panel, of the time axis below the last one, and of all panels at most, so
#: that legend and small print have room on the page; inches.
WIDTH, PANEL_HEIGHT, AXIS_HEIGHT, PAGE_HEIGHT = 6.3, 1.75, 0.4, 8.4
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
#: The look of what is not unique.
OPEN: dict[str, Any] = {"color": "#A0A0A0", "linewidth": 0.8}

FONT = "DejaVu Sans"
#: Fonts for letters that it does not have, where they are installed.
OTHERS = (
    "Noto Sans CJK JP",
    "Noto Sans CJK SC",
    "WenQuanYi Zen Hei",
    "Hiragino Sans",
    "PingFang SC",
    "Yu Gothic",
    "Microsoft YaHei",
    "Malgun Gothic",
    "Noto Sans Devanagari",
    "Noto Sans Thai",
    "Arial Unicode MS",
)

#: Sizes in points: of axes' names, of the legend, of what stands below the panels.
LABEL_SIZE, LEGEND_SIZE, PRINT_SIZE = 8.5, 8.0, 7.0

STYLE: Any = {
    "font.size": LABEL_SIZE,
    "axes.labelsize": LABEL_SIZE,
    "axes.titlesize": 8.5,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": LEGEND_SIZE,
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
    "axes.formatter.limits": (-3, 5),
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
        with mpl.rc_context(STYLE | {"font.family": [FONT, *_installed()]}):
            return function(*arguments, **options)

    return inside


@cache
def _installed() -> list[str]:
    from matplotlib.font_manager import fontManager

    present = set(fontManager.get_font_names())
    return [name for name in OTHERS if name in present]


def line(index: int) -> dict[str, Any]:
    """Colour and dashes of the line number `index`; from the eighth on, in other pairs."""
    turn, place = divmod(index, len(LINES))
    colour, dashes = LINES[place][0], LINES[(place + turn) % len(LINES)][1]
    return {"color": colour, "linestyle": dashes}
