"""Elementwise operations and matrix products of Lanes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import repeat
from typing import Any

import numpy as np

from mbproj.lanes.array import INTO_ONE, Lanes, LanesMet, laned
from mbproj.lanes.axes import raised
from mbproj.lanes.each import each_call, restacked

#: Operations whose result IEEE 754 defines to the last bit, or that only compare or select.
EXACT = frozenset(
    {
        np.add,
        np.subtract,
        np.multiply,
        np.divide,
        np.negative,
        np.positive,
        np.absolute,
        np.sqrt,
        np.sign,
        np.floor,
        np.ceil,
        np.rint,
        np.square,
        np.maximum,
        np.minimum,
        np.isfinite,
        np.isnan,
        np.equal,
        np.not_equal,
        np.less,
        np.less_equal,
        np.greater,
        np.greater_equal,
        np.logical_and,
        np.logical_or,
        np.logical_not,
    }
)


def applied(ufunc: np.ufunc, method: str, inputs: Sequence[Any], options: Mapping[str, Any]) -> Any:
    """The result of `Lanes.__array_ufunc__`."""
    if method == "at":
        return added_at(ufunc, *inputs)
    if "out" in options:
        (into,) = options["out"]
        if not isinstance(into, Lanes):
            raise LanesMet(INTO_ONE)
        into[...] = applied(ufunc, method, inputs, {name: each for name, each in options.items() if name != "out"})
        return into
    if method == "__call__" and not options:
        if ufunc in EXACT:
            return laned(ufunc(*aligned(inputs)))
        if ufunc is np.matmul:
            return product(*inputs)
        if ufunc is np.power and _is_square(*inputs):
            return inputs[0] * inputs[0]
        if all(isinstance(each, (Lanes, np.ndarray, float, int)) for each in inputs):
            own = [_each_of(values) for values in inputs]
            return restacked([ufunc(*numbers) for numbers in zip(*own)])  # noqa: B905 what is no Lanes has no end
    return each_call(getattr(ufunc, method), inputs, options)


def _each_of(values: Any) -> Iterable[Any]:
    """The part of each lane."""
    if not isinstance(values, Lanes):
        return repeat(values)
    return values.values if values.ndim else values.values.tolist()


def _is_square(base: Any, exponent: Any) -> bool:
    """Whether base**exponent is the square of an array. NumPy multiplies an array by itself; for the square of a number
    it calls the C library, whose result may differ."""
    return isinstance(base, Lanes) and base.ndim > 0 and type(exponent) in (int, float) and exponent == 2


def aligned(inputs: Sequence[Any]) -> list[Any]:
    """Operands that broadcast against each other, with the lanes along the first axis."""
    most = 1 + max(each.ndim if isinstance(each, Lanes) else np.ndim(each) for each in inputs)
    return [raised(each.values, most) if isinstance(each, Lanes) else each for each in inputs]


def product(first: Any, second: Any) -> Any:
    """A @ B. NumPy multiplies a stack matrix by matrix, so that each lane keeps its bits."""
    a, b = (each.values if isinstance(each, Lanes) else np.asarray(each) for each in (first, second))
    is_lanes = isinstance(first, Lanes), isinstance(second, Lanes)
    ndims = [each.ndim - lanes for each, lanes in zip((a, b), is_lanes, strict=True)]
    row, column = ndims[0] == 1, ndims[1] == 1
    a = a[..., None, :] if row else a
    b = b[..., None] if column else b
    most = max(ndims[0] + row, ndims[1] + column) + 1
    a, b = (raised(each, most) if lanes else each for each, lanes in zip((a, b), is_lanes, strict=True))
    result = a @ b
    result = result[..., 0, :] if row and not column else result
    result = result[..., 0] if column and not row else result
    return Lanes(result[..., 0, 0] if row and column else result)


def added_at(ufunc: np.ufunc, into: Any, index: Any, *values: Any) -> None:
    """ufunc.at, which writes into its first operand."""
    if not isinstance(into, Lanes):
        raise LanesMet(INTO_ONE)
    if isinstance(index, np.ndarray) and index.ndim == 1 and all(isinstance(value, Lanes) for value in values):
        of_all: Any = (slice(None), index)
        ufunc.at(into.values, of_all, *(value.values for value in values))
        return
    for at, each in enumerate(into.values):
        ufunc.at(each, index, *(value.values[at] if isinstance(value, Lanes) else value for value in values))
