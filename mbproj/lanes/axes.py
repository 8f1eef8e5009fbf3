"""The axes of Lanes, whose first axis counts the cases, and their layout in memory."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt


def are_alike(values: npt.NDArray[Any]) -> bool:
    """Whether all lanes of values (B, ...) have the same bits."""
    bits = values.view(np.int64) if values.dtype == float and values.itemsize == 8 else values
    return bool((bits == bits[0]).all())


def is_split(index: tuple[Any, ...]) -> bool:
    """Whether a slice stands between arrays or integers of an index. NumPy then moves their axes to the front."""
    if not any(isinstance(each, (np.ndarray, list)) for each in index):
        return False
    advanced = [at for at, each in enumerate(index) if isinstance(each, (np.ndarray, list, int, np.integer))]
    return advanced[-1] - advanced[0] + 1 != len(advanced)


def raised(values: npt.NDArray[Any], ndim: int) -> npt.NDArray[Any]:
    """Values (B, ...) with `ndim` axes in all: axes of length 1 are inserted after the first."""
    missing = ndim - values.ndim
    return values.reshape(len(values), *(1,) * missing, *values.shape[1:]) if missing > 0 else values


def laid_out_like(lane: npt.NDArray[Any], values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """Values (B, ...) in which each lane has the memory layout of `lane`. The bits of matrix products depend on it."""
    order = sorted(range(lane.ndim), key=lambda axis: -lane.strides[axis])
    copy = np.empty((len(values), *(lane.shape[axis] for axis in order)), values.dtype)
    copy = copy.transpose(0, *(order.index(axis) + 1 for axis in range(lane.ndim)))
    copy[...] = values
    return copy


def axes_of(axis: Any, ndim: int) -> Any:
    """The axes of one lane as axes of the values (B, ...)."""
    if axis is None:
        return tuple(range(1, ndim + 1))
    if isinstance(axis, (tuple, list)):
        return tuple(at % ndim + 1 for at in axis)
    return axis % ndim + 1
