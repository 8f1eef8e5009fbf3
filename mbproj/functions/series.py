"""Evaluation of a program with exact first and second derivatives: Taylor arithmetic, truncated after the second order.

Every value on the stack is a `Series` (x, x', x''), derivatives with respect to the time, arrays of one shape. The
rules are the product, quotient and chain rules (Griewank & Walther 2008, ch. 13); nothing is differenced.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import final, overload

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers, numbers
from mbproj.functions.program import ARGUMENTS, Op
from mbproj.functions.program_set import FREE, ProgramSet, lifted, pieces

# --- The rules of Taylor arithmetic, truncated after the second order -------------------------------------------------
# Sums, products, quotients, and the chain rule.


#: A value with its first and second derivative, arrays of one shape; or g, dg/dx and d²g/dx² at x.
Series = tuple[Numbers, Numbers, Numbers]

#: The natural logarithm of 10.
LN10 = float(np.log(10.0))


def chain(g: Series, x: Series) -> Series:
    """Return g(x(t)) from g, dg/dx, d²g/dx² at x."""
    return g[0], g[1] * x[1], g[2] * x[1] * x[1] + g[1] * x[2]


def _add(a: Series, b: Series) -> Series:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _subtract(a: Series, b: Series) -> Series:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _multiply(a: Series, b: Series) -> Series:
    return a[0] * b[0], a[1] * b[0] + a[0] * b[1], a[2] * b[0] + 2.0 * a[1] * b[1] + a[0] * b[2]


def _divide(a: Series, b: Series) -> Series:
    q = a[0] / b[0]
    q1 = (a[1] - q * b[1]) / b[0]
    return q, q1, (a[2] - 2.0 * q1 * b[1] - q * b[2]) / b[0]


def _power_of(a: Series, b: Series) -> Series:
    """Return exp(b log a)."""
    grown = chain(_exp(b[0] * np.log(a[0])), _multiply(b, chain(_log(a[0]), a)))
    return a[0] ** b[0], grown[1], grown[2]


def direction(y: Numbers, x: Numbers) -> Numbers:
    """Return atan2, also of complex numbers, to first order in their imaginary parts; NumPy's takes real ones only."""
    real = np.arctan2(y.real, x.real)
    if not (np.iscomplexobj(x) or np.iscomplexobj(y)):
        return real
    return real + 1j * (x.real * y.imag - y.real * x.imag) / (x.real**2 + y.real**2)


def _atan2(y: Series, x: Series) -> Series:
    r2 = x[0] * x[0] + y[0] * y[0]
    rate = (x[0] * y[1] - y[0] * x[1]) / r2
    bend = (x[0] * y[2] - y[0] * x[2]) / r2
    return direction(y[0], x[0]), rate, bend - 2.0 * rate * (x[0] * x[1] + y[0] * y[1]) / r2


def hypotenuse(a: Numbers, b: Numbers) -> Numbers:
    """Return √(a² + b²), also of complex numbers; NumPy's takes real ones only."""
    return np.sqrt(a * a + b * b) if np.iscomplexobj(a) or np.iscomplexobj(b) else np.hypot(a, b)


def _hypot(a: Series, b: Series) -> Series:
    h = hypotenuse(a[0], b[0])
    h1 = (a[0] * a[1] + b[0] * b[1]) / h
    return h, h1, (a[1] * a[1] + a[0] * a[2] + b[1] * b[1] + b[0] * b[2] - h1 * h1) / h


def _choose(first: Numbers, a: Series, b: Series) -> Series:
    return np.where(first, a[0], b[0]), np.where(first, a[1], b[1]), np.where(first, a[2], b[2])


OPERATIONS: Mapping[Op, Callable[[Series, Series], Series]] = MappingProxyType(
    {
        Op.ADD: _add,
        Op.SUBTRACT: _subtract,
        Op.MULTIPLY: _multiply,
        Op.DIVIDE: _divide,
        Op.POWER_OF: _power_of,
        Op.ATAN2: _atan2,
        Op.HYPOT: _hypot,
        Op.MIN: lambda a, b: _choose(a[0] <= b[0], a, b),
        Op.MAX: lambda a, b: _choose(a[0] >= b[0], a, b),
    }
)


def _exp(x: Numbers) -> Series:
    value = np.exp(x)
    return value, value, value


def _log(x: Numbers) -> Series:
    return np.log(x), 1.0 / x, -1.0 / (x * x)


def _tan(x: Numbers) -> Series:
    value = np.tan(x)
    return value, 1.0 + value * value, 2.0 * value * (1.0 + value * value)


def _tanh(x: Numbers) -> Series:
    value = np.tanh(x)
    return value, 1.0 - value * value, -2.0 * value * (1.0 - value * value)


