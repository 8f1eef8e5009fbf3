"""A function as data: a postfix program for a stack machine, so that NumPy and compiled code run the same thing.

Every function that a scene can give becomes one: a constant, an expression, a polynomial, a table. A program is a list
of instructions (operation, operand); each takes its arguments from the stack and leaves one value there. Imports
nothing of ours, and no NumPy: the reader of scenes makes programs too.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum

from mbproj.dataclass import dataclass
from mbproj.functions.table import CubicTable


class Op(IntEnum):
    """The operations. CONSTANT, VARIABLE push their operand's value; TABLE and POWER have an operand beside x."""

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


#: How many values an operation takes from the stack.
ARGUMENTS = {op: 0 if op <= Op.VARIABLE else 2 if Op.ADD <= op <= Op.MAX else 1 for op in Op}
TIME, COORDINATE, RATE = 0, 1, 2
#: The variable that is the first of the channels (`mbproj.model.channels`).
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
    """A function: its code, and how the scene writes it (for messages; empty where it cannot fail). Of a scene,
    variable CHANNELS + i stands for what is called `reads[i]` there; of a system, for a channel of that."""

    code: Code
    text: str = ""
    reads: tuple[str, ...] = ()


def number(value: float) -> Code:
    """A constant."""
    return (Instruction(Op.CONSTANT, value),)


def replaced(code: Code, by: Mapping[int, Code]) -> Code:
    """The code with other codes in place of these variables."""
    return tuple(
        one for each in code for one in (by.get(int(each.operand), (each,)) if each.op is Op.VARIABLE else (each,))
    )


def variable(index: int) -> Code:
    """TIME, COORDINATE, RATE, or CHANNELS and the number of a channel."""
    return (Instruction(Op.VARIABLE, index),)


def apply(op: Op, *arguments: Code) -> Code:
    """An operation on the values of other codes; of MIN, MAX, HYPOT on any number of them, one after another."""
    first, *others = arguments
    if not others:
        return (*first, Instruction(op)) if ARGUMENTS[op] == 1 else first
    for other in others:
        first = (*first, *other, Instruction(op))
    return first
