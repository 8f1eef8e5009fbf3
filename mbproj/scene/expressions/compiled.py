"""Expressions with variables: tree -> program. Parts without a variable become numbers at once."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

from mbproj.base.errors import did_you_mean
from mbproj.functions.program import CHANNELS, Code, Instruction, Op, Program, apply, number, replaced, variable
from mbproj.functions.standard import combine
from mbproj.functions.table import polygon
from mbproj.scene.expressions.dimensions import UNKNOWN, Inferred, Origin, of_binary, of_call, of_quantity
from mbproj.scene.expressions.evaluate import CONSTANTS, Value, evaluate, function_of, increasing, not_here
from mbproj.scene.expressions.syntax_tree import (
    Binary,
    Call,
    Expression,
    ExpressionError,
    NameNode,
    Negative,
    NumberNode,
    QuantityNode,
    children,
    names,
    parse,
    walk,
)
from mbproj.scene.expressions.units import SYMBOLS, similar_unit

_OPERATORS: Mapping[str, Op] = MappingProxyType(
    {"+": Op.ADD, "-": Op.SUBTRACT, "*": Op.MULTIPLY, "/": Op.DIVIDE, "**": Op.POWER_OF}
)
#: The number of each variable in programs, by its name.
Variables = Mapping[str, int]
Parameters = Mapping[str, Value | None]
#: The dimensions of variables, by name.
Dimensions = Mapping[str, Inferred]


def compiled(
    tree: Expression, parameters: Parameters, variables: Variables, known: Dimensions = MappingProxyType({})
) -> tuple[Code, Inferred]:
    """The program of the tree, and the dimension of its value; `known` are those of variables. Units that do not fit
    each other are no error where numbers or names without unit may bring others (`may_be_any`).

    Raises ExpressionError and Unavailable as `evaluate` does, and where a variable has the name of a parameter.
    """
    return _compiled(tree, parameters, variables, known, may_be_any(tree, parameters, known))


def _compiled(
    tree: Expression, parameters: Parameters, variables: Variables, known: Dimensions, lenient: bool
) -> tuple[Code, Inferred]:
    """`compiled`; `lenient`: parts whose units do not fit each other have no known dimension, and are no error."""
    if not names(tree) & variables.keys():
        _refuse_unknown(tree, parameters, variables)
        value = evaluate(tree, parameters)
        return number(value.number), Inferred.of(value.dimension, scaled=_has_bare_number(tree))
    match tree:
        case NameNode():
            if tree.name in parameters:
                clash = f"'{tree.name}' is a parameter, and a variable here"
                raise ExpressionError(clash, tree.at, "give the parameter another name")
            return variable(variables[tree.name]), known.get(tree.name, UNKNOWN)
        case Negative():
            code, dimension = _compiled(tree.operand, parameters, variables, known, lenient)
            return apply(Op.NEGATE, code), dimension
        case QuantityNode():
            code, dimension = _compiled(tree.operand, parameters, variables, known, lenient)
            one = evaluate(replace(tree, operand=NumberNode(1.0, tree.at)), {})
            return apply(Op.MULTIPLY, code, number(one.number)), of_quantity(tree, dimension)
        case Binary():
            return _binary(tree, parameters, variables, known, lenient)
        case Call():
            return _call(tree, parameters, variables, known, lenient)
    raise AssertionError(tree)


def may_be_any(tree: Expression, parameters: Parameters, known: Dimensions) -> bool:
    """Whether a name of the expression has no known unit, or all its numbers are without unit, in SI."""
    values = {name: parameters[name] for name in names(tree) & parameters.keys()}
    units = [known.get(name, UNKNOWN).dimension for name in names(tree) - parameters.keys() - CONSTANTS.keys()]
    units += [value.dimension for value in values.values() if value is not None]
    fixed = any(known[name].origin is Origin.FIXED for name in names(tree) & known.keys())
    has_unit = fixed or bool(values) or any(isinstance(node, QuantityNode) for node, _ in walk(tree))
    return None in units or (_has_bare_number(tree) and not has_unit)


def _fitting(of: Callable[[], Inferred], lenient: bool) -> Inferred:
    """The dimension of a part. Raises ExpressionError where its units do not fit each other, unless `lenient`."""
    try:
        return of()
    except ExpressionError:
        if lenient:
            return UNKNOWN
        raise


def _has_bare_number(tree: Expression) -> bool:
    """Whether a number without unit is in the expression, other than an exponent."""
    if isinstance(tree, Binary) and tree.operator == "**":
        return _has_bare_number(tree.left)
    if isinstance(tree, QuantityNode):
        return False
    return isinstance(tree, NumberNode) or any(map(_has_bare_number, children(tree)))


def _refuse_unknown(tree: Expression, parameters: Parameters, variables: Variables) -> None:
    """Raises ExpressionError for an unknown name; the hint suggests parameters and variables."""
    for node, _ in walk(tree):
        if isinstance(node, NameNode) and "." in node.name:
            raise not_here(node)
        if isinstance(node, NameNode) and node.name not in {*parameters, *CONSTANTS, *SYMBOLS, "inf", "nan"}:
            similar = did_you_mean(node.name, [*variables, *parameters, *CONSTANTS]) or similar_unit(node.name)
            hint = similar or f"variables here are {', '.join(variables)}"
            raise ExpressionError(f"unknown name '{node.name}'", node.at, hint)


def _binary(
    tree: Binary, parameters: Parameters, variables: Variables, known: Dimensions, lenient: bool
) -> tuple[Code, Inferred]:
    left, left_dimension = _compiled(tree.left, parameters, variables, known, lenient)
    right, right_dimension = _compiled(tree.right, parameters, variables, known, lenient)
    constant = right[0].operand if len(right) == 1 and right[0].op is Op.CONSTANT else None
    dimension = _fitting(lambda: of_binary(tree, left_dimension, right_dimension, constant), lenient)
    if tree.operator == "**" and constant is not None:
        return (*left, Instruction(Op.POWER, constant)), dimension
    return apply(_OPERATORS[tree.operator], left, right), dimension


def _call(
    tree: Call, parameters: Parameters, variables: Variables, known: Dimensions, lenient: bool
) -> tuple[Code, Inferred]:
    function = function_of(tree, [*parameters, *variables])
    arguments = [_compiled(argument, parameters, variables, known, lenient) for argument in tree.arguments]
    dimensions = [dimension for _, dimension in arguments]
    dimension = _fitting(lambda: of_call(tree, function, dimensions), lenient)
    if tree.function in _WRITTEN_OUT:
        return _WRITTEN_OUT[tree.function](tree, [code for code, _ in arguments]), dimension
    op = Op.ABS if tree.function == "hypot" and len(arguments) == 1 else Op[tree.function.upper()]
    return apply(op, *(code for code, _ in arguments)), dimension


def _clip(tree: Call, arguments: list[Code]) -> Code:
    x, low, high = arguments
    return apply(Op.MIN, apply(Op.MAX, x, low), high)


def _deadband(tree: Call, arguments: list[Code]) -> Code:
    x, half = arguments
    return apply(Op.SUBTRACT, x, _clip(tree, [x, apply(Op.NEGATE, half), half]))


def _table(tree: Call, arguments: list[Code]) -> Code:
    x, *rows = arguments
    numbers = [code[0].operand for code in rows if len(code) == 1 and code[0].op is Op.CONSTANT]
    if len(numbers) < len(rows):
        raise ExpressionError("the rows of a 'table' are numbers", tree.at, "table(x, x1, y1, x2, y2, ...)")
    increasing(tree, numbers[::2])
    return (*x, Instruction(Op.TABLE, 0.0, polygon([*zip(numbers[::2], numbers[1::2], strict=True)])))


#: Functions without an operation of programs: they are composed of other operations.
_WRITTEN_OUT: Mapping[str, Callable[[Call, list[Code]], Code]] = MappingProxyType(
    {"clip": _clip, "deadband": _deadband, "table": _table}
)


# --- Formulas as functions --------------------------------------------------------------------------------------------
# An expression whose names stand for numbers and for other functions.


def formula(text: str, **parts: float | Program) -> Program:
    """The program of the expression `text`; `parts` are the numbers and programs that its names stand for."""
    tree = parse(text, frozenset(parts))
    code, _ = compiled(tree, {}, {name: CHANNELS + at for at, name in enumerate(parts)})
    programs = [part if isinstance(part, Program) else Program(number(part)) for part in parts.values()]
    return combine(lambda *codes: replaced(code, {CHANNELS + at: each for at, each in enumerate(codes)}), *programs)