def _asin(x: Numbers) -> Series:
    rate = 1.0 / np.sqrt(1.0 - x * x)
    return np.arcsin(x), rate, x * rate**3


def _atan(x: Numbers) -> Series:
    rate = 1.0 / (1.0 + x * x)
    return np.arctan(x), rate, -2.0 * x * rate * rate


def _sqrt(x: Numbers) -> Series:
    root = np.sqrt(x)
    return root, 0.5 / root, -0.25 / root**3


def _scaled(factor: float, g: Series) -> Series:
    return factor * g[0], factor * g[1], factor * g[2]


def _flat(value: Numbers) -> Series:
    return value, np.zeros_like(value), np.zeros_like(value)


def _acos(x: Numbers) -> Series:
    _, rate, bend = _asin(x)
    return np.arccos(x), -rate, -bend


def smooth_step(x: Numbers) -> Series:
    """Return 0 up to x = 0, 1 from x = 1, and a polynomial of degree 5 between, which joins them twice smoothly."""
    x = np.clip(x, 0.0, 1.0)
    y = 1.0 - x
    return x**3 * (10.0 - 15.0 * x + 6.0 * x * x), 30.0 * (x * y) ** 2, 60.0 * x * y * (1.0 - 2.0 * x)


def power(x: Numbers, exponent: float) -> Series:
    """Return x ** exponent. A term with a factor of zero is left out even where its power of x is undefined."""
    second = exponent * (exponent - 1.0)
    rate = exponent * x ** (exponent - 1.0) if exponent else np.zeros_like(x)
    return x**exponent, rate, second * x ** (exponent - 2.0) if second else np.zeros_like(x)


FUNCTIONS: Mapping[Op, Callable[[Numbers], Series]] = MappingProxyType(
    {
        Op.NEGATE: lambda x: (-x, -np.ones_like(x), np.zeros_like(x)),
        Op.SIN: lambda x: (np.sin(x), np.cos(x), -np.sin(x)),
        Op.COS: lambda x: (np.cos(x), -np.sin(x), -np.cos(x)),
        Op.TAN: _tan,
        Op.ASIN: _asin,
        Op.ACOS: _acos,
        Op.ATAN: _atan,
        Op.SINH: lambda x: (np.sinh(x), np.cosh(x), np.sinh(x)),
        Op.COSH: lambda x: (np.cosh(x), np.sinh(x), np.cosh(x)),
        Op.TANH: _tanh,
        Op.EXP: _exp,
        Op.LOG: _log,
        Op.LOG10: lambda x: _scaled(1.0 / LN10, _log(x)),
        Op.SQRT: _sqrt,
        Op.ABS: lambda x: (np.sign(x.real) * x, np.sign(x.real), np.zeros_like(x)),  # also for complex steps
        Op.SIGN: lambda x: _flat(np.sign(x.real)),
        Op.FLOOR: lambda x: _flat(np.floor(x.real)),
        Op.CEIL: lambda x: _flat(np.ceil(x.real)),
        Op.SMOOTH_STEP: smooth_step,
    }
)


# --- Evaluation of a program with exact first and second derivatives --------------------------------------------------


#: The operations with an operand. To look up a member of an enumeration takes as long as a sum.
CONSTANT, VARIABLE, TABLE, POWER = Op.CONSTANT, Op.VARIABLE, Op.TABLE, Op.POWER


def time_series(t: Numbers) -> Series:
    """Return the series of the time: (t, 1, 0)."""
    t = np.asarray(t, dtype=float)
    return t, np.ones_like(t), np.zeros_like(t)


def constant_series(x: Numbers) -> Series:
    """Return the series of a value taken as constant, with derivatives of 0."""
    x = numbers(x)
    zero = np.zeros(x.shape)
    return x, zero, zero


@final
class Variables(Sequence[Series]):
    """Variables of a program at these `values`: constants, but for those with a series in `varying`. Each is made on
    first use, as a program names few of many."""

    def __init__(self, values: Sequence[Numbers], varying: Mapping[int, Series]) -> None:
        self._values, self._varying = values, varying

    def __len__(self) -> int:
        return len(self._values)

    @overload
    def __getitem__(self, index: int) -> Series: ...

    @overload
    def __getitem__(self, index: slice) -> list[Series]: ...

    def __getitem__(self, index: int | slice) -> Series | list[Series]:
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        return self._varying[index] if index in self._varying else constant_series(self._values[index])


def run(programs: ProgramSet, index: int, variables: Sequence[Series], held: Array | None = None) -> Series:
    """Return value, first and second derivative of program `index`. Undefined values are NaN or infinite.

    With `held`, switches are on these branches, one for each instruction of the set (see `switches`). This does not
    apply where a branch has no value beyond its end, as the root of a negative number."""
    with np.errstate(all="ignore"):
        stack: list[Series] = []
        for at in range(programs.start[index], programs.start[index + 1]):
            _step(programs, at, stack, variables, held)
    result = stack.pop()
    return result if held is None or np.all(np.isfinite(result[0])) else run(programs, index, variables)


