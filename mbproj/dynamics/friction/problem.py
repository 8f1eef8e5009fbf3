"""The forces of all contacts and frictions at an instant, from the Delassus operator B of their rows. The law is the
kernel's, in kernel/src/laws/contact_problem.hpp."""

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
    """The forces that one contact may have. `push` is its row along the normal, -1 for the friction of a joint, and
    `tangents` are the rows of its friction. A contact that sticks has a friction up to `most`: a coefficient of the
    push, or a force in N or N m. One that `slides` has this part of the push along each tangent."""

    push: int
    tangents: tuple[int, ...] = ()
    most: float = 0.0
    slides: tuple[float, ...] = ()


def contact_problem(B: Array, b: Array, cones: Sequence[Cone], give: float = 0.0) -> Array | None:
    """The forces y (n,) along all rows, with which no row that is held accelerates: pushes, and tangents that stick.
    None where no forces within the cones do that. Raises InputError without a kernel.

    B (n, n) is symmetric. `give` is a compliance in 1/kg of each row; where it is positive there always are forces."""
    y: Array | None = law().contact_problem(thresholds(), numbers(B), numbers(b), list(cones), give)
    return y


def law() -> ModuleType:
    """The kernel, which holds the laws of contacts and dry friction. Raises InputError where there is no kernel."""
    kernel = core()
    if kernel is None:
        hint = "install mbproj where a C++ compiler is, as 'mbproj help install it' says"
        raise InputError(Problem("dry friction and contacts that share a load need the compiled kernel", hint=hint))
    return kernel


def thresholds() -> Any:
    """The thresholds of the kernel's laws."""
    return law().Thresholds(of_the_kernel())


def numbers(values: Array) -> Array:
    """The values as contiguous floats, as the kernel takes them."""
    return np.ascontiguousarray(values, dtype=float)


def independent(B: Array, rows: Integers) -> Integers:
    """A largest set of independent rows among these `rows` of B, in ascending order. Cholesky's method with pivots
    chooses them, the most independent row first."""
    left = B[np.ix_(rows, rows)].copy()
    size, chosen = np.diagonal(left).copy(), list[int]()
    while True:
        part = np.diagonal(left) / np.where(size > 0.0, size, 1.0)
        best = int(np.argmax(part)) if len(part) else 0
        if not len(part) or part[best] <= THRESHOLDS.no_push:
            return np.sort(rows[chosen])
        chosen.append(best)
        left -= np.outer(left[:, best], left[best]) / left[best, best]
