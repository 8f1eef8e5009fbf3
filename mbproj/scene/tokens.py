"""Expressions: text -> tokens. A unit is told from a name by what stands before it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from mbproj.scene.suggestions import did_you_mean
from mbproj.scene.units import UNITS


class ExpressionError(Exception):
    """What is wrong in an expression, at which character of its text (from 0), and what to try."""

    def __init__(self, message: str, at: int, hint: str | None = None) -> None:
        super().__init__(message)
        self.message, self.at, self.hint = message, at, hint


@dataclass(frozen=True)
class Token:
    kind: str
    text: str
    at: int


_NUMBER = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_PATTERN = re.compile(
    rf"\s*(?:(?P<number>{_NUMBER})|(?P<name>[A-Za-z_][A-Za-z0-9_]*)|(?P<operator>\*\*|[-+*/(),])|(?P<wrong>.)|$)", re.S
)
_UNIT = re.compile("(?:" + "|".join(map(re.escape, sorted(UNITS, key=len, reverse=True))) + r")(?![A-Za-z0-9_])")
#: A name right after one of these can only be a unit.
_ENDS_OPERAND = ("number", "name", ")")
HINTS = {
    "^": "write ** for powers",
    ",": "decimals take a point",
    "number": "an operator is missing",
    "unit": "a number has one unit",
}


def tokens(text: str) -> Iterator[Token]:
    """The tokens of `text` in order, then one of kind "end"; operators are their own kind.

    Raises ExpressionError for a character or a unit that is unknown.
    """
    at, before = 0, ""
    while (found := _PATTERN.match(text, at)) is not None and found.lastgroup is not None:
        kind, start = found.lastgroup, found.start(found.lastgroup)
        word, at = found[kind], found.end()
        if kind == "wrong":
            raise ExpressionError(f"unexpected '{word}'", start, HINTS.get(word))
        if kind == "name" and before in _ENDS_OPERAND:
            unit = _UNIT.match(text, start)
            if unit is None:
                hint = did_you_mean(word, UNITS) or "write * to multiply"
                raise ExpressionError(f"unknown unit '{word}'", start, hint)
            kind, word, at = "unit", unit[0], unit.end()
        before = word if kind == "operator" else kind
        yield Token(before, word, start)
    yield Token("end", "", len(text.rstrip()))