def walk(
    programs: ProgramSet, index: int, variables: Sequence[Series], held: Array | None = None
) -> Iterator[tuple[int, list[Series]]]:
    """Yield the instructions of program `index` one by one, each with the stack before it."""
    stack: list[Series] = []
    for at in range(programs.start[index], programs.start[index + 1]):
        yield at, stack
        _step(programs, at, stack, variables, held)


def slope(programs: ProgramSet, index: int, at: Sequence[Numbers], variable: int) -> Numbers:
    """Return the partial derivative of program `index` by variable number `variable` at values of the variables.
    Undefined values are NaN or infinite."""
    return run(programs, index, Variables(at, {variable: time_series(at[variable])}))[1]


def slopes(programs: ProgramSet, index: int, at: Sequence[Numbers], variables: Integers) -> Array:
    """Return the partial derivatives by each of these variables, (k,), at one point."""
    none, rows = np.zeros(len(variables)), np.eye(len(variables))
    varying = {k: (np.full(len(row), at[k]), row, none) for k, row in zip(variables.tolist(), rows, strict=True)}
    return np.broadcast_to(run(programs, index, Variables(at, varying))[1], none.shape)


def failure(programs: ProgramSet, index: int, variables: Sequence[Series]) -> str:
    """Return the cause, in words, of a value that is not finite at one point: "sqrt(-0.25) is not finite"."""
    with np.errstate(all="ignore"):
        stack: list[Series] = []
        for at in range(programs.start[index], programs.start[index + 1]):
            op = programs.operations[at]
            arguments = ", ".join(f"{float(x[0]):.6g}" for x in stack[len(stack) - ARGUMENTS[op] :])
            _step(programs, at, stack, variables)
            if not np.all(np.isfinite(np.array(stack[-1]))):
                what = "is" if not np.isfinite(stack[-1][0]) else "has a derivative that is"
                return f"{op.name.lower()}({arguments}) {what} not finite"
    return "it is not finite"


def _step(
    programs: ProgramSet, at: int, stack: list[Series], variables: Sequence[Series], held: Array | None = None
) -> None:
    """Execute instruction number `at`, on the branch that is held."""
    op, operand = programs.operations[at], programs.operand[at].item()
    if held is not None and not np.isnan(held[at]):
        stack.append(_on_branch(programs, at, stack, float(held[at])))
    elif op is CONSTANT:
        stack.append(constant_series(np.where(True, operand, variables[0][0].real)))  # in the shape of the time
    elif op is VARIABLE:
        stack.append(variables[int(operand)])
    elif op is TABLE:
        x = stack.pop()
        stack.append(chain(table_series(programs, int(operand), x[0]), x))
    elif op is POWER:
        stack.append(chain(power(stack[-1][0], operand), stack.pop()))
    elif op in FUNCTIONS:
        stack.append(chain(FUNCTIONS[op](stack[-1][0]), stack.pop()))
    else:
        second, first = stack.pop(), stack.pop()
        stack.append(OPERATIONS[op](first, second))


def _on_branch(programs: ProgramSet, at: int, stack: list[Series], branch: float) -> Series:
    """Return the value of a switch on one of its branches; its arguments are taken from the stack."""
    op, x = programs.operations[at], stack.pop()
    if op in (Op.MIN, Op.MAX):
        first = stack.pop()
        return first if (branch > 0.0) == (op is Op.MAX) else x
    if op is Op.ABS:
        return branch * x[0], branch * x[1], branch * x[2]
    if op is Op.TABLE:
        return chain(table_series(programs, int(programs.operand[at]), x[0], branch), x)
    return constant_series(np.full_like(x[0], branch))


def table_series(programs: ProgramSet, number: int, x: Numbers, branch: float = FREE) -> Series:
    """Return the piece of table `number` that contains x, or the nearest piece of a branch, at x."""
    start, end = programs.table_start[number : number + 2]
    x = lifted(programs, number, x, branch)
    first, last = (start, end - 1) if np.isnan(branch) else pieces(programs, number, branch)
    at = np.clip(start - 1 + np.searchsorted(programs.knot[start:end], x, side="right"), first, last)
    c = programs.piece[at]
    u = x - programs.origin[at]
    c0, c1, c2, c3 = (c[..., i] for i in range(4))
    return c0 + u * (c1 + u * (c2 + u * c3)), c1 + u * (2.0 * c2 + 3.0 * u * c3), 2.0 * c2 + 6.0 * u * c3
