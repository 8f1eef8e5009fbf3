"""Expressions: text -> tokens -> a small immutable tree. `evaluate` and `compiled` give names a meaning and compute the
value.

sum     = [+ -] product {(+ | -) product}        ** binds tighter than a sign before it, and to the right
operand = (number | name | name(sum, ...) | (sum)) [unit]          `unit_text` has what a unit is

The token before a name decides whether the name is a unit, or a parameter or function.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Set
from functools import lru_cache
from typing import TypeAlias

from mbproj.base.dataclass import dataclass
from mbproj.scene.expressions.units import UnclearUnit, Unit, similar_unit, unit_at


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
_FIRST_SYMBOL = re.compile(r"[(\s]*([A-Za-z_]+)")
#: A name right after one of these can only be a unit.
_ENDS_OPERAND = ("number", "name", ")")
HINTS = {
    "^": "write ** for powers",
    ",": "decimals take a point",
    "·": "write * to multiply",
    "number": "an operator is missing",
    "name": "write * between the units, as in kg*m^2",
}


def tokens(text: str, named: Set[str] = frozenset()) -> Iterator[Token]:
    """The tokens of `text` in order, then one of kind "end"; operators are their own kind. `named` are the symbols of
    units that are names here, as of a parameter.

    Raises ExpressionError for a character or a unit that is unknown, or a symbol that could be a unit or what it names.
    """
    at, before, operand = 0, "", ""
    while (match := _PATTERN.match(text, at)) is not None and match.lastgroup is not None:
        kind, start = match.lastgroup, match.start(match.lastgroup)
        word, at = match[kind], match.end()
        if kind == "wrong":
            raise ExpressionError(f"unexpected '{word}'", start, HINTS.get(word))
        if (kind in ("name", "number") and before in _ENDS_OPERAND) or (word == "(" and before in ("number", ")")):
            unit = _unit(text, start, named, operand)
            if unit is None and kind == "name":
                raise ExpressionError(f"unknown unit '{word}'", start, similar_unit(word) or "write * to multiply")
            if unit is not None:
                kind, word, at = "unit", text[start : unit[1]], unit[1]
        before, operand = word if kind == "operator" else kind, word if kind == "number" else ".."
        yield Token(before, word, start)
    yield Token("end", "", len(text.rstrip()))


def _unit(text: str, at: int, named: Set[str], operand: str) -> tuple[Unit, int] | None:
    """`unit_at` behind an operand. Raises ExpressionError where a symbol could be both."""
    try:
        return unit_at(text, at, named)
    except UnclearUnit as unclear:
        whole, certain = text[at : unclear.end], text[at : unclear.certain]
        word, rest = unclear.word, text[unclear.certain : unclear.end]
        named_by = f"({operand} {certain}){rest}" if certain else f"{operand}*{whole}"
        as_unit = f"{operand} ({whole})" if unclear.settles else f"(1 {word})"
        hint = f"write {named_by} for what '{word}' names, {as_unit} for the unit"
        raise unclear_name(word, unclear.at, hint) from None


def unclear_name(word: str, at: int, hint: str) -> ExpressionError:
    """The error of a symbol that could be a unit, or what has its name in the scene."""
    return ExpressionError(f"'{word}' could be the unit {word}, or the '{word}' that is named here", at, hint)


MAX_LENGTH = 1000
MAX_DEPTH = 100


@dataclass(frozen=True)
class NumberNode:
    value: float
    at: int


@dataclass(frozen=True)
class NameNode:
    name: str
    at: int


@dataclass(frozen=True)
class QuantityNode:
    """`operand` in `unit`; `at` is where the unit stands."""

    operand: Expression
    unit: str
    at: int


@dataclass(frozen=True)
class Negative:
    operand: Expression
    at: int


@dataclass(frozen=True)
class Binary:
    operator: str
    left: Expression
    right: Expression
    at: int


@dataclass(frozen=True)
class Call:
    function: str
    arguments: tuple[Expression, ...]
    at: int


Expression: TypeAlias = "NumberNode | NameNode | QuantityNode | Negative | Binary | Call"


@lru_cache(maxsize=4096)
def parse(text: str, named: Set[str] = frozenset()) -> Expression:
    """The tree of `text`, at most MAX_LENGTH characters and MAX_DEPTH levels. `named` has the names that it may use, as
    of parameters; those that are symbols of units too decide what is a unit. Raises ExpressionError."""
    if len(text) > MAX_LENGTH:
        raise ExpressionError(
            f"the expression has {len(text)} characters, at most {MAX_LENGTH} are allowed",
            0,
            "name parts of it under 'parameters'",
        )
    parser = _ExpressionParser(text, named)
    tree = parser.expression(0, 1)
    parser.expect("end")
    if depth(tree) > MAX_DEPTH:
        raise _too_deep(0)
    return tree


def children(tree: Expression) -> tuple[Expression, ...]:
    """The nodes right below this one."""
    match tree:
        case QuantityNode() | Negative():
            return (tree.operand,)
        case Binary():
            return (tree.left, tree.right)
        case Call():
            return tree.arguments
        case _:
            return ()


def walk(tree: Expression) -> Iterator[tuple[Expression, int]]:
    """Every node of the tree with its depth, the root's being 1; without recursion, so of any depth."""
    waiting = [(tree, 1)]
    while waiting:
        node, level = waiting.pop()
        yield node, level
        waiting.extend((part, level + 1) for part in children(node))


