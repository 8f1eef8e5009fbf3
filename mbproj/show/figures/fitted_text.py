"""Text that fits: it is measured, wrapped and shortened to the room there is. Users' text is shown letter by letter."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

from matplotlib.font_manager import FontProperties, findfont, get_font

from mbproj.figures.style import look

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
