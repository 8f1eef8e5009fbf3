"""The array types that signatures name; shapes stand in the docstrings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from mbproj.base.cases import Cases, cases_in

Array: TypeAlias = npt.NDArray[np.float64]
Integers: TypeAlias = npt.NDArray[np.intp]
Flags: TypeAlias = npt.NDArray[np.bool_]
#: Real in a run; complex where a test differentiates by the complex step.
Numbers: TypeAlias = npt.NDArray[Any]


def numbers(nested: Any) -> Any:
    """np.array(nested, dtype=float) of nested lists, in which numbers of several cases may stand."""
    try:
        return np.array(nested, dtype=float)
    except TypeError:
        cases: Any = cases_in(nested)
        if cases is None:
            raise
        return np.array(nested, dtype=float, like=cases)


def like_of(*values: Any) -> Any:
    """The first of these values that is of several cases, as NumPy's `like` of a new array; None where none is."""
    return next((each for each in values if isinstance(each, Cases)), None)


def contiguous(values: Any, dtype: Any = None) -> Any:
    """np.ascontiguousarray, also of numbers of several cases."""
    return np.ascontiguousarray(values, dtype=dtype, like=like_of(values))


def cross(a: Numbers, b: Numbers) -> Numbers:
    """a × b over the last axis, (..., 3); several times faster than numpy.cross on small arrays."""
    (a0, a1, a2), (b0, b1, b2) = ((each[..., 0], each[..., 1], each[..., 2]) for each in (a, b))
    first = a1 * b2 - a2 * b1
    product = np.empty((*first.shape, 3), dtype=first.dtype, order="F", like=like_of(a, b))
    product[..., 0], product[..., 1], product[..., 2] = first, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0
    return product


def dot(a: Numbers, b: Numbers) -> Numbers:
    """a·b over the last axis, (..., 3), entry by entry: quick, and the same for a sample in blocks of any length."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]


def total(x: Numbers) -> Numbers:
    """The sum over the last axis, added in one order for every memory layout: a state has the same energy alone and in
    a block of states."""
    sums: Numbers = contiguous(x).sum(axis=-1)
    return sums


def together(parts: Sequence[Numbers]) -> Numbers:
    """Concatenate one or more arrays along their first axis. A single one is returned itself, not copied."""
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def distinct_rows(rows: Numbers) -> tuple[Numbers, Integers]:
    """The distinct rows of `rows` (k, w), in the order in which they first stand, and the index among them of each of
    the k rows."""
    number: dict[tuple[float, ...], int] = {}
    place = np.array([number.setdefault(tuple(row), len(number)) for row in rows.tolist()], dtype=np.intp)
    return rows[np.diff(np.maximum.accumulate(place), prepend=-1) > 0], place


def may_overflow() -> np.errstate:
    """A context in which NumPy does not warn of overflow. Numbers overflow in a step that is far too large, and in
    results computed from a diverged state. The caller tests whether its result is finite, or records it."""
    return np.errstate(over="ignore", invalid="ignore")
