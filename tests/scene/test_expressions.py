"""Expressions: their trees, and their values against Python's own arithmetic."""

from __future__ import annotations

import math

import pytest
from hypothesis import strategies as st

from mbproj.scene.expressions.evaluate import FUNCTIONS, Unavailable, Value, evaluate
from mbproj.scene.expressions.syntax_tree import (
    Binary,
    Call,
    ExpressionError,
    NameNode,
    Negative,
    NumberNode,
    QuantityNode,
    depth,
    names,
    parse,
)
from tests.crossed import campaign

PYTHON = {name: function.compute for name, function in FUNCTIONS.items()} | {"pi": math.pi, "a": 1.25, "b": -3.0}
KNOWN = {"a": Value(1.25, None), "b": Value(-3.0, None)}


def python(text: str) -> float | None:
    """What Python makes of the text; None where that is no finite real number."""
    try:
        found = eval(text.strip(), {"__builtins__": {}}, PYTHON)
    except (ArithmeticError, ValueError, TypeError):
        return None
    return None if isinstance(found, complex) or not math.isfinite(found) else float(found)


def test_the_tree_of_an_expression() -> None:
    assert parse("-(a + 2 mm)") == Negative(
        Binary("+", NameNode("a", 2), QuantityNode(NumberNode(2.0, 6), "mm", 8), 4), 0
    )
    assert parse("2*sin(pi)") == Binary("*", NumberNode(2.0, 0), Call("sin", (NameNode("pi", 6),), 2), 1)


def test_names_and_depth_of_a_tree() -> None:
    assert names(parse("a + sin(b * pi)")) == {"a", "b", "pi"}
    assert depth(parse("1 + 2 * 3")) == 3
    assert depth(parse("+".join("1" * 100))) == 100


AS_IN_PYTHON = [
    "-2**2",
    "2**-1",
    "2**3**2",
    "(2**3)**2",
    "-2**-2",
    "--3",
    "+-+4",
    "2-3-4",
    "2/3/4",
    "2*3+4*5",
    "2+3*4**2/8",
    "6/2*(1+2)",
    "1e-6*1E6",
    ".5+1.",
    "pi/4*4",
    "atan2(1,-1)",
    "hypot(3,4)",
    "min(3,1,2)",
    "max(-1,-2)",
    "abs(-3)",
    "-2*-3",
    "floor(-1.5)",
    "ceil(-1.5)",
    "sqrt(2)",
    "log10(1e-6)",
    "exp(log(3))",
    "sign(-2)+sign(0)*5+sign(7)",
    "cosh(1)-sinh(1)-exp(-1)",
    " 1 +\t2 ",
    "sin (pi/6)",
    "asin(1)+acos(0)+atan(1)",
    "tanh(tan(1))",
]


@pytest.mark.parametrize("text", AS_IN_PYTHON)
def test_values_as_in_python(text: str) -> None:
    assert evaluate(parse(text), {}).number == python(text)


SPECIAL = ["a", "b", "pi", "0.0", "2e-3", "3.", ".5"]
LEAVES = st.floats(0.1, 4).map(lambda x: repr(round(x, 3))) | st.sampled_from(SPECIAL)
ONE, TWO = ["sin", "cos", "atan", "tanh", "sqrt", "abs", "log", "sign", "floor"], ["min", "max", "hypot", "atan2"]


def operations(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    """Texts one level up: with and without parentheses, so that precedence matters."""
    operators = st.sampled_from([" + ", "-", " * ", "/", "**"])
    return st.one_of(
        st.tuples(inner, operators, inner).map("".join),
        st.tuples(st.just("("), inner, operators, inner, st.just(")")).map("".join),
        inner.map("-{}".format),
        st.tuples(st.sampled_from(ONE), inner).map(lambda parts: f"{parts[0]}({parts[1]})"),
        st.tuples(st.sampled_from(TWO), inner, inner).map(lambda parts: f"{parts[0]}({parts[1]}, {parts[2]})"),
    )


@campaign(st.recursive(LEAVES, operations, max_leaves=8), few=100, many=400)
def test_random_expressions_as_in_python(text: str) -> None:
    try:
        found = evaluate(parse(text), KNOWN).number
    except ExpressionError:
        found = None
    assert found == python(text)


@campaign(
    st.text(alphabet="0123456789.eE+-*/()^, abmsindegrp/\n_", max_size=60) | st.text(max_size=30), few=40, many=300
)
def test_any_text_is_an_expression_or_an_error_within_it(text: str) -> None:
    try:
        found = evaluate(parse(text), KNOWN)
    except ExpressionError as error:
        assert 0 <= error.at <= len(text)
    else:
        assert math.isfinite(found.number)


@campaign(st.floats(allow_nan=False, allow_infinity=False), few=50, many=100)
def test_numbers_survive(number: float) -> None:
    assert evaluate(parse(repr(number)), {}).number == number


def test_a_name_whose_value_is_wrong_makes_no_second_error() -> None:
    with pytest.raises(Unavailable):
        evaluate(parse("2 * x"), {"x": None})
