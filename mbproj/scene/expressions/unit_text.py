"""Units as they are written: products, quotients and powers of the symbols, as in kg*mm^2, N·s/mm, N/(m*s), 1/s.

    unit   = [1 /] factor {(* | · | /) factor}
    factor = (symbol | (unit)) [^ number | ² | ³]

Where a unit ends depends on the parameters. After the first factor the name of a parameter is that parameter: with a
parameter `g`, `2 kg*g` is 2 kg times g. The units of COMPOUNDS, written without spaces, are units all the same: with a
parameter `m`, `5 N*m` is a torque, and `5 N * m` is 5 N times m.
"""

from __future__ import annotations

import re
from collections.abc import Set
from functools import lru_cache

from mbproj.scene.expressions.units import SYMBOLS, Dimension, Unit
from mbproj.scene.text.suggestions import did_you_mean

#: Units that stay units whatever the names of the parameters are.
COMPOUNDS = (
    "rad/s",
    "deg/s",
    "m/s",
    "mm/s",
    "cm/s",
    "m/s^2",
    "kg*m^2",
    "kg/m^3",
    "g/cm^3",
    "N*m",
    "N/m",
    "N/mm",
    "N*s/m",
    "N*m/rad",
    "N*m*s/rad",
    "l/min",
    "l/s",
)
#: Symbols that are units in COMPOUNDS alone: elsewhere l is the length of a spring.
IN_COMPOUNDS = {"l": Unit(Dimension(length=3), divide=1000.0)}
#: The most levels of parentheses in a unit.
MAX_DEPTH = 5

_LONGEST_FIRST = sorted(COMPOUNDS, key=len, reverse=True)
_COMPOUND = re.compile(rf"(?:{'|'.join(map(re.escape, _LONGEST_FIRST))})(?![A-Za-z0-9_])")
_NAME = re.compile(r"\s*([A-Za-z_][A-Za-z0-9_]*)(?![A-Za-z0-9_]|\.[A-Za-z_])")
_OPERATOR = re.compile(r"\s*([*·⋅/])(?!\*)")
_POWER = re.compile(r"\s*(?:\^\s*(?P<number>[-+]?[0-9]{1,6}(?:\.[0-9]{1,12})?)(?![0-9.])|(?P<raised>[²³]))")
_ONE_OVER = re.compile(r"\s*1\s*/(?!\*)")
_OPEN, _CLOSE = re.compile(r"\s*\("), re.compile(r"\s*\)")
_RAISED = {"²": 2, "³": 3}
#: Units that are often written without a sign between them: Nm, kgm, Ns.
_RUN_TOGETHER = {a + b: f"{a}*{b}" for a in ("N", "kN", "kg", "g") for b in ("m", "mm", "cm")}
_RUN_TOGETHER |= {"Ns": "N*s", "Nms": "N*m*s"}


def unit_at(text: str, at: int, parameters: Set[str] = frozenset()) -> tuple[Unit, int] | None:
    """The unit that begins at this character of the text, and where it ends; None where none does."""
    compound = _COMPOUND.match(text, at)
    return _Reader(text, parameters, compound.end() if compound else at + 1, compound is not None).unit(at, MAX_DEPTH)


@lru_cache(maxsize=256)
def unit_of(text: str) -> Unit:
    """The unit that the whole text is. Raises ValueError where it is none."""
    found = unit_at(text, 0)
    if found is None or text[found[1] :].strip():
        raise ValueError(f"'{text}' is no unit")
    return found[0]


def similar_unit(word: str) -> str | None:
    """A hint with the unit that an unknown word was probably meant to be; None where none is similar."""
    if word in _RUN_TOGETHER:
        return f"did you mean '{_RUN_TOGETHER[word]}'?"
    return did_you_mean(word, (*SYMBOLS, *COMPOUNDS)) if len(word) > 1 else None


class _Reader:
    """Reads a unit in a text. Up to the character `free` all symbols are units; from there on the name of a parameter
    is none. `compound`: the text begins with one of `COMPOUNDS`."""

    def __init__(self, text: str, parameters: Set[str], free: int, compound: bool) -> None:
        self._text, self._parameters, self._free, self._compound = text, parameters, free, compound

    def unit(self, at: int, depth: int) -> tuple[Unit, int] | None:
        """The unit at this character, and where it ends."""
        one = _ONE_OVER.match(self._text, at)
        found = self.factor(at if one is None else one.end(), depth)
        if found is None:
            return None
        unit, end = found if one is None else (found[0] ** -1, found[1])
        while (sign := _OPERATOR.match(self._text, end)) is not None:
            found = self.factor(sign.end(), depth)
            if found is None:
                break
            unit, end = unit * (found[0] ** -1 if sign[1] == "/" else found[0]), found[1]
        return unit, end

    def factor(self, at: int, depth: int) -> tuple[Unit, int] | None:
        """A symbol or a unit in parentheses, with its power, and where it ends."""
        found = self._symbol(at) or self._group(at, depth)
        if found is None:
            return None
        unit, end = found
        power = _POWER.match(self._text, end)
        if power is None:
            return unit, end
        exponent = float(power["number"]) if power["number"] else _RAISED[power["raised"]]
        return unit**exponent, power.end()

    def _symbol(self, at: int) -> tuple[Unit, int] | None:
        name = _NAME.match(self._text, at)
        if name is None:
            return None
        is_free = name.start(1) >= self._free
        if name[1] in IN_COMPOUNDS and self._compound and not is_free:
            return IN_COMPOUNDS[name[1]], name.end()
        if name[1] not in SYMBOLS:
            return None
        means_more = name[1] in self._parameters or _OPEN.match(self._text, name.end())
        return None if means_more and is_free else (SYMBOLS[name[1]], name.end())

    def _group(self, at: int, depth: int) -> tuple[Unit, int] | None:
        opened = _OPEN.match(self._text, at)
        found = self.unit(opened.end(), depth - 1) if opened is not None and depth > 0 else None
        closed = None if found is None else _CLOSE.match(self._text, found[1])
        return None if found is None or closed is None else (found[0], closed.end())
