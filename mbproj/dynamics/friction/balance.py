"""The forces of stops that touch and of dry frictions at one state, and which of them hold, open or slide from there.
As much sticks as can. The law is the kernel's, in kernel/src/laws/friction_balance.hpp.

With x in coordinates in which the kinetic energy is ½|x|², forces y along rows A change accelerations b to b + A Aᵀy.
A stop pushes, y >= 0, or opens; a friction at rest holds, s'' = 0, with |y| up to its static force, or slides against
it; one that slides has its sliding force. Forces may go by what bearings carry, which is linear in y.
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
    """S stops that touch and K frictions: rows A (S+K, f) and accelerations b (S+K,) without them. Arrays (K,) of the
    frictions: `static` and `sliding` force, to be multiplied by `loads(y)`; the `direction` in which each slides, 0 at
    rest; the `partner` with which it acts in a plane; the number of the `stop` whose push is its load; -1 for none. One
    that nothing can move begins to slide where its acceleration is larger than `still`."""

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
        """S."""
        return len(self.b) - len(self.static)

    @cached_property
    def able(self) -> Flags:
        """Which rows something can move along, (S+K,)."""
        size = np.linalg.norm(self.A, axis=1)
        return np.asarray(size > THRESHOLDS.no_push * size.max(initial=0.0))

    @cached_property
    def rests(self) -> Flags:
        """Which frictions are at rest, those in a plane together, (K,)."""
        across = np.where(self.partner >= 0, self.direction[self.partner], 0.0)
        return np.asarray(np.hypot(self.direction, across) == 0.0)

    def accelerations(self, y: Array) -> Array:
        """Along all rows, (S+K,)."""
        return np.asarray(self.b + self.A @ (self.A.T @ y))

    def of_kernel(self) -> Any:
        """The same as the kernel has it. Raises InputError without a kernel."""
        B, still = self.A @ self.A.T, np.zeros(len(self.static)) + self.still
        each = [numbers(of) for of in (self.static, self.sliding, self.direction, still)]
        places = self.stop.tolist(), self.partner.tolist(), self.able.tolist()
        return law().FrictionBalance(numbers(B), numbers(self.b), each, *places, self._loads)

    def _loads(self, y: Array) -> Array:
        return numbers(self.loads(y))


@dataclass(frozen=True, eq=False)
class Balanced:
    """The forces y (S+K,); arrays (K,) of the frictions: which are `stuck`, each by a row of its own; the `direction`
    in which each slides, 0 at rest; and the `part` of its static force that one bears which others hold. `shares`: how
    the stops that touch share their pushes, None where each has a row of its own."""

    y: Array
    stuck: Flags
    direction: Array
    part: Array
    shares: Shares | None = None


class NoFrictionBalance(Exception):
    """No forces were found that fulfil all conditions: the numbers of frictions at rest that are part of it."""

    def __init__(self, frictions: Integers) -> None:
        super().__init__("no balance")
        self.frictions = frictions


def balanced(problem: FrictionBalance) -> Balanced:
    """What holds, and what slides from now on: as much sticks as can. Raises NoFrictionBalance."""
    y, direction, *more = problem.of_kernel().decide(thresholds())
    if y is None:
        across = np.where(problem.partner >= 0, direction[problem.partner], 0.0)
        raise NoFrictionBalance(np.flatnonzero(np.hypot(direction, across) == 0.0))
    stuck, part, shares = more
    return Balanced(y, np.array(stuck, dtype=bool), direction, part, shares_from(shares))


def forces(problem: FrictionBalance) -> Array | None:
    """y where frictions at rest hold if they can all, and else up to their static force; None where there is none."""
    found: Array | None = problem.of_kernel().forces(thresholds())
    return found
