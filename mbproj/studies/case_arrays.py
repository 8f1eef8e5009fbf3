"""Arrays of cases: code that is written for the numbers of one mechanism runs for a block of cases at once.

NumPy passes calls of its functions on to a CaseArray. Each case gets the bits that it would get alone. Three kinds of
operation run for all cases at once: elementwise operations that IEEE 754 rounds correctly; sums of fewer than 8 terms,
which NumPy adds in a fixed order; and matrix products, which NumPy computes matrix by matrix. All other operations are
called once for each case.

Decisions must be the same in all cases: truth values, integers, texts and shapes. Where they differ, CasesDiffer is
raised. Its `keys` say which cases belong together: the block is divided, and each part begins again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from numbers import Real
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from mbproj.base.cases import Cases, per_case

Kind = TypeVar("Kind")
NOTHING: Mapping[str, Any] = MappingProxyType({})
#: NumPy adds fewer terms than this in sequence, whatever their layout in memory.
IN_ORDER = 8
#: Operations whose result IEEE 754 defines to the last bit, or that only compare or select.
ROUNDED = frozenset({np.add, np.subtract, np.multiply, np.divide, np.square, np.sqrt, np.negative, np.positive})
COMPARING = frozenset({np.equal, np.not_equal, np.less, np.less_equal, np.greater, np.greater_equal})
LOGICAL = frozenset({np.logical_and, np.logical_or, np.logical_not, np.isfinite, np.isnan})
SELECTING = frozenset({np.maximum, np.minimum, np.absolute, np.sign, np.floor, np.ceil, np.rint})
EXACT = ROUNDED | COMPARING | LOGICAL | SELECTING


class OneCaseOnly(TypeError):
    """The error where code needs the numbers of one case: the cases of the block run one by one."""

    def __init__(self, what: str = "numbers of several cases go into an array of one") -> None:
        super().__init__(what)


class CasesDiffer(Exception):
    """The error where a decision differs between the cases of a block. Cases with equal `keys` (B,) belong together."""

    def __init__(self, keys: Sequence[Any]) -> None:
        super().__init__("cases of a block go different ways")
        self.keys = tuple(keys)


class CaseArray(Cases, np.lib.mixins.NDArrayOperatorsMixin):
    """An array (...), or a number, for each of B cases: `values` (B, ...)."""

    __slots__ = ("values",)
    __hash__ = object.__hash__
    values: npt.NDArray[Any]

    def __init__(self, values: npt.NDArray[Any]) -> None:
        self.values = values

    @property
    def shape(self) -> tuple[int, ...]:
        """The shape of one case."""
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
    def T(self) -> CaseArray:
        return self.transpose()

    @property
    def real(self) -> CaseArray:
        return self

    def __format__(self, how: str) -> str:
        """The text of the first case: text that is shown concerns one case only."""
        return format(self.values[0].item(), how)

    def __len__(self) -> int:
        if not self.ndim:
            raise TypeError("a number has no length")
        return self.values.shape[1]

    def __iter__(self) -> Iterator[Any]:
        return (self[at] for at in range(len(self)))

    def __getitem__(self, index: Any) -> Any:
        indices = index if isinstance(index, tuple) else (index,)
        if _is_split(indices):
            return call_each(lambda each: each[index], (self,))
        place = (slice(None), *indices)
        chosen = self.values[place]
        if any(isinstance(each, (np.ndarray, list)) for each in indices):
            chosen = _laid_out_like(self.values[0][index], chosen)
        return CaseArray(chosen)

    def __setitem__(self, index: Any, value: Any) -> None:
        indices = index if isinstance(index, tuple) else (index,)
        if _is_split(indices):
            for at, each in enumerate(self.values):
                each[index] = case_of(value, at)
            return
        place = (slice(None), *indices)
        self.values[place] = _raised(value, self.values[place].ndim)

    def call_each(self, function: Callable[..., Any], args: Sequence[Any], options: Mapping[str, Any]) -> Any:
        return call_each(function, args, options)

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]:
        """The array that all cases share. Raises OneCaseOnly where they differ."""
        if not _are_alike(self.values):
            raise OneCaseOnly("the numbers of several cases differ")
        return np.array(self.values[0], dtype=dtype)

    def __float__(self) -> float:
        return float(self.__array__())

    def __int__(self) -> int:
        return int(_agreed(self.values.astype(int)))

    def __bool__(self) -> bool:
        return bool(_agreed(self.values != 0.0))

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **options: Any) -> Any:
        if method == "at":
            return _add_at(ufunc, *inputs)
        if "out" in options:
            (into,) = options.pop("out")
            if not isinstance(into, CaseArray):
                raise OneCaseOnly
            into[...] = getattr(ufunc, method)(*inputs, **options)
            return into
        if method == "__call__" and not options:
            if ufunc in EXACT:
                most = 1 + max(np.ndim(each) for each in inputs)
                return _of_cases(ufunc(*(_raised(each, most) for each in inputs)))
            if ufunc is np.matmul:
                return _product(*inputs)
            if ufunc is np.power and _is_square(*inputs):
                return inputs[0] * inputs[0]
        return call_each(getattr(ufunc, method), inputs, options)

    def __array_function__(self, function: Any, types: Any, args: Any, options: Any) -> Any:
        if function in MAKERS:
            return MAKERS[function](self, *args, **options)
        if function in WRITERS or "out" in options:
            raise OneCaseOnly
        if function in OF_METHODS:
            return getattr(args[0], function.__name__)(*args[1:], **options)
        result = FUNCTIONS[function](*args, **options) if function in FUNCTIONS else NotImplemented
        return call_each(function, args, options) if result is NotImplemented else result

    def __getattr__(self, name: str) -> Any:
        """A method of arrays that is called on the array of each case."""
        if name.startswith("_") or not callable(getattr(np.ndarray, name, None)):
            raise AttributeError(name)
        return per_case(lambda *args, **options: getattr(np.asarray(args[0]), name)(*args[1:], **options)).__get__(self)

    def sum(self, axis: Any = None, **options: Any) -> Any:
        whole = self.size if axis is None else np.prod([self.shape[at] for at in np.atleast_1d(axis)])
        if whole < IN_ORDER and not options.keys() - {"keepdims"}:
            return CaseArray(self.values.sum(axis=self._axes(axis), **options))
        return call_each(np.sum, (self,), {"axis": axis, **options})

    def max(self, axis: Any = None, **options: Any) -> Any:
        return CaseArray(self.values.max(axis=self._axes(axis), **options))

    def _axes(self, axis: Any) -> Any:
        """The axes of one case as axes of the values (B, ...)."""
        if axis is None:
            return tuple(range(1, self.ndim + 1))
        if isinstance(axis, (tuple, list)):
            return tuple(at % self.ndim + 1 for at in axis)
        return axis % self.ndim + 1

    def reshape(self, *shape: Any) -> CaseArray:
        sizes = shape[0] if len(shape) == 1 and isinstance(shape[0], (tuple, list)) else shape
        return CaseArray(self.values.reshape(len(self.values), *sizes))

    def astype(self, dtype: Any, **options: Any) -> Any:
        cast = self.values.astype(dtype, **options)
        return _agreed(cast) if cast.dtype == bool else CaseArray(cast)

    def transpose(self, *axes: Any) -> CaseArray:
        permutation = axes[0] if len(axes) == 1 and isinstance(axes[0], (tuple, list)) else axes
        order = [at % self.ndim for at in permutation] if permutation else range(self.ndim)[::-1]
        return CaseArray(self.values.transpose(0, *(at + 1 for at in order)))

    def swapaxes(self, first: int, second: int) -> CaseArray:
        return CaseArray(self.values.swapaxes(*(at % self.ndim + 1 for at in (first, second))))

    def tolist(self) -> Any:
        """Nested lists whose numbers are of several cases."""
        return [each.tolist() for each in self] if self.ndim else self

    def is_integer(self) -> bool:
        """What `float.is_integer` is for numbers."""
        return bool(_agreed(self.values % 1.0 == 0.0))


Real.register(CaseArray)  # scenes and elements take it where they take a number


class CaseObjects(Cases):
    """One object for each of B cases: `items`. An attribute is read from each object, a method is called on each."""

    __slots__ = ("items",)
    items: list[Any]

    def __init__(self, items: Sequence[Any]) -> None:
        object.__setattr__(self, "items", list(items))

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        attributes = [getattr(each, name) for each in self.items]
        return CaseObjects(attributes) if callable(attributes[0]) else stacked(attributes)

    def __setattr__(self, name: str, value: Any) -> None:
        for at, each in enumerate(self.items):
            setattr(each, name, case_of(value, at))

    def __call__(self, *args: Any, **options: Any) -> Any:
        return call_each(lambda each, *values, **more: each(*values, **more), (self, *args), options)

    def call_each(self, function: Callable[..., Any], args: Sequence[Any], options: Mapping[str, Any]) -> Any:
        return call_each(function, args, options)


class KernelOfCases:
    """The kernel's module, or a class of it, for `count` cases: what it makes and calls is for each case. Each case has
    a model of its own, also where all models are equal: runs change the rows of theirs."""

    def __init__(self, kernel: Any, count: int) -> None:
        self._kernel, self._count = kernel, count

    def __getattr__(self, name: str) -> Any:
        attribute = getattr(self._kernel, name)
        return KernelOfCases(attribute, self._count) if callable(attribute) else attribute

    def __call__(self, *args: Any, **options: Any) -> Any:
        if self._kernel.__name__.endswith("Model"):
            every = CaseObjects([self._kernel] * self._count)
            return every(*args, **options)
        return per_case(self._kernel)(*args, **options)


def case_of(values: Kind, at: int) -> Kind:
    """The values of one case."""
    part = _part_of(values)
    return values if part is None else part(at)


def call_each(function: Callable[..., Any], args: Sequence[Any], options: Mapping[str, Any] = NOTHING) -> Any:
    """function(*args, **options), called once for each case of the arguments. Where it raises an error for all
    cases, the first is raised; for some of them, CasesDiffer."""
    taken = [_part_of(each) for each in args]
    named = [(name, part) for name, each in options.items() if (part := _part_of(each)) is not None]
    results: list[Any] = []
    for at in range(_count((*args, *options.values()))):
        arguments = [each if part is None else part(at) for each, part in zip(args, taken, strict=True)]
        try:
            results.append(function(*arguments, **{**options, **{name: part(at) for name, part in named}}))
        except (CasesDiffer, OneCaseOnly):
            raise
        except Exception as error:
            results.append(error)
    failed = [isinstance(each, Exception) for each in results]
    if all(failed):
        raise results[0]
    if any(failed):
        raise CasesDiffer(failed)
    return stacked(results)


def _part_of(values: Any) -> Callable[[int], Any] | None:
    """A function that returns the part of one case; None where the value is the same for all cases."""
    if isinstance(values, CaseArray):
        array = values.values
        return array.__getitem__ if values.ndim else array.tolist().__getitem__
    if isinstance(values, CaseObjects):
        return values.items.__getitem__
    if isinstance(values, dict):
        inside = _part_of([*values.values()])
        return None if inside is None else lambda at: dict(zip(values, inside(at), strict=True))
    if not isinstance(values, (list, tuple)):
        return None
    parts = [_part_of(each) for each in values]
    if all(part is None for part in parts):
        return None
    pairs = list(zip(values, parts, strict=True))
    make = type(values)._make if hasattr(values, "_make") else type(values)
    return lambda at: make([each if part is None else part(at) for each, part in pairs])


def _count(values: Any) -> int:
    """The number B of cases of the values; 0 where nothing is of several."""
    if isinstance(values, CaseArray):
        return len(values.values)
    if isinstance(values, CaseObjects):
        return len(values.items)
    if isinstance(values, dict):
        values = values.values()
    elif not isinstance(values, (list, tuple)):
        return 0
    return next((count for count in map(_count, values) if count), 0)


def stacked(values: Sequence[Any]) -> Any:
    """The values of all cases as one value: floats become a CaseArray. Integers and texts must be the same for all
    cases, else CasesDiffer is raised."""
    first = values[0]
    if all(each is first for each in values):
        return first
    _same([each is None for each in values])
    if isinstance(first, (float, np.floating)):
        return CaseArray(np.array(values, dtype=float))
    if isinstance(first, np.ndarray):
        _same([each.shape for each in values])
        if first.flags.f_contiguous and not first.flags.c_contiguous:
            return stacked([each.T for each in values]).T
        return _of_cases(np.stack(values))
    if isinstance(first, (int, bool, str, bytes, np.integer, np.bool_)):
        return _same(values)
    if isinstance(first, (list, tuple)):
        _same([len(each) for each in values])
        parts = [stacked(each) for each in zip(*values, strict=True)]
        return type(first)._make(parts) if hasattr(first, "_make") else type(first)(parts)
    if isinstance(first, dict):
        _same([tuple(each) for each in values])
        return {key: stacked([each[key] for each in values]) for key in first}
    return CaseObjects(values)


def _same(values: Sequence[Any]) -> Any:
    """The value that all cases share. Raises CasesDiffer where they differ."""
    if any(each != values[0] for each in values):
        raise CasesDiffer(values)
    return values[0]


def _of_cases(values: npt.NDArray[Any]) -> Any:
    """Floats (B, ...) as a CaseArray; values of other types must be the same in all cases."""
    return CaseArray(values) if values.dtype.kind == "f" else _agreed(values)


def _agreed(values: npt.NDArray[Any]) -> Any:
    """The value (...) that all cases of `values` (B, ...) share. Raises CasesDiffer where they differ."""
    if not _are_alike(values):
        raise CasesDiffer([each.tobytes() for each in np.ascontiguousarray(values)])
    return values[0]


def _are_alike(values: npt.NDArray[Any]) -> bool:
    """Whether all cases of values (B, ...) have the same bits."""
    bits = values.view(np.int64) if values.dtype == float and values.itemsize == 8 else values
    return bool((bits == bits[0]).all())


def _is_split(index: tuple[Any, ...]) -> bool:
    """Whether a slice stands between arrays or integers of an index. NumPy then moves their axes to the front."""
    if not any(isinstance(each, (np.ndarray, list)) for each in index):
        return False
    advanced = [at for at, each in enumerate(index) if isinstance(each, (np.ndarray, list, int, np.integer))]
    return advanced[-1] - advanced[0] + 1 != len(advanced)


def _raised(values: Any, ndim: int) -> Any:
    """The values (B, ...) of a CaseArray with `ndim` axes in all: axes of length 1 are inserted after the first. Any
    other value is returned as it is."""
    if not isinstance(values, CaseArray):
        return values
    array, missing = values.values, ndim - values.ndim - 1
    return array.reshape(len(array), *(1,) * missing, *array.shape[1:]) if missing > 0 else array


def _laid_out_like(one: npt.NDArray[Any], values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Values (B, ...) in which each case has the memory layout of `one`. The bits of matrix products depend on it."""
    order = sorted(range(one.ndim), key=lambda axis: -one.strides[axis])
    copy = np.empty((len(values), *(one.shape[axis] for axis in order)), values.dtype)
    copy = copy.transpose(0, *(order.index(axis) + 1 for axis in range(one.ndim)))
    copy[...] = values
    return copy


