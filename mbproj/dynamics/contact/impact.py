"""Impacts: the jump of velocities where stops are struck, by one of three laws of restitution.

No stop pulls, and none is passed. The rates of the joints' and motions' rows do not change.
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
from mbproj.dynamics.friction.balance import FrictionBalance, forces
from mbproj.dynamics.friction.problem import Cone, contact_problem, independent
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class Impact:
    """The result of an impact. `v`: q' after it (7n,). `impulse` (k,) of each stop in N s or N m s, and `taken` (k,),
    the energy that each stop absorbs, in J. `lost`: the energy lost in stops, in J. `work`: the work of motions, which
    keep their speeds, in J. `rubbed`: the numbers of frictions and the part of the loss in each."""

    v: Array
    impulse: Array
    taken: Array
    lost: float
    work: float
    rubbed: tuple[Integers, Array]


@dataclass(frozen=True, eq=False)
class Rubbing:
    """Friction along tangents of stops that touch.

    Rows `T` (k, f), rates before the impact (k,), and coefficients (k,). `partner` (k,): the friction along the other
    tangent of the plane. `by` (k,): the number of its stop among those that touch. `numbers` (k,): its own number among
    all frictions."""

    T: Array
    rate: Array
    coefficient: Array
    partner: Integers
    by: Integers
    numbers: Integers

    @classmethod
    def none(cls, freedom: int) -> Rubbing:
        """Return the friction of smooth stops, which is none."""
        numbers = np.zeros(0, dtype=np.intp)
        return cls(np.zeros((0, freedom)), np.zeros(0), np.zeros(0), numbers, numbers, numbers)


@dataclass(frozen=True, eq=False)
class Struck:
    """Stops that touch: rows N (k, f), rates of the gaps before the impact (k,), restitutions (k,), and their
    friction."""

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
        """The rates along all rows before the impact, (k + K,)."""
        return np.concatenate([self.rate, self.rubbing.rate])

    def impulses(self, b: Array, given: Array | float = 0.0) -> Array | None:
        """Return the impulses y (k + K,) that change the rates b to admissible ones; None where there are none.

        Stops push, or are left. Impulses of frictions are within the cones of these pushes plus the pushes `given` (k,)
        before."""
        if not len(self.rubbing.rate):
            return one_sided(self.N, b)
        rubbing, before = self.rubbing, np.zeros(len(self.rate)) + given
        problem = FrictionBalance(
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
        """Return the impact with these impulses, which do this `work` on the mechanism, (k + K,) each."""
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
    """Newton's law: the speed of each struck stop after is -e times that before, or more where the stop is left.

    A stop that is being left keeps its speed. As far as friction allows, nothing slides afterwards (Glocker and
    Pfeiffer 1995). Returns None where no admissible change opens the gaps: a motion drives into a stop."""
    b = struck.rates
    k = len(struck.rate)
    b[:k] = np.where(struck.rate < 0.0, (1.0 + struck.restitution) * struck.rate, struck.rate)
    y = struck.impulses(b)
    return None if y is None else struck.done(v, y, _work(struck, struck.rates, y))


def poisson(struck: Struck, v: Array) -> Impact | None:
    """Poisson's law: compression until no gap closes; then each stop pushes with at least e times its impulse of
    compression (Glocker and Pfeiffer 1995). Returns None where no admissible change opens the gaps."""
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
    """Stronge's law (1990): one stop returns e² of the energy that it absorbs until its gap stops closing.

    Returns None where no admissible change opens the gap. Other stops that touch get no impulse: the caller checks
    whether that is admissible."""
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
    """Return the work of impulses y from these rates on, J (k + K,): impulse times the mean of the speeds before and
    after."""
    return np.asarray(y * (rates + 0.5 * (struck.A @ (struck.A.T @ y))))


#: The laws of impact, by name: restitution relates the speeds, the impulses, or the energies.
LAWS: Mapping[str, Callable[[Struck, Array], Impact | None]] = MappingProxyType(
    {"newton": newton, "poisson": poisson, "energetic": energetic}
)


def contact_pushes(N: Array, acceleration: Array) -> Array | None:
    """Return the forces (k,) of stops in resting contact; None where no pushes keep the gaps open.

    `acceleration` (k,) are the gaps' accelerations without these forces. No stop pulls, and a stop that pushes keeps
    its gap closed. Where rows depend on each other the stops share as springs of equal stiffness do."""
    z, B = one_sided(N, acceleration), N @ N.T
    if z is None:
        return None
    left = np.abs(acceleration + B @ z) <= THRESHOLDS.no_push * np.abs(acceleration).max(initial=0.0)
    stay = np.flatnonzero(left & (np.diagonal(B) > 0.0))
    if len(independent(B, stay)) < len(stay):
        y = contact_problem(B[np.ix_(stay, stay)], acceleration[stay], [Cone(at) for at in range(len(stay))])
        z[stay] = z[stay] if y is None else y
    return z
