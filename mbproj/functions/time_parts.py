"""The parts of programs that are functions of time alone: a whole program, or the factor of a coordinate in a law."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mbproj.functions.program import ARGUMENTS, TIME, Op
from mbproj.functions.program_set import ProgramSet


class _Value(NamedTuple):
    """A value on the stack: its first instruction, and whether it depends on the time (`timed`), and on anything else
    (`stated`)."""

    first: int
    timed: bool
    stated: bool


def time_parts(programs: ProgramSet, index: int) -> tuple[ProgramSet, ...]:
    """Return the largest parts of program `index` that depend on time alone, each as the one program of a set."""
    return tuple(
        replace(programs, start=np.array([first, last])) for first, last in _ranges(programs, index) if last - first > 1
    )


def _ranges(programs: ProgramSet, index: int) -> Iterator[tuple[int, int]]:
    """Yield the instructions of these parts, from the first to the one after the last."""
    stack: list[_Value] = []
    end = int(programs.start[index + 1])
    for at in range(int(programs.start[index]), end):
        op = Op(int(programs.op[at]))
        if op <= Op.VARIABLE:
            variable = op is Op.VARIABLE
            timed = variable and int(programs.operand[at]) == TIME
            stack.append(_Value(at, timed, variable and not timed))
            continue
        given = stack[len(stack) - ARGUMENTS[op] :]
        stated = any(value.stated for value in given)
        if stated:
            ends = [*(value.first for value in given[1:]), at]
            yield from ((value.first, last) for value, last in zip(given, ends, strict=True) if _is_of_time(value))
        stack[len(stack) - ARGUMENTS[op] :] = [_Value(given[0].first, any(value.timed for value in given), stated)]
    if _is_of_time(stack[0]):
        yield stack[0].first, end


def _is_of_time(value: _Value) -> bool:
    return value.timed and not value.stated
