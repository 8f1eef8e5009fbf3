"""The value of an expression's tree: a finite number in SI and radians, and its dimension where that is known."""

from __future__ import annotations

import math
import operator
from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType

from mbproj.base.cases import per_case
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import choose_from, did_you_mean
from mbproj.scene.expressions.dimensions import Inferred, of_binary, of_call, of_quantity
from mbproj.scene.expressions.syntax_tree import (
    Binary,
    Call,
    Expression,
    ExpressionError,
    NameNode,
    Negative,
    NumberNode,
    QuantityNode,
)
from mbproj.scene.expressions.units import ANGLE, BARE, SYMBOLS, Dimension, similar_unit, unit_of


@dataclass(frozen=True)
class Value:
    """A number in SI and radians. `dimension` is None where it is not known, because a parameter has no unit."""

    number: float
    dimension: Dimension | None = BARE


class Unavailable(Exception):
    """The value of a named parameter is wrong, which is reported at that parameter."""


@dataclass(frozen=True)
class ExpressionFunction:
    """A function of expressions: how to compute it, and how many arguments it takes.

    `paired`: the arguments after the first are pairs (x, y) of numbers, x increasing, and the value is a y. `same`: all
    arguments have one dimension, whichever; otherwise they are angles or have no unit. `result` is the dimension of the
    value; None: that of the arguments to the power `power`.
    """

    compute: Callable[..., float]
    least: int = 1
    most: int | None = 1
    result: Dimension | None = BARE
    same: bool = False
    power: float = 1.0
    paired: bool = False

    @property
    def keeps_dimension(self) -> bool:
        """Whether its value has the dimension of its arguments."""
        return self.same and self.result is None and self.power == 1.0


def _sign(x: float) -> float:
    return math.copysign(1.0, x) if x else 0.0


def _clip(x: float, low: float, high: float) -> float:
    return min(max(x, low), high)