def _is_square(base: Any, exponent: Any) -> bool:
    """Whether base**exponent is the square of an array. NumPy multiplies an array by itself; for the square of a number
    it calls the C library, whose result may differ."""
    return isinstance(base, CaseArray) and base.ndim > 0 and type(exponent) in (int, float) and exponent == 2


def _product(first: Any, second: Any) -> CaseArray:
    """A @ B. NumPy multiplies a stack matrix by matrix, so that each case keeps its bits."""
    row, column = first.ndim == 1, second.ndim == 1
    first = first[None, :] if row else first
    second = second[:, None] if column else second
    most = 1 + max(first.ndim, second.ndim)
    result = _raised(first, most) @ _raised(second, most)
    result = result[..., 0, :] if row else result
    return CaseArray(result[..., 0] if column else result)


def _add_at(ufunc: np.ufunc, into: Any, index: Any, *values: Any) -> None:
    """ufunc.at, which writes into its first operand."""
    if not isinstance(into, CaseArray):
        raise OneCaseOnly
    for at, each in enumerate(into.values):
        ufunc.at(each, index, *(case_of(value, at) for value in values))


def _made(like: CaseArray, nested: Any, dtype: Any = None) -> CaseArray:
    """np.array of nested lists, for as many cases as `like` has."""
    values = _nested(nested)
    return CaseArray(np.array(values if len(values) > 1 else np.repeat(values, len(like.values), axis=0), dtype=dtype))


