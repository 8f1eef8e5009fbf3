"""Lanes: an array, or a number, for each case of a block.

Code for the numbers of one mechanism takes Lanes as well, since NumPy passes calls of its functions on to them. Each
lane gets the bits that it would get alone. Three kinds of operation run for all lanes at once: elementwise operations
that IEEE 754 rounds correctly; sums of fewer than 8 terms, which NumPy adds in a fixed order; and matrix products,
which NumPy computes matrix by matrix. All other operations run lane by lane.

Decisions must be the same in all lanes: truth values, integers and shapes. Where they differ, Parted is raised. Its
`keys` say which lanes go together: the block is divided, and each part begins again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj.lanes.axes import are_alike, axes_of, is_split, laid_out_like, raised
from mbproj.several import Several

#: NumPy adds fewer terms than this in sequence, whatever their layout in memory.
IN_ORDER = 8


#: The message of LanesMet where Lanes would be written into an ordinary array.
INTO_ONE = "numbers of several cases go into an array of one"


#: The functions that run ufuncs ("ufunc"), other functions of NumPy ("function"), and calls for each lane ("each"). The
#: package's `__init__` sets them, because their modules import this one.
HOW: dict[str, Callable[..., Any]] = {}


class LanesMet(TypeError):
    """The error where numbers of several cases stand in place of one number."""


class Parted(Exception):
    """The error where a decision differs between the cases of a block. Lanes with equal `keys` (B,) belong together."""

    def __init__(self, keys: Sequence[Any]) -> None:
        super().__init__("cases of a block go different ways")
        self.keys = tuple(keys)


def agreed(values: npt.NDArray[Any]) -> Any:
    """The value (...) that all lanes of `values` (B, ...) share. Raises Parted where they differ."""
    if not are_alike(values):
        raise Parted([each.tobytes() for each in np.ascontiguousarray(values)])
    return values[0]


def laned(values: npt.NDArray[Any]) -> Any:
    """Floats (B, ...) as Lanes; values of other types must be the same in all lanes."""
    return Lanes(values) if values.dtype.kind == "f" else agreed(values)


class Lanes(Several, np.lib.mixins.NDArrayOperatorsMixin):
    """An array (...) for each of B cases: `values` (B, ...)."""

    __slots__ = ("values",)
    __hash__ = object.__hash__
    values: npt.NDArray[Any]

    def __init__(self, values: npt.NDArray[Any]) -> None:
        self.values = values

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of one lane."""
        return self.values.shape[1:]

    @property
    def ndim(self) -> int:
        return self.values.ndim - 1

    @property
    def size(self) -> int:
        return self.values[0].size

    @property
    def dtype(self) -> np.dtype[Any]:
        return self.values.dtype

    @property
    def T(self) -> Lanes:
        return self.transpose()

    @property
    def real(self) -> Lanes:
        return self

    def __format__(self, how: str) -> str:
        """The text of the first case: text that is shown concerns one case only."""
        return format(self.values[0].item(), how)

    def __repr__(self) -> str:
        return f"Lanes({self.values!r})"

    def __len__(self) -> int:
        if not self.ndim:
            raise TypeError("a number has no length")
        return self.values.shape[1]

    def __iter__(self) -> Iterator[Any]:
        return (self[at] for at in range(len(self)))

    def __getitem__(self, index: Any) -> Any:
        own = index if isinstance(index, tuple) else (index,)
        if is_split(own):
            return lanewise(lambda each: each[index], self)
        place = (slice(None), *own)
        chosen = self.values[place]
        if any(isinstance(each, (np.ndarray, list)) for each in own):
            chosen = laid_out_like(self.values[0][index], chosen)
        return Lanes(chosen)

    def __setitem__(self, index: Any, value: Any) -> None:
        own = index if isinstance(index, tuple) else (index,)
        if is_split(own):
            for at, each in enumerate(self.values):
                each[index] = value.values[at] if isinstance(value, Lanes) else value
            return
        place = (slice(None), *own)
        if isinstance(value, Lanes):
            value = raised(value.values, self.values[place].ndim)
        self.values[place] = value

    def _agreed(self) -> npt.NDArray[Any]:
        """The value that all lanes share. Raises LanesMet where they differ."""
        if not are_alike(self.values):
            raise LanesMet("the numbers of several cases differ")
        return self.values[0]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        return np.array(self._agreed(), dtype=dtype)

    def __float__(self) -> float:
        return float(self._agreed())

    def __int__(self) -> int:
        return int(agreed(self.values.astype(int)))

    def __bool__(self) -> bool:
        return bool(agreed(self.values != 0.0))

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        return HOW["ufunc"](ufunc, method, inputs, options)

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Any:
        return HOW["function"](function, self, args, kwargs)

    def __getattr__(self, name: str) -> Any:
        """A method of arrays that runs lane by lane."""
        if name.startswith("_") or not callable(getattr(np.ndarray, name, None)):
            raise AttributeError(name)
        return lambda *args, **options: _looped(
            lambda each, *own, **more: getattr(np.asarray(each), name)(*own, **more), (self, *args), options
        )

    def sum(self, axis: Any = None, **options: Any) -> Any:
        whole = self.size if axis is None else np.prod([self.shape[at] for at in np.atleast_1d(axis)])
        if whole < IN_ORDER and not options.keys() - {"keepdims"}:
            return Lanes(self.values.sum(axis=axes_of(axis, self.ndim), **options))
        return _looped(np.sum, (self,), {"axis": axis, **options})

    def _extreme(self, kind: np.ufunc, axis: Any, options: Mapping[str, Any]) -> Any:
        return Lanes(kind.reduce(self.values, axis=axes_of(axis, self.ndim), **options))

    def max(self, axis: Any = None, **options: Any) -> Any:
        return self._extreme(np.maximum, axis, options)

    def min(self, axis: Any = None, **options: Any) -> Any:
        return self._extreme(np.minimum, axis, options)

    def any(self, axis: Any = None, **options: Any) -> Any:
        return agreed((self.values != 0.0).any(axis=axes_of(axis, self.ndim), **options))

    def all(self, axis: Any = None, **options: Any) -> Any:
        return agreed((self.values != 0.0).all(axis=axes_of(axis, self.ndim), **options))

    def reshape(self, *shape: Any, **options: Any) -> Lanes:
        own = shape[0] if len(shape) == 1 and isinstance(shape[0], (tuple, list)) else shape
        if options:
            reshaped: Lanes = lanewise(lambda each: np.asarray(each).reshape(*own, **options), self)
            return reshaped
        return Lanes(self.values.reshape(len(self.values), *own))

    def ravel(self) -> Lanes:
        return self.reshape(-1)

    def copy(self, order: str = "C") -> Lanes:
        return Lanes(self.values.copy("K"))

    def astype(self, dtype: Any, **options: Any) -> Any:
        cast = self.values.astype(dtype, **options)
        return agreed(cast) if cast.dtype == bool else Lanes(cast)

    def transpose(self, *axes: Any) -> Lanes:
        own = axes[0] if len(axes) == 1 and isinstance(axes[0], (tuple, list)) else axes
        order = [at % self.ndim for at in own] if own else range(self.ndim)[::-1]
        return Lanes(self.values.transpose(0, *(at + 1 for at in order)))

    def swapaxes(self, first: int, second: int) -> Lanes:
        return Lanes(self.values.swapaxes(*(at % self.ndim + 1 for at in (first, second))))

    def tolist(self) -> Any:
        """Nested lists whose numbers may be Lanes."""
        return [each.tolist() for each in self] if self.ndim else self

    def item(self, *place: int) -> Lanes:
        return Lanes(self.values.reshape(len(self.values), -1)[:, place[0] if place else 0])

    def tobytes(self) -> bytes:
        return bytes(agreed(self.values).tobytes())


def lanewise(function: Callable[..., Any], *args: Any) -> Any:
    """The result of a function of one lane, for all lanes."""
    return _looped(function, args)


def _looped(function: Any, args: Sequence[Any], options: Mapping[str, Any] = MappingProxyType({})) -> Any:
    return HOW["each"](function, args, options)
