"""Expressions: text -> tokens. The token before a name decides whether it is a unit, or a parameter or function."""

from __future__ import annotations

import re
from collections.abc import Iterator, Set

from mbproj.dataclass import dataclass
from mbproj.scene.expressions.unit_text import similar_unit, unit_at


class ExpressionError(Exception):
    """The error of an expression: its message, the character of the text (from 0) at which it is, and a hint."""

    def __init__(self, message: str, at: int, hint: str | None = None) -> None:
        super().__init__(message)
        self.message, self.at, self.hint = message, at, hint


@dataclass(frozen=True)
class Token:
    kind: str
    text: str
    at: int


_NUMBER = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
#: The name of a parameter or a function, or a name with points, as pin.angle.
_NAME = r"[A-Za-z_][A-Za-z0-9_]*(?:\.[A-Za-z_][A-Za-z0-9_]*)*"
_PATTERN = re.compile(
    rf"\s*(?:(?P<number>{_NUMBER})|(?P<name>{_NAME})|(?P<operator>\*\*|[-+*/(),])|(?P<wrong>.)|$)", re.S
)
#: A name right after one of these can only be a unit.
_ENDS_OPERAND = ("number", "name", ")")
HINTS = {
    "^": "write ** for powers",
    ",": "decimals take a point",
    "·": "write * to multiply",
    "number": "an operator is missing",
    "name": "write * between the units, as in kg*m^2",
}


def tokens(text: str, parameters: Set[str] = frozenset()) -> Iterator[Token]:
    """The tokens of `text` in order, then one of kind "end"; operators are their own kind. `parameters` are names that
    are no units after * or /, because the scene has parameters of these names.

    Raises ExpressionError for a character or a unit that is unknown.
    """
    at, before = 0, ""
    while (found := _PATTERN.match(text, at)) is not None and found.lastgroup is not None:
        kind, start = found.lastgroup, found.start(found.lastgroup)
        word, at = found[kind], found.end()
        if kind == "wrong":
            raise ExpressionError(f"unexpected '{word}'", start, HINTS.get(word))
        if kind in ("name", "number") and before in _ENDS_OPERAND:
            unit = unit_at(text, start, parameters)
            if unit is None and kind == "name":
                raise ExpressionError(f"unknown unit '{word}'", start, similar_unit(word) or "write * to multiply")
            if unit is not None:
                kind, word, at = "unit", text[start : unit[1]], unit[1]
        before = word if kind == "operator" else kind
        yield Token(before, word, start)
    yield Token("end", "", len(text.rstrip()))
