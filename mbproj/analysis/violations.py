"""The largest violations of the constraints."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass


@dataclass(frozen=True)
class SeriesPeak:
    """The largest value of a series, the time (s) when it is first reached, and the name of its column."""

    value: float
    time: float
    name: str


def peak(time: Array, values: Array, name: str) -> SeriesPeak:
    """The largest of `values` (T), T >= 1. NaN counts as larger than any number."""
    row = int(np.argmax(values))
    return SeriesPeak(float(values[row]), float(time[row]), name)


def worst(time: Array, values: Array, names: Sequence[str]) -> SeriesPeak | None:
    """The largest of `values` (T, columns), T >= 1, with the name of its column; None without columns."""
    if not names:
        return None
    row, column = np.unravel_index(int(np.argmax(values)), values.shape)
    return SeriesPeak(float(values[row, column]), float(time[row]), names[int(column)])
