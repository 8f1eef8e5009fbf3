"""The look of every picture: for a report's text width, readable in black and white and by the colour-blind. A document
can change it by style sheets, a size and a font (`figure_style`).
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import field, replace
from functools import cache, wraps
from math import pi
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, MbprojError, Place, Problem, choose_from, did_you_mean
from mbproj.results.analysis.comparison import floors
from mbproj.results.output_files import MARK, picture, replacing
from mbproj.results.record import Results

Parameters = ParamSpec("Parameters")
Returned = TypeVar("Returned")

#: The width of a report's text, the height of one panel, of the time axis below the last one, and the most of all
#: panels, inches. The last leaves room for legend and small print.
_WIDTH, PANEL_HEIGHT, AXIS_HEIGHT, _PAGE_HEIGHT = 6.3, 1.75, 0.4, 8.4
MILLIMETRE = 1.0 / 25.4
#: The least and the largest width and height of a picture, mm.
SIZES = (20.0, 1000.0)
DOTS_PER_INCH = 200

#: Okabe and Ito's colours, in an order in which lightness varies too, each with its own dash pattern.
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
#: The look of lines that are not unique.
OPEN: dict[str, Any] = {"color": "#A0A0A0", "linewidth": 0.8}

FONT = "DejaVu Sans"
#: Fonts for letters that this font lacks, used where they are installed.
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

#: Font sizes in points: of axes' names, of the legend, of the small print.
_LABEL_SIZE, _LEGEND_SIZE, _PRINT_SIZE = 8.5, 8.0, 7.0

STYLE: Any = {
    "font.size": _LABEL_SIZE,
    "axes.labelsize": _LABEL_SIZE,
    "axes.titlesize": 8.5,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": _LEGEND_SIZE,
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


#: Entries of STYLE that are font sizes. They follow the `font.size` of a sheet that does not set them.
LETTERS = ("axes.labelsize", "axes.titlesize", "xtick.labelsize", "ytick.labelsize", "legend.fontsize")


@dataclass(frozen=True)
class FigureLook:
    """The look that a document asks for: the size of a picture in inches, a font, and settings of sheets by
    Matplotlib's keys. None and "" mean mbproj's own."""

    width: float | None = None
    height: float | None = None
    font: str = ""
    sheets: Mapping[str, Any] = field(default_factory=dict)

    @property
    def settings(self) -> dict[str, Any]:
        """All Matplotlib settings of this look."""
        merged = {**STYLE, **self.sheets}
        scale = self.font_size / STYLE["font.size"]
        merged |= {key: STYLE[key] * scale for key in LETTERS if key not in self.sheets}
        families = merged.get("font.family", [FONT])
        if self.font:
            families = [self.font]
            upright = {f"mathtext.{face}": self.font for face in ("rm", "sf", "tt", "cal")}
            slanted = {"mathtext.it": f"{self.font}:italic", "mathtext.bf": f"{self.font}:bold"}
            merged |= {"mathtext.fontset": "custom", **upright, **slanted}
        merged["font.family"] = list(dict.fromkeys([*families, FONT, *_installed()]))
        return merged

    @property
    def font_size(self) -> float:
        """The font size, points."""
        return float(self.sheets.get("font.size", STYLE["font.size"]))


#: mbproj's own look.
_OURS = FigureLook()
_LOOK: ContextVar[FigureLook] = ContextVar("look")


def look() -> FigureLook:
    """The look in use."""
    return _LOOK.get(_OURS)


@contextmanager
def figure_style(
    *sheets: str | Path, size: float | Sequence[float] | None = None, font: str | None = None
) -> Iterator[None]:
    """Gives this look to all pictures drawn inside the block.

    `sheets` are files of Matplotlib's style sheets, or names of its own; later ones win. `size` is the width in mm, or
    width and height. `font` is the document's font, also in mathematics. Raises InputError where a sheet is wrong, a
    font is not installed, or a size is out of range.
    """
    known = look()
    style = replace(known, sheets={**known.sheets, **{key: value for one in sheets for key, value in read_sheet(one)}})
    if "figure.figsize" in style.sheets and size is None and known.width is None:
        width, height = (_inches(each / MILLIMETRE) for each in style.sheets["figure.figsize"])
        style = replace(style, width=width, height=height)
    if size is not None:
        width, *rest = (size,) if isinstance(size, int | float) else tuple(size)
        style = replace(style, width=_inches(width), height=_inches(rest[0]) if rest else None)
    if font is not None:
        style = replace(style, font=_present(font))
    token = _LOOK.set(style)
    try:
        yield
    finally:
        _LOOK.reset(token)


def _inches(millimetres: float) -> float:
    least, most = SIZES
    if not least <= millimetres <= most:
        raise InputError(Problem(f"a picture of {millimetres:g} mm", hint=f"sizes are {least:g} to {most:g} mm"))
    return float(millimetres) * MILLIMETRE


def _present(font: str) -> str:
    """Return the font's name. Raises InputError where it is not installed."""
    from matplotlib.font_manager import fontManager

    from mbproj.base.errors import choose_from

    names = sorted(set(fontManager.get_font_names()))
    if font not in names:
        raise InputError(Problem(f"the font '{font}' is not installed here", hint=choose_from(font, names)))
    return font