def depth(tree: Expression) -> int:
    """The number of levels of the tree."""
    return max(level for _, level in walk(tree))


def names(tree: Expression) -> frozenset[str]:
    """The names that the tree uses, functions excepted."""
    return frozenset(node.name for node, _ in walk(tree) if isinstance(node, NameNode))


def _too_deep(at: int) -> ExpressionError:
    return ExpressionError(
        f"the expression has more than {MAX_DEPTH} levels", at, "name parts of it under 'parameters'"
    )


#: The binding powers of an operator to its left and to its right: ** groups to the right, the others to the left.
_BINDING = {"+": (1, 2), "-": (1, 2), "*": (3, 4), "/": (3, 4), "**": (7, 6)}
_SIGN = 5


class _ExpressionParser:
    """Precedence climbing over the tokens of one text."""

    def __init__(self, text: str, named: Set[str]) -> None:
        self._tokens, self._named = tokens(text, named), named
        self._next = next(self._tokens)

    def expression(self, binding: int, level: int) -> Expression:
        """The expression from here up to an operator that binds less than `binding`."""
        left = self._signed(level)
        while (power := _BINDING.get(self._next.kind)) is not None and power[0] >= binding:
            operator = self._advance()
            left = Binary(operator.kind, left, self.expression(power[1], level + 1), operator.at)
        return left

    def expect(self, kind: str) -> Token:
        """Take the next token, which must be of this kind."""
        if self._next.kind != kind:
            raise self._unexpected("')' is missing" if kind == ")" else None)
        return self._next if kind == "end" else self._advance()

    def _signed(self, level: int) -> Expression:
        if level > MAX_DEPTH:
            raise _too_deep(self._next.at)
        if self._next.kind not in ("+", "-"):
            return self._quantity(level)
        sign = self._advance()
        operand = self.expression(_SIGN, level + 1)
        return Negative(operand, sign.at) if sign.kind == "-" else operand

    def _quantity(self, level: int) -> Expression:
        operand = self._operand(level)
        if self._next.kind != "unit":
            return operand
        unit = self._advance()
        first = _FIRST_SYMBOL.match(unit.text)
        if first is not None and first[1] in self._named and names(operand):
            hint = f"write * to multiply, or *(1 {unit.text}) for the unit"
            raise unclear_name(first[1], unit.at + first.start(1), hint)
        if self._next.kind == "**":
            raise ExpressionError(
                "it is unclear what '**' after a unit applies to",
                self._next.at,
                "write 2 m^2 for square metres, (2 m)**2, or 2**2 m",
            )
        return QuantityNode(operand, unit.text, unit.at)

    def _operand(self, level: int) -> Expression:
        token = self._next
        if token.kind == "number":
            return NumberNode(float(self._advance().text), token.at)
        if token.kind == "name":
            self._advance()
            return self._call(token, level) if self._next.kind == "(" else NameNode(token.text, token.at)
        if token.kind == "(":
            self._advance()
            inner = self.expression(0, level + 1)
            self.expect(")")
            return inner
        raise self._unexpected(None)

    def _call(self, function: Token, level: int) -> Expression:
        self._advance()
        arguments = [self.expression(0, level + 1)]
        while self._next.kind == ",":
            self._advance()
            arguments.append(self.expression(0, level + 1))
        self.expect(")")
        return Call(function.text, tuple(arguments), function.at)

    def _advance(self) -> Token:
        token, self._next = self._next, next(self._tokens)
        return token

    def _unexpected(self, missing: str | None) -> ExpressionError:
        token = self._next
        if token.kind == "end":
            return ExpressionError(missing or "the expression ends too early", token.at)
        return ExpressionError(f"unexpected '{token.text}'", token.at, missing or HINTS.get(token.kind))
