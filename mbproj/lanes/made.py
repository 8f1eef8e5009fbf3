"""New arrays from others, some of which may be Lanes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj.lanes.array import Lanes, LanesMet


def one_of(values: Iterable[Any]) -> Any:
    """The first of these values that is Lanes, as an example for a new array; None where none is."""
    return next((each for each in values if isinstance(each, Lanes)), None)


def like_others(values: Any, *others: Any) -> Any:
    """An array to write into, for as many cases as the others have."""
    like = one_of(others)
    if isinstance(values, Lanes) or not isinstance(like, Lanes):
        return values
    return Lanes(np.repeat(values[None], len(like.values), axis=0))


def filled_like(values: Any, number: Any) -> Any:
    """np.full_like."""
    if not isinstance(number, Lanes):
        return np.full_like(values, number)
    filled = np.empty((len(number.values), *np.shape(values)))
    filled[...] = number.values.reshape(-1, *(1,) * np.ndim(values))
    return Lanes(filled)


def contiguous(values: Any, dtype: Any = None) -> Any:
    """np.ascontiguousarray."""
    if isinstance(values, Lanes):
        return Lanes(np.ascontiguousarray(values.values, dtype=dtype))
    return np.ascontiguousarray(values, dtype=dtype)


def first_axis_innermost(values: Any) -> Any:
    """np.asfortranarray."""
    if not isinstance(values, Lanes):
        return np.asfortranarray(values)
    order = range(values.ndim, 0, -1)
    return Lanes(np.ascontiguousarray(values.values.transpose(0, *order)).transpose(0, *order))


def numbers(nested: Any) -> Any:
    """np.array(nested, dtype=float) of nested lists, some of whose numbers may be Lanes."""
    try:
        return np.array(nested, dtype=float)
    except LanesMet:
        return Lanes(_stacked(nested))


def _stacked(nested: Any) -> npt.NDArray[Any]:
    """The values (B, ...) of nested lists, or (1, ...) where they are the same for all cases."""
    if isinstance(nested, Lanes):
        return nested.values
    if not isinstance(nested, (list, tuple)):
        return np.array(nested, dtype=float)[None]
    parts = [_stacked(each) for each in nested]
    most = max((len(each) for each in parts), default=1)
    return np.stack([np.broadcast_to(each, (most, *each.shape[1:])) for each in parts], axis=1)