def page_width() -> float:
    """The width of a picture, inches."""
    return look().width or _WIDTH


def page_height() -> float:
    """The largest height of all panels, inches. Where the look sets a picture's height, it is that height less the
    margins."""
    height = look().height
    return _PAGE_HEIGHT if height is None else max(height - AXIS_HEIGHT, 0.5 * height)


def label_size() -> float:
    """The font size of axes' names, points."""
    return _points("axes.labelsize")


def legend_size() -> float:
    """The font size of the legend, points."""
    return _points("legend.fontsize")


def print_size() -> float:
    """The font size of the small print, points."""
    return _PRINT_SIZE * look().font_size / STYLE["font.size"]


def _points(key: str) -> float:
    from matplotlib.font_manager import font_scalings

    size = look().settings[key]
    return look().font_size * font_scalings[size] if isinstance(size, str) else float(size)


def styled(function: Callable[Parameters, Returned]) -> Callable[Parameters, Returned]:
    """Run `function` with the look in use, and restore the caller's settings afterwards. Where it fails with a sheet
    in use, InputError says so: Matplotlib checks few of the values that it reads."""

    @wraps(function)
    def inside(*arguments: Parameters.args, **options: Parameters.kwargs) -> Returned:
        settings: Any = look().settings
        try:
            with mpl.rc_context(settings):
                return function(*arguments, **options)
        except Exception as error:
            if isinstance(error, (MbprojError, OSError)) or not look().sheets:
                raise
            why = f"{type(error).__name__}: {' '.join(str(error).split())[:200]}"
            message = f"Matplotlib draws nothing with this style sheet: {why}"
            raise InputError(Problem(message, hint="take out lines of the sheet")) from error

    return inside


@cache
def _installed() -> list[str]:
    from matplotlib.font_manager import fontManager

    present = set(fontManager.get_font_names())
    return [name for name in OTHERS if name in present]


def line(index: int) -> dict[str, Any]:
    """The colour and dashes of the line number `index`: a sheet's own where it has lines. From the eighth line on,
    colours and dashes are paired differently."""
    turn, place = divmod(index, len(LINES))
    colour, dashes = LINES[place][0], LINES[(place + turn) % len(LINES)][1]
    usual = {"color": colour, "linestyle": dashes}
    cycle = look().sheets.get("axes.prop_cycle")
    of_sheet = list(cycle) if cycle is not None else []
    return usual | of_sheet[index % len(of_sheet)] if of_sheet else usual


# --- Matplotlib's style sheets, read with errors that give the place --------------------------------------------------
# Matplotlib's own reader only warns of a wrong key.


#: A comment begins at a # outside quotes.
COMMENT = re.compile(r'^((?:[^"#]|"[^"]*")*)#.*$')
#: Keys that a sheet may not set, and the reason.
REFUSED = {
    "text.usetex": "names of a scene are no LaTeX; --font sets the document's font, in mathematics too",
    "savefig.format": "--format says it",
}
#: The beginnings of keys that concern programs that show pictures, not the look.
FOREIGN = ("backend", "interactive", "toolbar", "webagg", "tk.", "macosx", "keymap", "savefig.directory", "timezone")
#: The largest size of a sheet, bytes.
MOST_BYTES = 100_000


def read_sheet(sheet: str | Path) -> Iterator[tuple[str, Any]]:
    """Yield the settings of a sheet: a file, or one of Matplotlib's own by its name. Raises InputError with all
    problems."""
    path = Path(sheet)
    if not path.suffix and not path.is_file():
        names = [name for name in style.library if not name.startswith("_")]
        if str(sheet) not in names:
            raise InputError(Problem(f"there is no style '{sheet}'", hint=choose_from(str(sheet), names)))
        yield from _without_size(style.library[str(sheet)])
        return
    try:
        if path.stat().st_size > MOST_BYTES:
            raise InputError(Problem(f"it is larger than {MOST_BYTES} bytes", Place(str(path)), "it is no style sheet"))
        lines = path.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError as error:
        raise InputError(Problem("it is no text", Place(str(path)), "give a style sheet of Matplotlib")) from error
    problems: list[Problem] = []
    pairs = [pair for number, line in enumerate(lines, 1) for pair in _pair(line, Place(str(path), number), problems)]
    if problems:
        raise InputError(problems)
    yield from pairs


def _without_size(settings: Any) -> Iterator[tuple[str, Any]]:
    """The settings without the figure's size, which in Matplotlib's own styles is for screens."""
    yield from ((key, value) for key, value in settings.items() if key != "figure.figsize")