def _nested(values: Any) -> npt.NDArray[Any]:
    """The values (B, ...) of nested lists, or (1, ...) where they are the same for all cases."""
    if isinstance(values, CaseArray):
        return values.values
    if not isinstance(values, (list, tuple)):
        return np.array(values, dtype=float)[None]
    parts = [_nested(each) for each in values]
    most = max((len(each) for each in parts), default=1)
    return np.stack([np.broadcast_to(each, (most, *each.shape[1:])) for each in parts], axis=1)


def _new(make: Any) -> Callable[..., CaseArray]:
    """A function that makes a new array with as many cases as `like`."""

    def new(like: CaseArray, shape: Any, dtype: Any = float, order: str = "C") -> CaseArray:
        sizes = (shape,) if isinstance(shape, (int, np.integer)) else tuple(shape)
        if order == "F":
            return CaseArray(make((len(like.values), *sizes[::-1]), dtype)).T
        return CaseArray(make((len(like.values), *sizes), dtype))

    return new


def _joined(join: Any) -> Callable[..., Any]:
    """np.concatenate or np.stack. A part that is the same for all cases is repeated."""

    def joined(parts: Sequence[Any], axis: int = 0, **options: Any) -> Any:
        if options or axis is None:
            return NotImplemented
        count = _count(parts)
        arrays = [
            each.values if isinstance(each, CaseArray) else np.broadcast_to(np.asarray(each), (count, *np.shape(each)))
            for each in parts
        ]
        return CaseArray(join(arrays, axis=axis + 1 if axis >= 0 else axis))

    return joined


