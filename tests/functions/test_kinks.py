"""Kinks of functions of time: where they are, and what jumps there."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbproj.base.thresholds import THRESHOLDS
from mbproj.functions.kinks import kinks
from mbproj.functions.program import TIME, Code, Op, Program, apply, number, variable
from mbproj.functions.program_set import flatten
from mbproj.functions.standard import harmonic, smooth_step, tabulated
from mbproj.functions.table import polygon, spline
from mbproj.scene.expressions.compiled import compiled
from mbproj.scene.expressions.syntax_tree import parse


def of(text, end=2.0, start=0.0):
    code = compiled(parse(text), {}, {"t": TIME})[0] if isinstance(text, str) else text
    return kinks(flatten([Program(code)]), 0, start, end)


@pytest.mark.parametrize(
    ("text", "t", "jump"),
    [
        ("floor(2*t)", 0.5, (1.0, 0.0, 0.0)),
        ("abs(t-0.5)", 0.5, (0.0, 2.0, 0.0)),
        ("max(0, t-0.3)", 0.3, (0.0, 1.0, 0.0)),
        ("min(t, 0.7)", 0.7, (0.0, -1.0, 0.0)),
        ("sign(t-1)", 1.0, (2.0, 0.0, 0.0)),
        ("ceil(t-0.25)", 0.25, (1.0, 0.0, 0.0)),
        ("max(0, t-0.5)**2", 0.5, (0.0, 0.0, 2.0)),
        ("max(0, t-0.5)**3", 0.5, (0.0, 0.0, 0.0)),
        ("sqrt((t-1)**2)", 1.0, (0.0, 2.0, 0.0)),
        ("sqrt((t-0.61803)**2)", 0.61803, (0.0, 2.0, 0.0)),
        ("atan2(sin(3*t), cos(3*t))", math.pi / 3.0, (-2.0 * math.pi, 0.0, 0.0)),
        ("5 + 1e-3*abs(t-0.5)", 0.5, (0.0, 2e-3, 0.0)),
    ],
)
def test_the_first_kink_and_its_jump(text, t, jump):
    first = of(text)[0]
    assert first.t == pytest.approx(t, abs=1e-14)
    assert first.jump == pytest.approx(jump, abs=1e-9)


SMOOTH = ("t", "sin(3*t)**3 + t**2", "tanh(1e6*(t-0.7))", "exp(-((t-1)/1e-4)**2)", "hypot(t-1, 1e-3)")


@pytest.mark.parametrize("text", SMOOTH)
def test_what_is_smooth_has_none_however_steep(text):
    assert of(text) == ()


def test_a_kink_at_the_start_counts_where_the_value_there_is_not_that_right_after_it():
    assert of("abs(t)") == ((0.0, (0.0, 1.0, 0.0)),)
    assert of("sign(t)") == ((0.0, (1.0, 0.0, 0.0)),)
    assert of("max(0, t-1)", start=1.5) == ()
    assert of("max(0, t-1)", end=1.0) == ()


def test_a_kink_at_the_end_counts_where_the_value_there_is_not_that_right_before_it():
    assert of("floor(t)", end=1.0) == ((1.0, (1.0, 0.0, 0.0)),)
    assert of("abs(t-1)", end=1.0) == ((1.0, (0.0, 1.0, 0.0)),)
    assert of("floor(t)", end=0.999) == ()


def test_ends_of_a_smooth_step_are_kinks_without_a_jump():
    assert [kink.t for kink in of(smooth_step(0.0, 0.5, 3.0, 0.2), 10.0)] == pytest.approx([3.0, 3.2], abs=1e-13)
    assert all(kink.jump == (0.0, 0.0, 0.0) for kink in of(smooth_step(0.0, 0.5, 3.0, 0.2), 10.0))


def test_rows_of_tables_count_where_something_jumps():
    rows = [(0.0, 0.0), (0.5, 1.0), (1.0, 0.0), (1.5, 2.0)]
    assert of(tabulated(spline(rows, "natural"))) == ()
    slopes = [kink.jump[1] for kink in of(tabulated(polygon(rows)))]
    assert slopes == pytest.approx([-4.0, 6.0], abs=1e-9)
    clamped = of(tabulated(spline(rows, "clamped")))
    assert [kink.t for kink in clamped if any(kink.jump)] == pytest.approx([1.5], abs=1e-13)
    assert not any(kink.jump[1] for kink in clamped)


def test_many_kinks_are_counted_up_to_a_bound():
    assert len(of("floor(100*t)", 5.0)) == 500
    assert len(of("floor(1000*t)", 5.0)) == THRESHOLDS.most_kinks + 1


@given(st.floats(0.01, 1.99), st.floats(-3.0, 3.0).filter(lambda size: abs(size) > 1e-3), st.floats(0.1, 20.0))
@settings(max_examples=60, deadline=None, derandomize=True)
def test_a_corner_is_found_wherever_it_is(at, size, frequency):
    """size |t - at| on a wave: one kink, and its jump is 2 size."""
    corner: Code = apply(Op.ABS, apply(Op.SUBTRACT, variable(TIME), number(at)))
    found = of(apply(Op.ADD, apply(Op.MULTIPLY, number(size), corner), harmonic(1.0, frequency)))
    assert len(found) == 1
    assert found[0].t == pytest.approx(at, abs=1e-12)
    assert found[0].jump[1] == pytest.approx(2.0 * size, rel=1e-6)
