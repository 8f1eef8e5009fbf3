"""Scenes with something else in the place of a number, a word or a line."""

from __future__ import annotations

import re
from random import Random

from fuzz.values import EXPRESSIONS, NUMBERS, TEXTS, UNITS

NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w.])")
WORD = re.compile(r"[A-Za-z_][\w-]*")


def changed(text: str, random: Random) -> str:
    """The scene with one to three changes."""
    for _ in range(random.choice((1, 1, 1, 2, 3))):
        text = random.choice(CHANGES)(text, random)
    return text


def _number(text: str, random: Random) -> str:
    return _in_place_of(NUMBER, text, random.choice(NUMBERS) + random.choice(("", "", *UNITS)), random)


def _scaled(text: str, random: Random) -> str:
    """A number so many times as large, in its own unit: what every bound lets through."""
    return _in_place_of(NUMBER, text, f"{random.choice((1, 1, -1)) * 10 ** random.uniform(-60, 60):.3g}", random)


def _all_scaled(text: str, random: Random) -> str:
    """Every number so many times as large."""
    head, middle, rest = text.partition("\nbodies:")
    factor = 10 ** random.uniform(-20, 20)
    return head + middle + NUMBER.sub(lambda found: f"{float(found[0]) * factor:.6g}", rest)


def _expression(text: str, random: Random) -> str:
    return _in_place_of(NUMBER, text, random.choice(EXPRESSIONS), random)


def _word(text: str, random: Random) -> str:
    words = WORD.findall(text) if random.random() < 0.5 else TEXTS
    return _in_place_of(WORD, text, random.choice(words), random)


def _quoted(text: str, random: Random) -> str:
    escapes = ("\\e[31m", "\\0", "\\x9b", "\\u202e", "\\n", "\\x07", "$x{", "=1+1")
    return _in_place_of(WORD, text, f'"a{random.choice(escapes)}b"', random)


def _line(text: str, random: Random) -> str:
    lines = text.splitlines()
    at, other = random.randrange(len(lines)), random.randrange(len(lines))
    kind = random.randrange(4)
    if kind == 0:
        del lines[at]
    elif kind == 1:
        lines.insert(at, lines[other])
    elif kind == 2:
        lines[at], lines[other] = lines[other], lines[at]
    else:
        lines = lines[: at + 1]
    return "\n".join(lines) + "\n"


def _characters(text: str, random: Random) -> str:
    at = random.randrange(len(text))
    return text[:at] + random.choice("{}[]:,-#&*!|>'\"%@`\t\0\x1b\ud800é") + text[at + random.randrange(2) :]


def _in_place_of(pattern: re.Pattern[str], text: str, new: str, random: Random) -> str:
    found = list(pattern.finditer(text))
    if not found:
        return text
    place = random.choice(found)
    return text[: place.start()] + new + text[place.end() :]


CHANGES = (
    _number,
    _number,
    _scaled,
    _scaled,
    _scaled,
    _scaled,
    _scaled,
    _scaled,
    _all_scaled,
    _expression,
    _word,
    _quoted,
    _line,
    _characters,
)
