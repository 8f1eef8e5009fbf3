"""Modes traced over a parameter: root loci and Campbell diagrams. Each mode is followed from value to value."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from mbproj.arrays import Array, Numbers
from mbproj.dataclass import dataclass
from mbproj.linear.modes import Modes


@dataclass(frozen=True, eq=False)
class RootLocus:
    """Eigenvalues (p, j) at the p `values` of the parameter `name`, one column a mode; NaN where the mode does not
    exist."""

    name: str
    values: Array
    eigenvalues: Numbers


def trace(name: str, values: Sequence[float], at: Callable[[float], Modes]) -> tuple[RootLocus, Modes]:
    """Return the trace of the modes at each value, computed by `at`, and the modes at the last value."""
    columns: list[list[complex]] = []
    place: list[int] = []
    before: Modes | None = None
    for number, value in enumerate(values):
        here = at(value)
        place = _places(before, here, place, len(columns))
        columns += [[np.nan] * number for _ in range(max(place, default=-1) + 1 - len(columns))]
        by_column = dict(zip(place, here.eigenvalues.tolist(), strict=True))
        for column, entries in enumerate(columns):
            entries.append(by_column.get(column, complex(np.nan, np.nan)))
        before = here
    assert before is not None
    eigenvalues = np.array(columns, dtype=complex).reshape(len(columns), len(values)).T
    return RootLocus(name, np.array(values, dtype=float), eigenvalues), before


def _places(before: Modes | None, here: Modes, place: list[int], columns: int) -> list[int]:
    """Return the column of each mode: that of the previous mode most like it in eigenvalue and shape."""
    if before is None:
        return list(range(len(here.eigenvalues)))
    from scipy.optimize import linear_sum_assignment

    speed = np.abs(before.eigenvalues[:, None]) + np.abs(here.eigenvalues) + np.finfo(float).tiny
    unlike = np.abs(before.eigenvalues[:, None] - here.eigenvalues) / speed + 1.0 - _likeness(before, here)
    rows, chosen = linear_sum_assignment(unlike)
    place_of = dict(zip(chosen.tolist(), (place[row] for row in rows), strict=True))
    fresh = iter(range(columns, columns + len(here.eigenvalues)))
    return [place_of[mode] if mode in place_of else next(fresh) for mode in range(len(here.eigenvalues))]


def _likeness(before: Modes, here: Modes) -> Array:
    """Return the modal assurance criterion of all pairs, 1 where shapes are alike (Allemang 2003)."""
    length = here.reference.system.length
    shapes = [each.shapes.reshape(len(each.shapes), -1, 6) / ([length] * 3 + [1.0] * 3) for each in (before, here)]
    old, new = (shape.reshape(len(shape), -1) for shape in shapes)
    sizes = np.sum(np.abs(old) ** 2, axis=1)[:, None] * np.sum(np.abs(new) ** 2, axis=1)
    return np.asarray(np.abs(old.conj() @ new.T) ** 2 / np.maximum(sizes, np.finfo(float).tiny), dtype=float)
