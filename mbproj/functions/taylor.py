"""The rules of Taylor arithmetic, truncated after the second order: sums, products, quotients, and the chain rule."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from mbproj.arrays import Numbers
from mbproj.functions.program import Op

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
