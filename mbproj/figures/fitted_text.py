"""Words that fit: text of users shown letter by letter, measured, wrapped and shortened to the room there is."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

from matplotlib.font_manager import FontProperties, findfont, get_font

from mbproj.figures.style import look

#: What is longer is cut in its middle before anything is measured: no picture has room for it.
LONGEST = 1200
#: Where a line may end: after these, but not within a number. A space that is not to be broken at is U+00A0.
PIECES = re.compile(r"(?:[^ _.,;:-]|(?<=\d)[.,:-](?=\d))*[ _.,;:-]*")
SPACES = re.compile(r"[ \t\r\n]+")
CUT = "…"


def literal(text: str) -> str:
    """`text` as matplotlib shows it letter by letter: `$` begins mathematics, a label with `_` first is hidden, and
    control characters have no picture."""
    shown = "".join(letter if letter.isprintable() else " " for letter in text)
    return (" " if shown.startswith("_") else "") + shown.replace("$", r"\$")


def width(text: str, size: float) -> float:
    """The width in inches of a line of `text` at a font `size` in points."""
    family = look().settings["font.family"][0]
    return sum(_advance(letter, family) for letter in text) * size / 72.0


def wrapped(text: str, room: float, size: float, most: int) -> list[str]:
    """`text` in at most `most` lines of `room` inches. Where it is longer its middle is left out: names that belong
    together often begin alike, and a unit stands at the end."""
    text = SPACES.sub(" ", text).strip()
    fits, too_long = 1, min(len(text), LONGEST) + 1
    while too_long - fits > 1:
        keep = (fits + too_long) // 2
        if len(_filled(_cut(text, keep), room, size)) <= most:
            fits = keep
        else:
            too_long = keep
    return _filled(_cut(text, fits), room, size)


def fitted(text: str, room: float, size: float, most: int = 1) -> str:
    """The same as one literal text, its lines below each other."""
    return "\n".join(literal(line) for line in wrapped(text, room, size, most))


def _cut(text: str, keep: int) -> str:
    """`keep` letters of `text`: of those that stay, two thirds are the last, which tell more."""
    head = keep // 3
    return text if keep >= len(text) else text[:head] + CUT + text[len(text) - (keep - head) :]


def _filled(text: str, room: float, size: float) -> list[str]:
    """Lines of pieces; a piece that is longer than a line breaks anywhere."""
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
    """How far a letter moves the pen, in font sizes; one that the font does not have comes from another, and is taken
    for a wide one."""
    font: Any = get_font(findfont(FontProperties(family=family)))
    if not font.get_char_index(ord(letter)):
        return 1.0
    font.set_size(64, 72)
    return float(font.load_char(ord(letter)).linearHoriAdvance) / 65536.0 / 64.0
