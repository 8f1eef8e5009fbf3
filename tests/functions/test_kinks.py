"""Kinks of functions of time and switches of laws: where they are, what jumps there, and how branches go on beyond."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbproj.base.thresholds import THRESHOLDS
from mbproj.functions.kinks import kinks
from mbproj.functions.program import COORDINATE, TIME, Code, Instruction, Op, Program, apply, number, variable
from mbproj.functions.program_set import FREE, ProgramSet, flatten, natural, switches
from mbproj.functions.series import constant_series, run, time_series
from mbproj.functions.standard import harmonic, polynomial, smooth_step, tabulated
from mbproj.functions.table import polygon, spline
from mbproj.functions.values import values
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


# Switches of laws: which instructions they are, where their branches hold, and how these go on beyond.

S = variable(COORDINATE)
ROWS = [(-1.0, 0.3), (0.0, 1.0), (0.5, -0.2), (1.2, -0.2), (2.0, -0.2)]
LAWS = {
    "abs": apply(Op.ABS, S),
    "sign": apply(Op.SIGN, S),
    "max": apply(Op.MAX, number(0.25), S),
    "min": apply(Op.MIN, S, apply(Op.MULTIPLY, S, S)),
    "floor": apply(Op.FLOOR, S),
    "ceil": apply(Op.CEIL, S),
    "table": (*S, Instruction(Op.TABLE, table=polygon(ROWS))),
}


def at(programs: ProgramSet, s: float):
    return [time_series(0.0), constant_series(s), constant_series(0.0)]


def only_switch(code) -> tuple[ProgramSet, int]:
    programs = flatten([Program(code)])
    (found,) = switches(programs, 0)
    return programs, found


def argument(name: str, s: float) -> float:
    return {"max": 0.25 - s, "min": s - s * s}.get(name, s)


def held(programs: ProgramSet, at: int, branch: float) -> np.ndarray:
    branches = np.full(len(programs.op), FREE)
    branches[at] = branch
    return branches


@settings(derandomize=True, deadline=None)
@given(name=st.sampled_from(sorted(LAWS)), s=st.floats(-3.0, 3.0))
def test_a_branch_is_the_function_where_it_holds(name, s):
    programs, switch = only_switch(LAWS[name])
    branch = natural(programs, switch, argument(name, s))
    assert run(programs, 0, at(programs, s), held(programs, switch, branch))[0] == run(programs, 0, at(programs, s))[0]


@pytest.mark.parametrize(
    ("name", "inside", "outside", "value"),
    [
        ("abs", 1.0, -0.4, -0.4),
        ("sign", 1.0, -0.4, 1.0),
        ("max", 1.0, 0.1, 0.1),
        ("min", 2.0, 0.5, 0.5),
        ("floor", 1.5, 2.3, 1.0),
        ("ceil", 1.5, 2.3, 2.0),
        ("table", 0.25, 0.75, -0.8),
    ],
)
def test_a_branch_goes_on_smoothly_beyond_its_end(name, inside, outside, value):
    programs, switch = only_switch(LAWS[name])
    branch = natural(programs, switch, argument(name, inside))
    found = run(programs, 0, at(programs, outside), held(programs, switch, branch))[0]
    assert found == pytest.approx(value)
    assert values(programs, [0], [0.0, outside, 0.0], held(programs, switch, branch)) == [found]


def test_a_branch_without_a_value_beyond_gives_way():
    """sqrt(max(0, s)): the branch s has no root below 0, and the function is 0 there."""
    programs, switch = only_switch(apply(Op.SQRT, apply(Op.MAX, number(0.0), S)))
    assert run(programs, 0, at(programs, -0.3), held(programs, switch, -1.0))[0] == 0.0
    assert values(programs, [0, 0], [0.0, -0.3, 0.0], held(programs, switch, -1.0)) == [0.0, 0.0]


def test_what_depends_on_time_alone_or_has_no_kink_is_no_switch():
    smooth = (*S, Instruction(Op.TABLE, table=spline([(x, x**2) for x in np.linspace(0, 1, 9)], "natural")))
    collinear = (*S, Instruction(Op.TABLE, table=polygon([(0.0, 1.0), (1.0, 3.0), (2.0, 5.0)])))
    for code in (apply(Op.ABS, variable(0)), polynomial([1.0, 2.0]), smooth, collinear):
        assert list(switches(flatten([Program(code)]), 0)) == []
    clamped = (*S, Instruction(Op.TABLE, table=spline([(x, x**2) for x in np.linspace(0, 1, 9)], "clamped")))
    programs, switch = only_switch(clamped)
    assert [natural(programs, switch, x) for x in (0.1, 0.9, 1.1, 5.0)] == [1.0, 1.0, 9.0, 9.0]


def test_rows_of_a_table_without_a_kink_part_no_branches():
    programs, switch = only_switch(LAWS["table"])
    assert len({natural(programs, switch, x) for x in (0.6, 1.1, 1.3, 5.0)}) == 1
    assert natural(programs, switch, 0.4) != natural(programs, switch, 0.6)
