"""How far overlaid results are from the first of them, at the sample times that they share; which coordinates coincide
all the time: drawn once, they leave room for the others."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes

from mbproj.analysis.comparison import common_samples
from mbproj.arrays import Array
from mbproj.figures import panels
from mbproj.results import Results

#: How a difference reads on an axis.
SIGN = "|Δ|"
#: What is drawn: values (T) or (T, k) of a result; None where it has none.
Read = Callable[[Results], Array | None]
#: Part of its largest value by which a coordinate may differ from another, and how much in m or rad it may at least:
#: to that joints are closed.
SAME, CLOSED = 1e-9, 1e-13


def comparable(results: Sequence[Results]) -> bool:
    """Whether any other result shares a sample time with the first."""
    return any(len(common_samples(results[0].time, other.time)[0]) for other in results[1:])


def remark(results: Sequence[Results], labels: Sequence[str]) -> str:
    """What the differences are from, or why there are none."""
    if comparable(results):
        return f"{SIGN}: difference from {labels[0]}, at the times of both"
    return "no differences: the results share no sample time; run them with the same --output-step"


def draw(axis: Axes, results: Sequence[Results], labels: Sequence[str], read: Read, factor: float = 1.0) -> None:
    """A line for each result but the first: how far it is from the first, vectors by a length, times `factor`; on a
    logarithmic axis, which leaves zeros out, where not all are zero."""
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
    """Of coordinates in any of the results, the first of each that coincide, and the others by it."""
    found: dict[str, list[str]] = {}
    for name in names:
        own = [_of(result, name) for result in results]
        first = next((kept for kept in found if _agree(own, [_of(result, kept) for result in results])), None)
        found.setdefault(name, []) if first is None else found[first].append(name)
    return found


def alike(first: Array, second: Array) -> bool:
    """Whether two series have the same values, up to round-off."""
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
