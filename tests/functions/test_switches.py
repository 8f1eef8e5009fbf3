"""Switches of laws: which instructions they are, where their branches hold, and how these go on beyond."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mbproj.functions.program import COORDINATE, Instruction, Op, Program, apply, number, variable
from mbproj.functions.program_set import FREE, ProgramSet, flatten, natural, switches
from mbproj.functions.series import constant_series, run, time_series
from mbproj.functions.standard import polynomial
from mbproj.functions.table import polygon, spline
from mbproj.functions.values import values

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