def _table(x: float, *rows: float) -> float:
    """The piecewise linear function through the points (x, y), ..., extended beyond both ends."""
    at = min(max(bisect_right(rows[::2], x), 1), len(rows) // 2 - 1)
    x0, y0, x1, y1 = rows[2 * at - 2 : 2 * at + 2]
    return y0 + (x - x0) * (y1 - y0) / (x1 - x0)


FUNCTIONS: Mapping[str, ExpressionFunction] = MappingProxyType(
    {
        **{
            name: ExpressionFunction(getattr(math, name))
            for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp", "log", "log10", "floor", "ceil")
        },
        **{name: ExpressionFunction(getattr(math, name), result=ANGLE) for name in ("asin", "acos", "atan")},
        "atan2": ExpressionFunction(math.atan2, 2, 2, ANGLE, same=True),
        "sign": ExpressionFunction(_sign, same=True),
        "sqrt": ExpressionFunction(math.sqrt, result=None, same=True, power=0.5),
        "abs": ExpressionFunction(abs, result=None, same=True),
        "min": ExpressionFunction(lambda *numbers: min(numbers), 1, None, None, same=True),
        "max": ExpressionFunction(lambda *numbers: max(numbers), 1, None, None, same=True),
        "hypot": ExpressionFunction(math.hypot, 1, None, None, same=True),
        "clip": ExpressionFunction(_clip, 3, 3, None, same=True),
        "deadband": ExpressionFunction(lambda x, half: x - _clip(x, -half, half), 2, 2, None, same=True),
        "table": ExpressionFunction(_table, 5, None, None, paired=True),
    }
)
CONSTANTS: Mapping[str, Value] = MappingProxyType({"pi": Value(math.pi)})
#: Names that no parameter may have: expressions use them for functions, constants or the time.
RESERVED = frozenset({*FUNCTIONS, *CONSTANTS, "t", "inf", "nan"})

_OPERATORS: Mapping[str, Callable[[float, float], float]] = MappingProxyType(
    {"+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv, "**": operator.pow}
)
_NOT_HERE = {
    "t": "'t' (time) cannot be used here",
    "inf": "numbers must be finite",
    "nan": "numbers must be finite",
}


def evaluate(tree: Expression, names: Mapping[str, Value | None]) -> Value:
    """The value of the tree, with `names` for the parameters (None: its own value is wrong) besides `CONSTANTS`.

    Raises ExpressionError for unknown names, units that do not fit and results that are no finite number, and
    Unavailable where a name stands for None.
    """
    match tree:
        case NumberNode():
            return Value(_finite(tree.at, float, tree.value))
        case NameNode():
            return _lookup(tree, names)
        case Negative():
            operand = evaluate(tree.operand, names)
            return Value(-operand.number, operand.dimension)
        case QuantityNode():
            return _with_unit(tree, evaluate(tree.operand, names))
        case Binary():
            return _binary(tree, evaluate(tree.left, names), evaluate(tree.right, names))
        case Call():
            return _call(tree, [evaluate(argument, names) for argument in tree.arguments], names)


def _lookup(tree: NameNode, names: Mapping[str, Value | None]) -> Value:
    if tree.name in CONSTANTS:
        return CONSTANTS[tree.name]
    if tree.name in names:
        value = names[tree.name]
        if value is None:
            raise Unavailable
        return value
    if tree.name in _NOT_HERE:
        raise ExpressionError(_NOT_HERE[tree.name], tree.at)
    if "." in tree.name:
        raise not_here(tree)
    hint = did_you_mean(tree.name, [*names, *CONSTANTS]) or similar_unit(tree.name)
    if tree.name in SYMBOLS:
        hint = f"a unit stands after a number: 2 {tree.name}, or 2 1/{tree.name}"
    raise ExpressionError(f"unknown name '{tree.name}'", tree.at, hint or "parameters are defined under 'parameters'")


def not_here(tree: NameNode) -> ExpressionError:
    """The error of a name of something that moves or is computed, where an expression must be constant."""
    called = tree.name.replace(".", "_")
    hint = f"signals, states and forces may name it; elements call it {called}; motions are functions of t alone"
    return ExpressionError(f"'{tree.name}' cannot be used here", tree.at, hint)


def _with_unit(tree: QuantityNode, operand: Value) -> Value:
    dimension, unit = of_quantity(tree, Inferred.of(operand.dimension)).dimension, unit_of(tree.unit)
    scaled = _finite(tree.at, operator.mul, operand.number, unit.multiply)
    return Value(_finite(tree.at, operator.truediv, scaled, unit.divide), dimension)


def _binary(tree: Binary, left: Value, right: Value) -> Value:
    number = _finite(tree.at, _OPERATORS[tree.operator], left.number, right.number)
    inferred = of_binary(tree, Inferred.of(left.dimension), Inferred.of(right.dimension), right.number)
    return Value(number, inferred.dimension)


def _call(tree: Call, arguments: list[Value], names: Mapping[str, Value | None]) -> Value:
    function = function_of(tree, names)
    dimension = of_call(tree, function, [Inferred.of(argument.dimension) for argument in arguments]).dimension
    if function.paired:
        increasing(tree, [argument.number for argument in arguments[1::2]])
    return Value(_finite(tree.at, function.compute, *(argument.number for argument in arguments)), dimension)


def function_of(tree: Call, names: Iterable[str]) -> ExpressionFunction:
    """The function that is called. Raises ExpressionError where it is unknown or has another number of arguments;
    `names` are parameters, which may have been meant as a factor."""
    function = FUNCTIONS.get(tree.function)
    if function is None:
        known = tree.function in {*names, *CONSTANTS}
        hint = "write * to multiply" if known else choose_from(tree.function, FUNCTIONS, "functions are")
        raise ExpressionError(f"unknown function '{tree.function}'", tree.at, hint)
    count = len(tree.arguments)
    if count < function.least or (function.most is not None and count > function.most):
        needs = "1 argument" if function.least == 1 else f"{function.least} arguments"
        raise ExpressionError(f"'{tree.function}' takes {needs}, found {count}", tree.at)
    if function.paired and count % 2 == 0:
        raise ExpressionError(f"'{tree.function}' takes x, x1, y1, x2, y2, ...; a number is missing", tree.at)
    return function


def increasing(tree: Call, numbers: Sequence[float]) -> None:
    """Raises ExpressionError where the x of a table, `numbers`, do not increase."""
    for before, after in pairwise(numbers):
        if not after > before:
            raise ExpressionError(f"'{tree.function}' has x = {after:g} after {before:g}", tree.at, "x must increase")


@per_case
def _finite(at: int, compute: Callable[..., float], *numbers: float) -> float:
    """compute(*numbers). Raises ExpressionError where that is not a finite number."""
    try:
        result = compute(*numbers)
    except ZeroDivisionError:
        raise ExpressionError("division by zero", at) from None
    except OverflowError:
        raise ExpressionError("the result is too large", at) from None
    except ValueError:
        arguments = ", ".join(f"{number:.6g}" for number in numbers)
        raise ExpressionError(f"not defined for {arguments}", at) from None
    if isinstance(result, complex):
        raise ExpressionError("a power of a negative number needs a whole exponent", at)
    if not math.isfinite(result):
        raise ExpressionError("the result is too large", at)
    return float(result)
