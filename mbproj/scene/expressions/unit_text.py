"""Units as they are written: products, quotients and powers of the symbols, as in kg*mm^2, N·s/mm, N/(m*s), 1/s.

    unit   = [1 /] factor {(* | · | /) factor}
    factor = (symbol | (unit)) [^ number | ² | ³]

A symbol may be a name of the scene as well, as a parameter `m`. Right behind a number it is the unit: `2 m`. Further on
it is the unit where nothing else can stand: before a power (`2 kg*m^2`), before a symbol that is no name (`2 N*m/rad`),
within parentheses that have such a symbol (`2 (kg*m)`), and in the usual units of `COMPOUNDS` without spaces (`2 N*m`,
`40 kN/m`). Elsewhere it could be both, as in `2 kg*m` and `2 N * m`, which is an error.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Set
from functools import lru_cache
from itertools import product

from mbproj.errors import did_you_mean
from mbproj.scene.expressions.units import ANGLE, FORCE, LENGTH, MASS, SYMBOLS, TIME, Dimension, Unit

#: The usual units of two symbols and more: torques, stiffnesses, dampings, masses by length, velocities, flows.
_USUAL = ("F*L", "F/L", "F*T/L", "F*L*T", "M/T", "M/L", "L/T", "L^3/T", "A/T")
_KINDS = {"F": FORCE, "L": LENGTH, "M": MASS, "T": TIME, "A": ANGLE}
#: Symbols that are units in compounds alone: elsewhere l is the length of a spring.
_LITRES = {"l": Unit(Dimension(length=3), divide=1000.0)}


def _compounds() -> Iterator[str]:
    """The usual units, with all symbols of their kinds."""
    alike = {kind: [name for name, unit in SYMBOLS.items() if unit.dimension == its] for kind, its in _KINDS.items()}
    for pattern in _USUAL:
        yield from map("".join, product(*(alike.get(each, each) for each in pattern)))
    yield from (f"{litre}/{time}" for litre in _LITRES for time in ("min", "s"))


#: Units that are units without spaces, whatever the names of the scene are.
COMPOUNDS = frozenset(_compounds())
#: The most levels of parentheses in a unit.
MAX_DEPTH = 5

_NAME = re.compile(r"\s*([A-Za-z_][A-Za-z0-9_]*)(?![A-Za-z0-9_]|\.[A-Za-z_])")
_LITRE = re.compile(r"\s*(l)(?=/(?:min|s)(?![A-Za-z0-9_]))")
_OPERATOR = re.compile(r"\s*([*·⋅/])(?!\*)")
_POWER = re.compile(r"\s*(?:\^\s*(?P<number>[-+]?[0-9]{1,6}(?:\.[0-9]{1,12})?)(?![0-9.])|(?P<raised>[²³]))")
_ONE_OVER = re.compile(r"\s*1\s*/(?!\*)")
_OPEN, _CLOSE = re.compile(r"\s*\("), re.compile(r"\s*\)")
_POWER_OF_NUMBER = re.compile(r"\s*\*\*")
_RAISED = {"²": 2, "³": 3}
#: Units that are often written without a sign between them: Nm, kgm, Ns.
_RUN_TOGETHER = {a + b: f"{a}*{b}" for a in ("N", "kN", "kg", "g") for b in ("m", "mm", "cm")}
_RUN_TOGETHER |= {"Ns": "N*s", "Nms": "N*m*s"}


class UnclearUnit(Exception):
    """A symbol that could be a unit, or what has its name in the scene: the `word`, the character of the text `at`
    which it is, where what is certainly a unit ends, where the whole unit would end, and whether parentheses around all
    of it settle that it is one."""

    def __init__(self, word: str, at: int, certain: int, end: int, settles: bool) -> None:
        super().__init__(word)
        self.word, self.at, self.certain, self.end, self.settles = word, at, certain, end, settles


def unit_at(text: str, at: int, names: Set[str] = frozenset()) -> tuple[Unit, int] | None:
    """The unit that begins at this character of the text, and where it ends; None where none does. `names` are the
    symbols that are names of the scene as well. Raises UnclearUnit where one of them could be both."""
    reader = _Reader(text, at, names)
    found = reader.unit(at, MAX_DEPTH)
    if found is None or reader.unclear is None:
        return found
    usual = text[at : found[1]] in COMPOUNDS and _POWER_OF_NUMBER.match(text, found[1]) is None
    if not usual:
        raise UnclearUnit(*reader.unclear, reader.certain, found[1], reader.settled)
    return found


@lru_cache(maxsize=256)
def unit_of(text: str) -> Unit:
    """The unit that the whole text is. Raises ValueError where it is none."""
    unit = unit_at(text, 0)
    if unit is None or text[unit[1] :].strip():
        raise ValueError(f"'{text}' is no unit")
    return unit[0]


def similar_unit(word: str) -> str | None:
    """A hint with the unit that an unknown word was probably meant to be; None where none is similar."""
    if word in _RUN_TOGETHER:
        return f"did you mean '{_RUN_TOGETHER[word]}'?"
    return did_you_mean(word, SYMBOLS) if len(word) > 1 else None


class _Reader:
    """Reads a unit in a text. `unclear` is the last symbol that could be a name, and its place, where nothing after it
    settles that it is a unit; `certain` is where what is settled ends."""

    def __init__(self, text: str, start: int, names: Set[str]) -> None:
        self._text, self._start, self._names = text, start, names
        self.unclear: tuple[str, int] | None = None
        self.certain = start
        self.settled = False

    def unit(self, at: int, depth: int) -> tuple[Unit, int] | None:
        """The unit at this character, and where it ends."""
        one = _ONE_OVER.match(self._text, at)
        factor = self._factor(at if one is None else one.end(), depth)
        if factor is None:
            return None
        unit, end = factor if one is None else (factor[0] ** -1, factor[1])
        if depth == MAX_DEPTH and _OPEN.match(self._text, at) is None:
            self.unclear = None  # right behind a number
        certain = at if self.unclear else end
        while (sign := _OPERATOR.match(self._text, end)) is not None:
            so_far = self.unclear, self.settled
            factor = self._factor(sign.end(), depth)
            if factor is None:
                self.unclear, self.settled = so_far
                break
            unit, end = unit * (factor[0] ** -1 if sign[1] == "/" else factor[0]), factor[1]
            certain = certain if self.unclear else end
        self.certain = certain
        return unit, end

    def _factor(self, at: int, depth: int) -> tuple[Unit, int] | None:
        """A symbol or a unit in parentheses, with its power, and where it ends."""
        unit_and_end = self._symbol(at) or self._group(at, depth)
        if unit_and_end is None:
            return None
        unit, end = unit_and_end
        power = _POWER.match(self._text, end)
        if power is None:
            return unit, end
        self.unclear, self.settled = None, True
        exponent = float(power["number"]) if power["number"] else _RAISED[power["raised"]]
        return unit**exponent, power.end()

    def _symbol(self, at: int) -> tuple[Unit, int] | None:
        litre, name = _LITRE.match(self._text, at), _NAME.match(self._text, at)
        if name is None or (name[1] not in SYMBOLS and litre is None):
            return None
        if name.start(1) != self._start and _OPEN.match(self._text, name.end()):
            return None  # a function
        is_name = name[1] in self._names
        self.unclear = (name[1], name.start(1)) if is_name else None
        self.settled = self.settled or not is_name
        return (_LITRES if litre else SYMBOLS)[name[1]], name.end()

    def _group(self, at: int, depth: int) -> tuple[Unit, int] | None:
        """A unit in parentheses. One symbol that is no name of the scene settles that all of them are units."""
        before, self.settled = self.settled, False
        opened = _OPEN.match(self._text, at)
        inner = self.unit(opened.end(), depth - 1) if opened is not None and depth > 0 else None
        closed = None if inner is None else _CLOSE.match(self._text, inner[1])
        self.unclear = None if self.settled else self.unclear
        self.settled = self.settled or before
        return None if inner is None or closed is None else (inner[0], closed.end())
