"""The differences of overlaid results from the first of them, at the sample times that they share. Coordinates that
coincide at all times are found too, so that one line shows them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes

from mbproj.analysis.comparison import common_samples
from mbproj.arrays import Array
from mbproj.figures import panels
from mbproj.results import Results

#: The symbol of a difference on an axis.
SIGN = "|Δ|"
#: A function that reads values (T) or (T, k) of a result; None where the result has none.
Read = Callable[[Results], Array | None]
#: The tolerance up to which coordinates coincide: a part of the largest value, and m or rad, as joints are closed to.
SAME, CLOSED = 1e-9, 1e-13


def comparable(results: Sequence[Results]) -> bool:
    """Whether another result shares a sample time with the first."""
    return any(len(common_samples(results[0].time, other.time)[0]) for other in results[1:])


def remark(results: Sequence[Results], labels: Sequence[str]) -> str:
    """A remark that names the first result, or tells why there are no differences."""
    if comparable(results):
        return f"{SIGN}: difference from {labels[0]}, at the times of both"
    return "no differences: the results share no sample time; run them with the same --output-step"


def draw(axis: Axes, results: Sequence[Results], labels: Sequence[str], read: Read, factor: float = 1.0) -> None:
    """Draw the difference of each other result from the first, times `factor`; of vectors the length. The axis is
    logarithmic and omits zeros, unless all differences are zero."""
    first = read(results[0])
    lines = []
    for index, (other, label) in enumerate(zip(results[1:], labels[1:], strict=True), start=1):
        second = read(other)
        if first is None or second is None:
            continue
        here, there = common_samples(results[0].time, other.time)
        apart = factor * np.abs(first[here] - second[there])
        lines.append(
            (results[0].abscissa[here], apart if apart.ndim == 1 else np.linalg.norm(apart, axis=1), label, index)
        )
    if any(np.any(apart > 0.0) for _, apart, _, _ in lines):
        axis.set_yscale("log")
        lines = [(time, np.where(apart > 0.0, apart, np.nan), label, index) for time, apart, label, index in lines]
    else:
        axis.set_yticks([0.0])
    for time, apart, label, index in lines:
        panels.plot(axis, time, apart, label, index)


def coinciding(results: Sequence[Results], names: Sequence[str]) -> dict[str, list[str]]:
    """Group the coordinates of the results that coincide: the others by the first of each group."""
    groups: dict[str, list[str]] = {}
    for name in names:
        own = [_of(result, name) for result in results]
        first = next((kept for kept in groups if _agree(own, [_of(result, kept) for result in results])), None)
        groups.setdefault(name, []) if first is None else groups[first].append(name)
    return groups


def alike(first: Array, second: Array) -> bool:
    """Whether two series are equal, up to round-off."""
    with np.errstate(invalid="ignore"):
        return bool(np.all(np.abs(first - second) <= SAME * np.max(np.abs(first), initial=0.0) + CLOSED))


def _of(result: Results, name: str) -> tuple[str, Array, Array] | None:
    if name not in result.names("coordinates"):
        return None
    own = result.coordinate(name)
    return own.unit, own.value, own.speed


def _agree(one: Sequence[tuple[str, Array, Array] | None], other: Sequence[tuple[str, Array, Array] | None]) -> bool:
    for first, second in zip(one, other, strict=True):
        if first is None or second is None:
            if first is not second:
                return False
        elif first[0] != second[0] or not alike(first[1], second[1]) or not alike(first[2], second[2]):
            return False
    return True
