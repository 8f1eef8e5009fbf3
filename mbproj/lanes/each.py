"""Objects for each case of a block, and functions that are called once for each case."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from mbproj.lanes.array import Lanes, LanesMet, Parted, agreed

Kind = TypeVar("Kind")
NOTHING: Mapping[str, Any] = MappingProxyType({})
#: Function that returns the part of one lane of a value.
Taken = Callable[[int], Any]


class Each:
    """One object for each of B cases: `items`. An attribute is read from each object, a method is called on each."""

    __slots__ = ("items",)
    items: list[Any]

    def __init__(self, items: Sequence[Any]) -> None:
        object.__setattr__(self, "items", list(items))

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        attributes = [getattr(each, name) for each in self.items]
        return Each(attributes) if callable(attributes[0]) else restacked(attributes)

    def __setattr__(self, name: str, value: Any) -> None:
        taken = _lane_getter(value)
        for at, each in enumerate(self.items):
            setattr(each, name, value if taken is None else taken(at))

    def __call__(self, *args: Any, **options: Any) -> Any:
        return each_call(None, (self, *args), options)


class OfLanes:
    """A module or class whose functions are called once for each case where an argument holds several cases."""

    __slots__ = ("_of",)

    def __init__(self, of: Any) -> None:
        self._of = of

    def __getattr__(self, name: str) -> Any:
        attribute = getattr(self._of, name)
        return OfLanes(attribute) if callable(attribute) else attribute

    def __call__(self, *args: Any, **options: Any) -> Any:
        return each_call(self._of, args, options)

    @staticmethod
    def of_all(of: Any) -> Any:
        """An object whose methods take numbers of several cases. The object itself may be the same for all cases."""
        return of if isinstance(of, Each) else OfLanes(of)


def lane(values: Kind, at: int) -> Kind:
    """The values of one case."""
    taken = _lane_getter(values)
    return values if taken is None else taken(at)


def each_call(function: Any, args: Sequence[Any], options: Mapping[str, Any] = NOTHING) -> Any:
    """function(*args, **options), called once for each case where an argument holds several. Where the function is
    None, the first argument is called."""
    taken = [_lane_getter(each) for each in args]
    named = {name: _lane_getter(each) for name, each in options.items()}
    if all(each is None for each in (*taken, *named.values())):
        return function(*args, **options)
    differ = [(name, take) for name, take in named.items() if take is not None]
    results = []
    for at in range(_width([*args, *options.values()])):
        own = [each if take is None else take(at) for each, take in zip(args, taken, strict=True)]
        more = {**options, **{name: take(at) for name, take in differ}} if differ else options
        results.append(own[0](*own[1:], **more) if function is None else function(*own, **more))
    return restacked(results)


def _lane_getter(values: Any) -> Taken | None:
    """A function that returns the part of one lane; None where the value is the same for all cases."""
    if isinstance(values, Lanes):
        own = values.values
        return own.__getitem__ if values.ndim else own.tolist().__getitem__
    if isinstance(values, Each):
        return values.items.__getitem__
    if isinstance(values, (list, tuple)):
        parts = [_lane_getter(each) for each in values]
        if all(part is None for part in parts):
            return None
        pairs = list(zip(values, parts, strict=True))
        make = type(values)._make if hasattr(values, "_make") else type(values)
        return lambda at: make([each if take is None else take(at) for each, take in pairs])
    if isinstance(values, dict):
        inside = {key: _lane_getter(each) for key, each in values.items()}
        if all(part is None for part in inside.values()):
            return None
        return lambda at: {key: values[key] if take is None else take(at) for key, take in inside.items()}
    return None


def _width(values: Sequence[Any]) -> int:
    """The number B of cases."""
    waiting = list(values)
    while waiting:
        each = waiting.pop()
        if isinstance(each, Lanes):
            return len(each.values)
        if isinstance(each, Each):
            return len(each.items)
        if isinstance(each, (list, tuple)):
            waiting += each
        elif isinstance(each, dict):
            waiting += each.values()
    raise LanesMet("nothing is of several cases")


def restacked(values: Sequence[Any]) -> Any:
    """The values of all cases as one value: floats become Lanes. Integers and texts must be the same for all cases,
    else Parted is raised."""
    first = values[0]
    if all(each is first for each in values):
        return first
    if isinstance(first, (float, np.floating)):
        return Lanes(np.array(values, dtype=float))
    if isinstance(first, np.ndarray):
        return _arrays(values, first)
    if isinstance(first, (int, bool, str, bytes, np.integer, np.bool_)):
        return agreed_of(values)
    if isinstance(first, (list, tuple)):
        agreed_of([len(each) for each in values])
        parts = [restacked(each) for each in zip(*values, strict=True)]
        return type(first)._make(parts) if hasattr(first, "_make") else type(first)(parts)
    if isinstance(first, dict):
        agreed_of([tuple(each) for each in values])
        return {key: restacked([each[key] for each in values]) for key in first}
    agreed_of([each is None for each in values])
    return Each(values)


def agreed_of(parts: Sequence[Any]) -> Any:
    """The value that all cases share. Raises Parted where they differ."""
    first = parts[0]
    if any(each != first for each in parts):
        raise Parted(parts)
    return first


def _arrays(parts: Sequence[Any], first: Any) -> Any:
    agreed_of([each.shape for each in parts])
    if first.dtype.kind != "f":
        return agreed(np.stack(parts))
    if first.flags.f_contiguous and not first.flags.c_contiguous:
        return Lanes(np.stack([each.T for each in parts])).transpose()
    return Lanes(np.stack(parts))
