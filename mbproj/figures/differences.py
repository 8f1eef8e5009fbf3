"""How far overlaid results are from the first of them, at the sample times that they share."""

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
