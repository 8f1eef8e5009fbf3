"""Programs: their values are those of the expressions, their derivatives those of the functions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from mbproj.functions import values as values_module
from mbproj.functions.program import ARGUMENTS, CHANNELS, TIME, Op, Program, apply, number, variable
from mbproj.functions.program_set import SWITCHING, flatten
from mbproj.functions.series import constant_series, failure, run, slope, slopes, time_series
from mbproj.functions.standard import harmonic, polynomial, smooth_step, tabulated, uniform
from mbproj.functions.table import polygon, spline
from mbproj.functions.values import value, values
from mbproj.scene.expressions.compiled import compiled
from mbproj.scene.expressions.evaluate import Unavailable, Value, evaluate
from mbproj.scene.expressions.syntax_tree import ExpressionError, parse
from tests.crossed import campaign
from tests.functions.texts import SMOOTH, T, expression


def series(code, t=T):
    """Value and two derivatives of a code at times t."""
    return run(flatten([Program(code)]), 0, [time_series(t)])


def differences(code, t=T, h=1e-3):
    """First and second derivative by central differences of order 6."""
    f = {k: series(code, t + k * h)[0] for k in range(-3, 4)}
    first = (45 * (f[1] - f[-1]) - 9 * (f[2] - f[-2]) + (f[3] - f[-3])) / (60 * h)
    second = (270 * (f[1] + f[-1]) - 27 * (f[2] + f[-2]) + 2 * (f[3] + f[-3]) - 490 * f[0]) / (180 * h * h)
    return first, second


def test_slopes_by_several_variables_are_those_by_each():
    x, y, z = (variable(CHANNELS + k) for k in range(3))
    product = apply(Op.MULTIPLY, apply(Op.SIN, x), apply(Op.MULTIPLY, z, z))
    programs, at = flatten([Program(y), Program(product)]), [0.3, 0.1, 0.2, 0.7, -1.1, 0.4]
    named = programs.channels(1)
    assert named.tolist() == [CHANNELS, CHANNELS + 2]
    found = slopes(programs, 1, at, named)
    np.testing.assert_array_equal(found, [slope(programs, 1, at, each) for each in named])
    np.testing.assert_allclose(found, [np.cos(0.7) * 0.16, np.sin(0.7) * 0.8], rtol=1e-15)


@pytest.mark.parametrize("text", SMOOTH)
def test_derivatives_are_those_of_the_function(text):
    code = expression(text)
    _, first, second = series(code)
    by_differences = differences(code)
    np.testing.assert_allclose(first, by_differences[0], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(second, by_differences[1], rtol=1e-6, atol=1e-7)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("text", [text for text in SMOOTH if not SWITCHING & {each.op for each in expression(text)}])
def test_a_complex_step_is_their_derivative(text):
    """As third derivatives of rows ask for."""
    code, step = expression(text), 1e-100
    value, first, _ = run(flatten([Program(code)]), 0, [(T + 1j * step, 1.0 + 0.0 * T, 0.0 * T)])
    _, own, second = series(code)
    for found, expected in ((value, own), (first, second)):
        np.testing.assert_allclose(np.imag(found) / step + 0.0 * T, expected, rtol=1e-12, atol=1e-13)


def test_every_operation_is_among_them():
    used = {instruction.op for text in SMOOTH for instruction in expression(text)}
    assert used == set(Op) - {Op.TABLE, Op.SMOOTH_STEP}
    assert all(ARGUMENTS[op] in (0, 1, 2) for op in Op)


LEAVES = st.floats(0.1, 4).map(lambda x: repr(round(x, 3))) | st.sampled_from(["t", "t", "a", "pi", "0.0"])
ONE, TWO = ["sin", "atan", "tanh", "sqrt", "abs", "log", "floor", "hypot"], ["min", "max", "hypot", "atan2"]


def operations(inner):
    return st.one_of(
        st.tuples(st.just("("), inner, st.sampled_from([" + ", "-", "*", "/", "**"]), inner, st.just(")")).map("".join),
        inner.map("-{}".format),
        st.tuples(st.sampled_from(ONE), inner).map(lambda parts: f"{parts[0]}({parts[1]})"),
        st.tuples(st.sampled_from(TWO), inner, inner).map(lambda parts: f"{parts[0]}({parts[1]}, {parts[2]})"),
    )


@campaign(st.recursive(LEAVES, operations, max_leaves=8), st.floats(-2, 2).map(lambda x: round(x, 2)), few=75, many=300)
def test_values_are_those_of_the_expression(text, t):
    names = {"a": Value(1.25, None)}
    try:
        exact = evaluate(parse(text), {**names, "t": Value(t, None)}).number
        code, _ = compiled(parse(text), names, {"t": TIME})
    except (ExpressionError, Unavailable):
        return
    found = float(series(code, np.array(t))[0])
    assert found == pytest.approx(exact, rel=1e-12, abs=1e-12)
    assert float(value(flatten([Program(code)]), 0, [t])) == found


@pytest.mark.parametrize("times", [T, np.array(0.37)])
def test_values_without_derivatives_have_the_same_bits(times):
    """Also a term that stands in several programs, which is computed once."""
    codes = [expression(text) for text in SMOOTH] + [
        smooth_step(0.2, 1.3, 0.5, 2.0),
        tabulated(spline(ROWS, "natural")),
    ]
    codes += [apply(Op.ADD, codes[0], each) for each in codes]
    programs = flatten([Program(code) for code in codes])
    for index, found in enumerate(values(programs, range(programs.size), [times])):
        np.testing.assert_array_equal(
            np.broadcast_to(found, times.shape), run(programs, index, [time_series(times)])[0]
        )


def test_a_term_that_several_programs_share_is_computed_once(monkeypatch):
    counted = []
    counting = {**values_module.FUNCTIONS, Op.SIN: lambda x: counted.append(x) or np.sin(x)}
    monkeypatch.setattr(values_module, "FUNCTIONS", counting)
    sine = apply(Op.SIN, apply(Op.MULTIPLY, variable(TIME), number(3.0)))
    programs = flatten([Program(apply(Op.ADD, sine, sine)), Program(apply(Op.MULTIPLY, sine, number(-2.0)))])
    assert values(programs, (0, 1), [0.5]) == [2.0 * np.sin(1.5), -2.0 * np.sin(1.5)]
    assert len(counted) == 1


def test_standard_motions():
    value, rate, acceleration = series(harmonic(0.2, 3.0, 0.4, 1.0))
    np.testing.assert_allclose(value, 1.0 + 0.2 * np.sin(3.0 * T + 0.4), rtol=1e-14)
    np.testing.assert_allclose(rate, 0.6 * np.cos(3.0 * T + 0.4), rtol=1e-13)
    np.testing.assert_allclose(acceleration, -1.8 * np.sin(3.0 * T + 0.4), rtol=1e-13)
    value, rate, acceleration = series(polynomial((1.0, -2.0, 0.5, 0.25)))
    np.testing.assert_allclose(value, 1 - 2 * T + 0.5 * T**2 + 0.25 * T**3, rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(rate, -2 + T + 0.75 * T**2, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(acceleration, 1 + 1.5 * T, rtol=1e-14)
    np.testing.assert_array_equal(series(uniform(4.0))[1:], [np.full_like(T, 4.0), np.zeros_like(T)])
    np.testing.assert_array_equal(series(polynomial((7.0,)))[0], np.full_like(T, 7.0))


def test_a_smooth_step_is_twice_continuously_differentiable():
    step = smooth_step(1.0, 3.0, 0.5, 2.0)
    at = np.array([-1.0, 0.5, 1.5, 2.5, 9.0])
    np.testing.assert_allclose(series(step, at)[0], [1.0, 1.0, 2.0, 3.0, 3.0], rtol=1e-15)
    np.testing.assert_array_equal(series(step, at)[2], 0.0)
    np.testing.assert_allclose(series(step, at)[1], [0.0, 0.0, 2.0 / 2.0 * 30 / 16, 0.0, 0.0])
    inside = np.linspace(0.6, 2.4, 19)
    first, second = differences(step, inside)
    np.testing.assert_allclose(series(step, inside)[1], first, rtol=1e-9)
    np.testing.assert_allclose(series(step, inside)[2], second, rtol=1e-6, atol=1e-7)


ROWS = [(0.0, 0.0), (1.0, 1.0), (2.5, -1.0), (3.0, 2.0), (3.1, 2.0)]


@pytest.mark.parametrize("ends", ["natural", "clamped"])
@pytest.mark.parametrize("count", [2, 3, 5])
def test_splines_are_those_of_scipy(ends, count):
    exact = CubicSpline(*zip(*ROWS[:count], strict=True), bc_type=ends)
    x = np.linspace(0.0, ROWS[count - 1][0], 41)[:-1]
    for order, found in enumerate(series(tabulated(spline(ROWS[:count], ends)), x)):
        np.testing.assert_allclose(found, exact(x, order), rtol=1e-12, atol=1e-11)


def test_beyond_its_ends_a_table_is_a_straight_line():
    below, above = np.array([-2.0, -1.0, -0.5]), np.array([3.1, 4.0, 5.0])
    for table in (spline(ROWS, "natural"), spline(ROWS, "clamped"), polygon(ROWS)):
        for x in (below, above):
            value, rate, bend = series(tabulated(table), x)
            np.testing.assert_allclose(np.diff(value), np.diff(x) * rate[0], atol=1e-12)
            np.testing.assert_allclose(rate, rate[0], atol=1e-12)
            np.testing.assert_array_equal(bend, 0.0)
    assert series(tabulated(polygon(ROWS)), np.array([0.5, 1.75, 2.9]))[0] == pytest.approx([0.5, 0.0, 1.4])


def test_two_tables_in_one_set():
    tables = [Program(tabulated(polygon([(0, i), (1, i + 1)]))) for i in (3.0, 7.0)]
    found = [run(flatten(tables), index, [time_series(np.array(0.25))])[0] for index in (0, 1)]
    assert found == [3.25, 7.25]


@pytest.mark.parametrize(
    ("text", "t", "said"),
    [
        ("sqrt(1 - t)", 2.0, "sqrt(-1) is not finite"),
        ("1 + 1/(t - 1)", 1.0, "divide(1, 0) is not finite"),
        ("log(t)", 0.0, "log(0) is not finite"),
        ("sqrt(t)", 0.0, "sqrt(0) has a derivative that is not finite"),
        ("exp(1000*t)", 1.0, "exp(1000) is not finite"),
        ("(-t)**t", 0.5, "power_of(-0.5, 0.5) is not finite"),
    ],
)
def test_what_fails_is_named(text, t, said):
    assert failure(flatten([Program(expression(text))]), 0, [time_series(np.array(t))]) == said


def test_laws_of_a_coordinate_and_its_rate():
    variables = {"t": 0, "l": 1, "l_dot": 2}
    code, _ = compiled(parse("-3*(l - 2) - 0.5*l_dot + t"), {}, variables)
    given = [time_series(np.array(10.0)), constant_series(np.array(5.0)), constant_series(np.array(2.0))]
    assert run(flatten([Program(code)]), 0, given)[0] == -9.0 - 1.0 + 10.0


def test_units_count_and_are_checked():
    assert float(series(expression("(90*t) deg"), np.array(1.0))[0]) == math.pi / 2
    with pytest.raises(ExpressionError, match="stands after what has a unit already"):
        expression("(3 m * 2) s + t")
    with pytest.raises(ExpressionError, match="a length and a time cannot be added"):
        expression("t*(3 m + 2 s)")
    with pytest.raises(ExpressionError, match="'a' is a parameter, and a variable here"):
        compiled(parse("2*a"), {"a": Value(1.0)}, {"a": TIME})
    assert apply(Op.MIN, variable(TIME)) == variable(TIME)
