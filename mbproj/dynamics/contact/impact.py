"""Impacts: what velocities jump to where stops are struck, by one of three laws of restitution.

No stop pulls, and none is passed. Rows of joints and motions keep their velocities.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.contact.complementarity import one_sided
from mbproj.dynamics.contact.freedom import Freedom
from mbproj.dynamics.contact.impulse_path import followed
from mbproj.dynamics.friction.balance import Balance, forces
from mbproj.dynamics.friction.problem import Cone, contact_problem, independent
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class Impact:
    """q' after (7n,); of each stop its impulse, N s or N m s, and the energy that it takes, J, (k,); the energy that is
    lost in the stops, and the work that motions do, which keep their speeds, J. `rubbed`: of what is lost the part of
    frictions, by their numbers."""

    v: Array
    impulse: Array
    taken: Array
    lost: float
    work: float
    rubbed: tuple[Integers, Array]


@dataclass(frozen=True, eq=False)
class Rubbing:
    """Friction along tangents of stops that touch: rows T (k, f), rates before (k,), the coefficient of each, the other
    tangent of its plane. `stop` is the number of its stop among those that touch, `friction` its own among all
    frictions, (k,) each."""

    T: Array
    rate: Array
    coefficient: Array
    partner: Integers
    by: Integers
    numbers: Integers

    @classmethod
    def none(cls, freedom: int) -> Rubbing:
        """Of smooth stops."""
        numbers = np.zeros(0, dtype=np.intp)
        return cls(np.zeros((0, freedom)), np.zeros(0), np.zeros(0), numbers, numbers, numbers)


@dataclass(frozen=True, eq=False)
class Struck:
    """Stops that touch: rows N (k, f), rates of the gaps before (k,), restitutions (k,), and their friction."""

    freedom: Freedom
    N: Array
    rate: Array
    restitution: Array
    rubbing: Rubbing

    @property
    def A(self) -> Array:
        """The rows of stops and frictions, (k + K, f)."""
        return np.vstack([self.N, self.rubbing.T])

    @property
    def rates(self) -> Array:
        """Before, along all rows, (k + K,)."""
        return np.concatenate([self.rate, self.rubbing.rate])

    def impulses(self, b: Array, given: Array | float = 0.0) -> Array | None:
        """The impulses y (k + K,) that change rates b to what the joints allow: those of stops push, or leave the stop,
        and those of frictions are within the cones of these pushes and of those `given` (k,) before."""
        if not len(self.rubbing.rate):
            return one_sided(self.N, b)
        rubbing, before = self.rubbing, np.zeros(len(self.rate)) + given
        problem = Balance(
            A=self.A,
            b=b,
            static=rubbing.coefficient,
            sliding=rubbing.coefficient,
            direction=np.zeros(len(rubbing.rate)),
            partner=rubbing.partner,
            stop=rubbing.by,
            loads=lambda y: (y[: len(before)] + before)[rubbing.by],
        )
        return forces(problem)

    def done(self, v: Array, impulse: Array, work: Array) -> Impact:
        """The impact by impulses that do so much work on the mechanism, (k + K,) each."""
        k, x = len(self.rate), self.A.T @ impulse
        given = float(0.5 * x @ x + impulse @ self.rates)
        return Impact(
            v + self.freedom.changed(x),
            impulse[:k],
            -work[:k],
            -given,
            self.freedom.gained(x) - given,
            (self.rubbing.numbers, -work[k:]),
        )


def newton(struck: Struck, v: Array) -> Impact | None:
    """Of each stop that is struck the speed after is -e times that before, or more where it is left; one that is left
    keeps its speed. As far as friction allows, nothing slides after (Glocker and Pfeiffer 1995). None where nothing
    that the joints allow opens the gaps: a motion drives into a stop."""
    b = struck.rates
    k = len(struck.rate)
    b[:k] = np.where(struck.rate < 0.0, (1.0 + struck.restitution) * struck.rate, struck.rate)
    y = struck.impulses(b)
    return None if y is None else struck.done(v, y, _work(struck, struck.rates, y))


def poisson(struck: Struck, v: Array) -> Impact | None:
    """Compression until no gap closes; then each stop pushes at least with e times its impulse of compression (Glocker
    and Pfeiffer 1995). None as above."""
    k, before = len(struck.rate), struck.rates
    compression = struck.impulses(before)
    if compression is None:
        return None
    between = before + struck.A @ (struck.A.T @ compression)
    least = struck.restitution * compression[:k]
    more = struck.impulses(between + struck.A @ (struck.N.T @ least), least)
    if more is None:
        return None
    expansion = more + np.append(least, np.zeros(len(more) - k))
    work = _work(struck, before, compression) + _work(struck, between, expansion)
    return struck.done(v, compression + expansion, work)


def energetic(struck: Struck, v: Array) -> Impact | None:
    """One stop gives back e² of the energy that it takes until its gap closes no more (Stronge 1990). None as above.
    Others that touch are left alone: who calls sees whether that may be."""
    first = int(np.argmin(struck.rate))
    rows = np.append(first, len(struck.rate) + np.flatnonzero(struck.rubbing.by == first))
    A, e = struck.A[rows], float(struck.restitution[first])
    if not A[0].any():
        return None
    coefficient = float(struck.rubbing.coefficient[rows[1] - len(struck.rate)]) if len(rows) > 1 else 0.0
    found = followed(A @ A.T, struck.rates[rows], coefficient, e)
    if found is None:
        return None
    impulse, work = np.zeros((2, len(struck.rates)))
    impulse[rows], work[rows] = found.impulse, found.work
    return struck.done(v, impulse, work)


def _work(struck: Struck, rates: Array, y: Array) -> Array:
    """What impulses do from these rates on, J (k + K,): each works at the mean of the speeds before and after."""
    return np.asarray(y * (rates + 0.5 * (struck.A @ (struck.A.T @ y))))


#: What restitution is of: the speeds, the impulses, or the energy.
LAWS: Mapping[str, Callable[[Struck, Array], Impact | None]] = MappingProxyType(
    {"newton": newton, "poisson": poisson, "energetic": energetic}
)


def contact_pushes(N: Array, acceleration: Array) -> Array | None:
    """The forces (k,) of stops that touch and stay, from what their gaps' accelerations (k,) would be without: none
    pulls, and one that pushes keeps its gap. None where nothing opens the gaps. Where rows depend on each other they
    share as springs of one stiffness do."""
    z, B = one_sided(N, acceleration), N @ N.T
    if z is None:
        return None
    left = np.abs(acceleration + B @ z) <= THRESHOLDS.no_push * np.abs(acceleration).max(initial=0.0)
    stay = np.flatnonzero(left & (np.diagonal(B) > 0.0))
    if len(independent(B, stay)) < len(stay):
        y = contact_problem(B[np.ix_(stay, stay)], acceleration[stay], [Cone(at) for at in range(len(stay))])
        z[stay] = z[stay] if y is None else y
    return z
