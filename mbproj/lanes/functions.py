"""Functions of NumPy that run for all lanes at once. The others run lane by lane."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from mbproj.lanes.array import INTO_ONE, Lanes, LanesMet, agreed, laned
from mbproj.lanes.axes import axes_of
from mbproj.lanes.each import each_call
from mbproj.lanes.ufuncs import aligned


def _at_most(parts: Sequence[Any], width: int) -> list[Any]:
    """The arrays (B, ...) of parts, B = `width`. A part that is the same for all cases is repeated."""
    return [
        each.values if isinstance(each, Lanes) else np.broadcast_to(np.asarray(each), (width, *np.shape(each)))
        for each in parts
    ]


def _width(parts: Sequence[Any]) -> int:
    return max(len(each.values) if isinstance(each, Lanes) else 0 for each in parts)


def _concatenate(parts: Sequence[Any], axis: int = 0, **options: Any) -> Any:
    if options or axis is None:
        return NotImplemented
    return Lanes(np.concatenate(_at_most(parts, _width(parts)), axis=axis + 1 if axis >= 0 else axis))


def _stack(parts: Sequence[Any], axis: int = 0, **options: Any) -> Any:
    if options:
        return NotImplemented
    return Lanes(np.stack(_at_most(parts, _width(parts)), axis=axis + 1 if axis >= 0 else axis))


def _hstack(parts: Sequence[Any], **options: Any) -> Any:
    return _concatenate(parts, 0 if np.ndim(parts[0]) == 1 else 1, **options)


def _column_stack(parts: Sequence[Any]) -> Any:
    return _concatenate([each[:, None] if np.ndim(each) == 1 else each for each in parts], 1)


def _where(condition: Any, *choices: Any) -> Any:
    if isinstance(condition, Lanes) or not choices:
        return NotImplemented
    return laned(np.where(*aligned([condition, *choices])))


def _array_maker(make: Any) -> Callable[..., Any]:
    """A function that makes a new array with as many lanes as `like`. NumPy takes `like` out of the arguments before it
    calls `__array_function__`, so `called` passes it on."""

    def make_lanes(like: Any, shape: Any, dtype: Any = float, order: str = "C") -> Any:
        own = (shape,) if isinstance(shape, (int, np.integer)) else tuple(shape)
        if order == "F":
            return Lanes(make((len(like.values), *own[::-1]), dtype)).transpose()
        return Lanes(make((len(like.values), *own), dtype))

    return make_lanes


def _empty_like(like: Any, dtype: Any = None, **options: Any) -> Any:
    if options or dtype is not None:
        return NotImplemented
    return Lanes(np.empty_like(like.values))


def _zeros_like(like: Any, dtype: Any = None, **options: Any) -> Any:
    if options or dtype is not None:
        return NotImplemented
    return Lanes(np.zeros_like(like.values))


def _norm(values: Any, ord: Any = None, axis: Any = None, keepdims: bool = False) -> Any:
    """Lengths of short vectors, as NumPy has them: by the root of the sum of squares."""
    if ord is not None or not isinstance(axis, int):
        return NotImplemented
    return np.sqrt((values * values).sum(axis=axis, keepdims=keepdims))


def _append(values: Any, more: Any, axis: int | None = None) -> Any:
    if axis is not None:
        return NotImplemented
    return _concatenate([each.ravel() if np.ndim(each) else np.reshape(each, 1) for each in (values, more)])


def _tile(values: Any, repeats: Any) -> Any:
    if values.ndim != 1 or not isinstance(repeats, int):
        return NotImplemented
    return Lanes(np.tile(values.values, (1, repeats)))


def _place_of(function: Callable[..., Any]) -> Callable[..., Any]:
    """argmax or argmin, whose places must be the same in all lanes."""

    def place(values: Any, axis: int | None = None) -> Any:
        own, axis = (values.ravel(), 0) if axis is None else (values, axis)
        return agreed(function(own.values, axes_of(axis, own.ndim)))

    return place


#: Functions that write into an operand.
WRITES = frozenset({np.copyto, np.put, np.place, np.putmask, np.put_along_axis, np.fill_diagonal})
MADE: Mapping[Any, Callable[..., Any]] = {make: _array_maker(make) for make in (np.empty, np.zeros)}
FUNCTIONS: Mapping[Any, Callable[..., Any]] = {
    np.concatenate: _concatenate,
    np.stack: _stack,
    np.hstack: _hstack,
    np.column_stack: _column_stack,
    np.where: _where,
    np.result_type: lambda *parts: np.result_type(*[getattr(each, "dtype", each) for each in parts]),
    np.append: _append,
    np.linalg.norm: _norm,
    np.empty_like: _empty_like,
    np.zeros_like: _zeros_like,
    np.tile: _tile,
    np.argmax: _place_of(np.argmax),
    np.argmin: _place_of(np.argmin),
    np.sort: lambda values, axis=-1: Lanes(np.sort(values.values, axes_of(axis, values.ndim))),
    np.linalg.eigvalsh: lambda values: Lanes(np.linalg.eigvalsh(values.values)),
    np.linalg.pinv: lambda values, rcond: Lanes(np.linalg.pinv(values.values, rcond=rcond)),
    np.iscomplexobj: lambda values: values.dtype.kind == "c",
    np.round: lambda values: Lanes(np.round(values.values)),
    np.shape: lambda values: values.shape,
    np.ndim: lambda values: values.ndim,
    np.swapaxes: lambda values, first, second: values.swapaxes(first, second),
    np.reshape: lambda values, shape, **options: values.reshape(shape, **options),
    np.ravel: lambda values: values.ravel(),
    np.transpose: lambda values, axes=(): values.transpose(*(axes or ())),
    np.sum: lambda values, axis=None, **options: values.sum(axis=axis, **options),
    np.max: lambda values, axis=None, **options: values.max(axis=axis, **options),
    np.min: lambda values, axis=None, **options: values.min(axis=axis, **options),
    np.any: lambda values, axis=None, **options: values.any(axis=axis, **options),
    np.all: lambda values, axis=None, **options: values.all(axis=axis, **options),
}


def called(function: Any, like: Lanes, args: Sequence[Any], options: Mapping[str, Any]) -> Any:
    """The result of `Lanes.__array_function__`; `like` is one of the arguments."""
    if function in WRITES or "out" in options:
        raise LanesMet(INTO_ONE)
    if function in MADE:
        return MADE[function](like, *args, **options)
    result = FUNCTIONS[function](*args, **options) if function in FUNCTIONS else NotImplemented
    return each_call(function, args, options) if result is NotImplemented else result
