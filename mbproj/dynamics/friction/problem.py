"""All contacts and frictions that hold at an instant, as one problem on the Delassus operator B of their rows. The law
is the kernel's, in kernel/src/laws/contact_problem.hpp."""

from __future__ import annotations

from collections.abc import Sequence
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.errors import InputError, Problem
from mbproj.kernel import core
from mbproj.thresholds import THRESHOLDS, of_the_kernel


class Cone(NamedTuple):
    """What the forces of one contact may be. `push`: the row that pushes, -1 for the friction of a joint. `tangents`:
    the rows of its friction. It sticks with a force up to `most`, a coefficient of the push or a force; or it `slides`,
    with this part of the push along each tangent."""

    push: int
    tangents: tuple[int, ...] = ()
    most: float = 0.0
    slides: tuple[float, ...] = ()


def contact_problem(B: Array, b: Array, cones: Sequence[Cone], give: float = 0.0) -> Array | None:
    """y (n,) of all rows, with which none that is held accelerates: pushes, and tangents that stick. None where no
    forces within the cones do that. B (n, n) is symmetric. Springs that `give`, in 1/kg, have an answer always. Raises
    InputError without a kernel."""
    found: Array | None = law().contact_problem(thresholds(), numbers(B), numbers(b), list(cones), give)
    return found


def law() -> ModuleType:
    """The kernel, which has the laws of contacts and dry friction. Raises InputError where there is none."""
    kernel = core()
    if kernel is None:
        hint = "install mbproj where a C++ compiler is, as 'mbproj help install it' says"
        raise InputError(Problem("dry friction and contacts that share a load need the compiled kernel", hint=hint))
    return kernel


def thresholds() -> Any:
    """Those of the kernel's laws."""
    return law().Thresholds(of_the_kernel())


def numbers(values: Array) -> Array:
    """As the kernel takes them."""
    return np.ascontiguousarray(values, dtype=float)


def independent(B: Array, rows: Integers) -> Integers:
    """Of some rows of B as many as do not depend on each other, the most independent first, in ascending order."""
    left = B[np.ix_(rows, rows)].copy()
    size, found = np.diagonal(left).copy(), list[int]()
    while True:
        part = np.diagonal(left) / np.where(size > 0.0, size, 1.0)
        best = int(np.argmax(part)) if len(part) else 0
        if not len(part) or part[best] <= THRESHOLDS.no_push:
            return np.sort(rows[found])
        found.append(best)
        left -= np.outer(left[:, best], left[best]) / left[best, best]
