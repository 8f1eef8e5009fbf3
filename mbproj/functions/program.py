"""A function as data: a postfix program for a stack machine, so that NumPy and compiled code run the same thing.

Every function that a scene can give becomes one: a constant, an expression, a polynomial, a table. A program is a list
of instructions (operation, operand); each takes its arguments from the stack and leaves one value there. This module
imports nothing of mbproj, and no NumPy, because the reader of scenes makes programs too.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import TYPE_CHECKING

from mbproj.base.dataclass import dataclass

if TYPE_CHECKING:
    from mbproj.functions.table import CubicTable


class Op(IntEnum):
    """The operations. CONSTANT and VARIABLE push their operand's value; TABLE and POWER have an operand beside x."""

    CONSTANT = 0  # push `operand`
    VARIABLE = 1  # push variable number `operand`: 0 is the time, 1 a coordinate, 2 its rate, from 3 on channels
    TABLE = 2  # x -> the table's value at x
    POWER = 3  # x -> x ** operand
    NEGATE = 4
    ADD = 5
    SUBTRACT = 6
    MULTIPLY = 7
    DIVIDE = 8
    POWER_OF = 9  # x, y -> x ** y, x > 0
    ATAN2 = 10
    HYPOT = 11
    MIN = 12
    MAX = 13
    SIN = 14
    COS = 15
    TAN = 16
    ASIN = 17
    ACOS = 18
    ATAN = 19
    SINH = 20
    COSH = 21
    TANH = 22
    EXP = 23
    LOG = 24
    LOG10 = 25
    SQRT = 26
    ABS = 27
    SIGN = 28
    FLOOR = 29
    CEIL = 30
    SMOOTH_STEP = 31  # 0 up to x = 0, 1 from x = 1, and 10 x³ - 15 x⁴ + 6 x⁵ between: C² everywhere


#: The number of values that an operation takes from the stack.
ARGUMENTS = {op: 0 if op <= Op.VARIABLE else 2 if Op.ADD <= op <= Op.MAX else 1 for op in Op}
TIME, COORDINATE, RATE = 0, 1, 2
#: The number of the variable that is the first channel (`mbproj.model.channels`).
CHANNELS = 3


@dataclass(frozen=True)
class Instruction:
    """One step of a program; `table` with TABLE alone."""

    op: Op
    operand: float = 0.0
    table: CubicTable | None = None


Code = tuple[Instruction, ...]


@dataclass(frozen=True)
class Program:
    """A function: its code, and its text in the scene (for messages; empty where it cannot fail). In a program of a
    scene, variable CHANNELS + i is the channel named `reads[i]`; in one of a system, it is a channel of the system."""

    code: Code
    text: str = ""
    reads: tuple[str, ...] = ()


def number(value: float) -> Code:
    """Return the code of a constant."""
    return (Instruction(Op.CONSTANT, value),)


def replaced(code: Code, by: Mapping[int, Code]) -> Code:
    """Return the code with other codes in place of these variables."""
    return tuple(
        one for each in code for one in (by.get(int(each.operand), (each,)) if each.op is Op.VARIABLE else (each,))
    )


def variable(index: int) -> Code:
    """Return the code of a variable: TIME, COORDINATE, RATE, or CHANNELS plus the number of a channel."""
    return (Instruction(Op.VARIABLE, index),)


def apply(op: Op, *arguments: Code) -> Code:
    """Return the code of an operation on the values of other codes. MIN, MAX, HYPOT and other operations of two
    arguments are applied to any number of them, one after another."""
    first, *others = arguments
    if not others:
        return (*first, Instruction(op)) if ARGUMENTS[op] == 1 else first
    for other in others:
        first = (*first, *other, Instruction(op))
    return first
