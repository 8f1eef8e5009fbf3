"""The forces of stops that touch and of dry frictions at one state, and which of them hold, open or slide from there.
As many frictions stick as can. The law is the kernel's, in kernel/src/laws/friction_balance.hpp.

The coordinates are such that the kinetic energy is half the sum of the squared speeds. Forces y along rows A change the
accelerations b along these rows to b + A Aᵀy. A stop pushes, y >= 0, or opens. A friction at rest holds, s'' = 0, with
|y| up to its static force, or begins to slide against that force. A friction that slides has its sliding force. These
forces may be proportional to the loads of bearings, which are linear in y.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.friction.problem import law, numbers, thresholds
from mbproj.dynamics.friction.shares import Shares, shares_from
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class FrictionBalance:
    """S stops that touch and K frictions: their rows A (S+K, f), and the accelerations b (S+K,) without their forces.

    Arrays (K,) of the frictions: the `static` and `sliding` force, both to be multiplied by `loads(y)`; the `direction`
    in which each slides, 0 at rest. `partner` is the other friction of the same plane, `stop` the stop whose push is
    the load; -1 for none. A row along which no force can accelerate anything begins to slide where its acceleration is
    larger than `still`."""

    A: Array
    b: Array
    static: Array
    sliding: Array
    direction: Array
    partner: Integers
    stop: Integers
    loads: Callable[[Array], Array]
    still: Array | float = 0.0

    @property
    def stops(self) -> int:
        """The number S of stops."""
        return len(self.b) - len(self.static)

    @cached_property
    def able(self) -> Flags:
        """Whether forces can accelerate something along each row, (S+K,)."""
        size = np.linalg.norm(self.A, axis=1)
        return np.asarray(size > THRESHOLDS.no_push * size.max(initial=0.0))

    @cached_property
    def rests(self) -> Flags:
        """Whether each friction is at rest, (K,). The two frictions of a plane rest together."""
        across = np.where(self.partner >= 0, self.direction[self.partner], 0.0)
        return np.asarray(np.hypot(self.direction, across) == 0.0)

    def accelerations(self, y: Array) -> Array:
        """The accelerations along all rows under the forces y, (S+K,)."""
        return np.asarray(self.b + self.A @ (self.A.T @ y))

    def of_kernel(self) -> Any:
        """The kernel's object with these values. Raises InputError without a kernel."""
        B, still = self.A @ self.A.T, np.zeros(len(self.static)) + self.still
        values = [numbers(array) for array in (self.static, self.sliding, self.direction, still)]
        places = self.stop.tolist(), self.partner.tolist(), self.able.tolist()
        return law().FrictionBalance(numbers(B), numbers(self.b), values, *places, self._loads)

    def _loads(self, y: Array) -> Array:
        return numbers(self.loads(y))


@dataclass(frozen=True, eq=False)
class Balanced:
    """The forces y (S+K,), and arrays (K,) of the frictions: which are `stuck`, each held by a row of its own; the
    `direction` in which each slides, 0 at rest. A friction whose row depends on other stuck rows has no row of its own:
    it bears this `part` of its static force. `shares`: how the stops that touch share their pushes; None where each has
    a row of its own."""

    y: Array
    stuck: Flags
    direction: Array
    part: Array
    shares: Shares | None = None


class NoFrictionBalance(Exception):
    """No forces were found that fulfil all conditions. `frictions`: the numbers of the frictions at rest."""

    def __init__(self, frictions: Integers) -> None:
        super().__init__("no balance")
        self.frictions = frictions


def balanced(problem: FrictionBalance) -> Balanced:
    """The balance in which as many frictions stick as can. Raises NoFrictionBalance."""
    y, direction, *more = problem.of_kernel().decide(thresholds())
    if y is None:
        across = np.where(problem.partner >= 0, direction[problem.partner], 0.0)
        raise NoFrictionBalance(np.flatnonzero(np.hypot(direction, across) == 0.0))
    stuck, part, shares = more
    return Balanced(y, np.array(stuck, dtype=bool), direction, part, shares_from(shares))


def forces(problem: FrictionBalance) -> Array | None:
    """The forces y (S+K,) that hold all frictions at rest, or, where they cannot, are at most their static forces. None
    where there are no such forces."""
    y: Array | None = problem.of_kernel().forces(thresholds())
    return y
