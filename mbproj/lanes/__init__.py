"""Arrays of many cases at once: code that is written for the numbers of one mechanism runs for a block of cases.

The functions here make arrays from others, some of which may be `Lanes`. The Lanes and what computes with them are
imported when somebody first asks for them: a run of one case has none.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from functools import wraps
from importlib import import_module
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import numpy.typing as npt

from mbproj.several import are_several, is_several

if TYPE_CHECKING:
    from mbproj.lanes.array import Lanes, LanesMet, Parted
    from mbproj.lanes.each import Each, OfLanes, each_call, lane, restacked

__all__ = [
    "Each",
    "Lanes",
    "LanesMet",
    "OfLanes",
    "Parted",
    "contiguous",
    "each_call",
    "each_lane",
    "filled_like",
    "first_axis_innermost",
    "lane",
    "like_others",
    "numbers",
    "one_of",
    "restacked",
]
Function = TypeVar("Function", bound=Callable[..., Any])
#: The modules of the names that are not defined here.
_HOME_OF = {
    **dict.fromkeys(("Lanes", "LanesMet", "Parted"), "mbproj.lanes.array"),
    **dict.fromkeys(("Each", "OfLanes", "each_call", "lane", "restacked"), "mbproj.lanes.each"),
}


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'mbproj.lanes' has no attribute '{name}'")
    from mbproj.lanes.array import HOW
    from mbproj.lanes.each import each_call
    from mbproj.lanes.functions import called
    from mbproj.lanes.ufuncs import applied

    HOW.update(ufunc=applied, function=called, each=each_call)
    return getattr(import_module(_HOME_OF[name]), name)


def _lanes() -> type[Lanes]:
    kind: type[Lanes] = __getattr__("Lanes")
    return kind


def each_lane(function: Function) -> Function:
    """A function of one case that is called once for each case where an argument holds several cases."""

    @wraps(function)
    def called(*args: Any, **options: Any) -> Any:
        if "mbproj.lanes.array" not in sys.modules:  # nothing holds several cases before their class is imported
            return function(*args, **options)
        return __getattr__("each_call")(function, args, options)

    return called  # type: ignore[return-value]


def one_of(values: Iterable[Any]) -> Any:
    """The first of these values that is Lanes, as an example for a new array; None where none is."""
    return next((each for each in values if is_several(each)), None)


def like_others(values: Any, *others: Any) -> Any:
    """An array to write into, for as many cases as the others have."""
    like = one_of(others)
    if is_several(values) or not is_several(like):
        return values
    return _lanes()(np.repeat(values[None], len(like.values), axis=0))


def filled_like(values: Any, number: Any) -> Any:
    """np.full_like."""
    if not is_several(number):
        return np.full_like(values, number)
    filled = np.empty((len(number.values), *np.shape(values)))
    filled[...] = number.values.reshape(-1, *(1,) * np.ndim(values))
    return _lanes()(filled)


def contiguous(values: Any, dtype: Any = None) -> Any:
    """np.ascontiguousarray."""
    if is_several(values):
        return _lanes()(np.ascontiguousarray(values.values, dtype=dtype))
    return np.ascontiguousarray(values, dtype=dtype)


def first_axis_innermost(values: Any) -> Any:
    """np.asfortranarray."""
    if not is_several(values):
        return np.asfortranarray(values)
    order = range(values.ndim, 0, -1)
    return _lanes()(np.ascontiguousarray(values.values.transpose(0, *order)).transpose(0, *order))


def numbers(nested: Any) -> Any:
    """np.array(nested, dtype=float) of nested lists, some of whose numbers may be Lanes."""
    try:
        return np.array(nested, dtype=float)
    except TypeError:
        if not are_several(nested):
            raise
        return _lanes()(_stacked(nested))


def _stacked(nested: Any) -> npt.NDArray[Any]:
    """The values (B, ...) of nested lists, or (1, ...) where they are the same for all cases."""
    if is_several(nested):
        return nested.values
    if not isinstance(nested, (list, tuple)):
        return np.array(nested, dtype=float)[None]
    parts = [_stacked(each) for each in nested]
    most = max((len(each) for each in parts), default=1)
    return np.stack([np.broadcast_to(each, (most, *each.shape[1:])) for each in parts], axis=1)