def _where(condition: Any, *choices: Any) -> Any:
    if isinstance(condition, CaseArray) or not choices:
        return NotImplemented
    most = 1 + max(np.ndim(each) for each in (condition, *choices))
    return _of_cases(np.where(condition, *(_raised(each, most) for each in choices)))


def _norm(values: Any, ord: Any = None, axis: Any = None, keepdims: bool = False) -> Any:
    """Lengths of short vectors, as NumPy has them: by the root of the sum of squares."""
    if ord is not None or not isinstance(axis, int):
        return NotImplemented
    return np.sqrt((values * values).sum(axis=axis, keepdims=keepdims))


def _column_stack(parts: Sequence[Any]) -> Any:
    return np.concatenate([each[:, None] if np.ndim(each) == 1 else each for each in parts], axis=1)


#: Functions that write into an operand.
WRITERS = frozenset({np.copyto, np.put, np.place, np.putmask, np.put_along_axis, np.fill_diagonal})
#: Functions that make an array like another. NumPy takes `like` out of the arguments, which stands first here.
MAKERS: Mapping[Any, Callable[..., Any]] = {
    np.array: _made,
    np.empty: _new(np.empty),
    np.zeros: _new(np.zeros),
    np.ascontiguousarray: lambda like, values, dtype=None: CaseArray(np.ascontiguousarray(like.values, dtype)),
    np.asfortranarray: lambda like, values: CaseArray(np.ascontiguousarray(like.T.values)).T,
}
#: Functions that a method of the array computes.
OF_METHODS = frozenset({np.sum, np.max, np.min, np.any, np.all, np.reshape, np.swapaxes})
FUNCTIONS: Mapping[Any, Callable[..., Any]] = {
    np.concatenate: _joined(np.concatenate),
    np.stack: _joined(np.stack),
    np.column_stack: _column_stack,
    np.hstack: lambda parts: np.concatenate(parts, axis=0 if np.ndim(parts[0]) == 1 else 1),
    np.where: _where,
    np.linalg.eigvalsh: lambda values: CaseArray(np.linalg.eigvalsh(values.values)),
    np.linalg.norm: _norm,
    np.iscomplexobj: lambda values: values.dtype.kind == "c",
    np.ndim: lambda values: values.ndim,
}
