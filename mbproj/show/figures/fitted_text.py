"""Text that fits: it is measured, wrapped and shortened to the room there is. Users' text is shown letter by letter."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from matplotlib.font_manager import FontProperties, findfont, get_font

from mbproj.results.record import Results
from mbproj.show.figures.style import look

#: Longer text is cut in its middle before it is measured: no picture has room for it.
LONGEST = 1200
#: The pieces after which a line may end; numbers are not split. U+00A0 is a space at which no line ends.
PIECES = re.compile(r"(?:[^ _.,;:-]|(?<=\d)[.,:-](?=\d))*[ _.,;:-]*")
SPACES = re.compile(r"[ \t\r\n]+")
CUT = "…"


def literal(text: str) -> str:
    """Escape `text`, so that matplotlib shows it letter by letter. Otherwise `$` would begin mathematics, and a label
    that begins with `_` would be hidden. Control characters become spaces."""
    shown = "".join(letter if letter.isprintable() else " " for letter in text)
    return (" " if shown.startswith("_") else "") + shown.replace("$", r"\$")


def width(text: str, size: float) -> float:
    """The width in inches of a line of `text` at a font `size` in points."""
    family = look().settings["font.family"][0]
    return sum(_advance(letter, family) for letter in text) * size / 72.0


def wrapped(text: str, room: float, size: float, most: int) -> list[str]:
    """Wrap `text` into at most `most` lines of `room` inches. The middle of a longer text is left out, as related names
    often begin alike and a unit stands at the end."""
    text = SPACES.sub(" ", text).strip()
    fits, too_long = 1, min(len(text), LONGEST) + 1
    while too_long - fits > 1:
        keep = (fits + too_long) // 2
        if len(_filled(_shorten(text, keep), room, size)) <= most:
            fits = keep
        else:
            too_long = keep
    return _filled(_shorten(text, fits), room, size)


def fitted(text: str, room: float, size: float, most: int = 1) -> str:
    """Wrap `text` as `wrapped` does; return one literal text with line breaks."""
    return "\n".join(literal(line) for line in wrapped(text, room, size, most))


def _shorten(text: str, keep: int) -> str:
    """Keep `keep` letters of `text`: two thirds of them from its end, which tells more."""
    head = keep // 3
    return text if keep >= len(text) else text[:head] + CUT + text[len(text) - (keep - head) :]


def _filled(text: str, room: float, size: float) -> list[str]:
    """Fill lines with pieces. A piece that is longer than a line breaks anywhere."""
    lines = [""]
    for piece in PIECES.findall(text):
        if width((lines[-1] + piece).rstrip(), size) <= room:
            lines[-1] += piece
            continue
        whole = width(piece.rstrip(), size) <= room
        for part in (piece,) if whole else piece:
            if lines[-1] and (whole or width((lines[-1] + part).rstrip(), size) > room):
                lines.append("")
            lines[-1] += part
    return [line.strip() for line in lines]


@lru_cache(maxsize=4096)
def _advance(letter: str, family: str) -> float:
    """The width of a letter in font sizes. A letter that the font lacks counts as wide, because another font draws
    it."""
    font: Any = get_font(findfont(FontProperties(family=family)))
    if not font.get_char_index(ord(letter)):
        return 1.0
    font.set_size(64, 72)
    return float(font.load_char(ord(letter)).linearHoriAdvance) / 65536.0 / 64.0


# --- The names that a picture has room for ----------------------------------------------------------------------------


#: The most lines in one panel.
MAX_LINES = 7


def all_names(results: Sequence[Results], kind: str) -> list[str]:
    """Every name of `kind` in any of the results, in the order of the first."""
    return list(dict.fromkeys(name for result in results for name in result.names(kind)))


def note(kind: str, drawn: int, all_of_them: int, others: str) -> str:
    """A note where only the first names of a kind are drawn. `others` tells how to see the others."""
    return "" if drawn == all_of_them else f"the first {drawn} of {all_of_them} {kind}: {others}"


def largest_joints(results: Sequence[Results], path: str, most: int = MAX_LINES) -> tuple[list[str], str]:
    """The joints with the largest values in the dataset `path` (T, nj, ...), and a remark where these are not all."""
    names = all_names(results, "joints")
    if len(names) <= most:
        return names, ""
    size = dict.fromkeys(names, 0.0)
    for result in results:
        values = np.abs(result[path]).reshape(len(result.time), len(result.names("joints")), -1)
        for name, value in zip(result.names("joints"), np.nanmax(values, axis=(0, 2), initial=0.0), strict=True):
            size[name] = max(size[name], float(value))
    chosen = sorted(sorted(names, key=lambda name: -size[name])[:most], key=names.index)
    return chosen, f"the {most} largest of {len(names)} joints: choose others with --joint"