def _pair(line: str, place: Place, problems: list[Problem]) -> Iterator[tuple[str, Any]]:
    text = COMMENT.sub(r"\1", line).strip()
    if not text:
        return
    key, colon, value = (part.strip() for part in text.partition(":"))
    if not colon:
        problems.append(Problem(f"'{text}' is not KEY: VALUE", place))
    elif key in REFUSED or key.startswith(FOREIGN):
        problems.append(Problem(f"a sheet cannot set '{key}'", place, REFUSED.get(key, "leave it out")))
    elif key not in mpl.rcParams:
        alike = [known for known in mpl.rcParams if known[0] == key[0]]
        problems.append(
            Problem(f"unknown key '{key}'", place, did_you_mean(key, alike) or "keys are those of a matplotlibrc file")
        )
    else:
        try:
            yield key, mpl.rcParams.validate[key](value.strip('"') if value.startswith('"') else value)
        except ValueError as error:
            problems.append(Problem(f"'{key}': {error}", place))


# --- Units for a person -----------------------------------------------------------------------------------------------
# Angles in degrees, or in turns where there are many. Recorded values stay in SI.


@dataclass(frozen=True)
class AxisUnit:
    """A unit on an axis: its text, and the factor from `si` to it."""

    reads: str
    si: str
    factor: float = 1.0


@dataclass(frozen=True)
class UnitPair:
    """The units of a coordinate and of its speed."""

    value: AxisUnit
    speed: AxisUnit


DEGREES = UnitPair(AxisUnit("°", "rad", 180.0 / pi), AxisUnit("°/s", "rad/s", 180.0 / pi))
TURNS = UnitPair(AxisUnit("turns", "rad", 0.5 / pi), AxisUnit("rpm", "rad/s", 30.0 / pi))
METRES = UnitPair(AxisUnit("m", "m"), AxisUnit("m/s", "m/s"))
#: The angle in rad above which turns are used: beyond ten turns, 3600°, degrees tell nothing.
MANY = 20.0 * pi
#: The distances of ticks in degrees, and the most intervals on an axis. A short axis has decimal ticks.
STEPS = (15, 30, 45, 90, 180, 360, 720, 1440)
MOST_PARTS = 6


def units_of(si: str, values: Iterable[Array]) -> UnitPair:
    """The units for a coordinate in `si`, rad or m, with these values."""
    if si == "m":
        return METRES
    largest = max((float(np.max(np.abs(each), where=np.isfinite(each), initial=0.0)) for each in values), default=0.0)
    return TURNS if largest > MANY else DEGREES


def tick_degrees(axis: Axes, *, along_x: bool = False) -> None:
    """Put the ticks of the vertical, or the horizontal, axis at parts of a turn, where its range is large enough."""
    low, high = axis.get_xlim() if along_x else axis.get_ylim()
    step = next((step for step in STEPS if high - low <= MOST_PARTS * step), None)
    if step is not None and high - low >= 2 * STEPS[0]:
        (axis.xaxis if along_x else axis.yaxis).set_major_locator(MultipleLocator(step))


def sizes(results: Sequence[Results]) -> dict[str, float]:
    """The mechanism's own size in each SI unit, from its extent, duration and energy. A panel in which nothing moves
    has this range. The size is 1 where the results do not tell it."""
    largest: dict[str, float] = {}
    with np.errstate(all="ignore"):
        for result in results:
            for unit, size in floors(result, result).items():
                largest[unit] = max(largest.get(unit, 0.0), size if np.isfinite(size) else 0.0)
    return {unit: size or 1.0 for unit, size in largest.items()}


# --- Writing a picture to a file --------------------------------------------------------------------------------------


#: The metadata of each format: mbproj's mark, by which it recognises its files, and no date, so that the same results
#: give the same file.
METADATA = {
    "png": {"Software": MARK},
    "svg": {"Title": MARK, "Date": None},
    "pdf": {"Creator": MARK, "CreationDate": None},
}


#: The most pixels of a picture: 0.4 GB while it is drawn.
MOST_PIXELS = 1e8


def _refuse_large(figure: Figure, file_format: str) -> None:
    """Raises InputError where a picture of pixels would not fit into memory."""
    dots = mpl.rcParams["savefig.dpi"]
    pixels = float(np.prod(figure.get_size_inches())) * (figure.dpi if dots == "figure" else float(dots)) ** 2
    if file_format == "png" and pixels > MOST_PIXELS:
        hint = "set a smaller savefig.dpi or size, or take --format svg"
        raise InputError(Problem(f"a picture of {pixels:.2g} pixels, and {MOST_PIXELS:g} are the most", hint=hint))


@styled
def save(figure: Figure, path: Path, *, force: bool = False) -> Path:
    """Writes `figure` in the format that the suffix names.

    Raises InputError where the file cannot be written. Without `force`, it also refuses to replace a file that is no
    picture of mbproj."""
    file_format = path.suffix[1:]
    hint = "choose another directory with -o"
    with replacing(path, picture(file_format), force=force, hint=hint) as draft, warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")  # the picture shows a box instead
        asked = look()
        if asked.height is not None:
            figure.set_size_inches(page_width(), asked.height)
        _refuse_large(figure, file_format)
        exact: dict[str, Any] = {"bbox_inches": figure.bbox_inches} if asked.width is not None else {}
        figure.savefig(draft, format=file_format, metadata=METADATA[file_format], **exact)
    return path
