"""Impacts: what velocities jump to where stops are struck (Newton's restitution, on the constraints).

Of each stop that touches, the speed after is at least -e times that before, and its push is not negative; where it
pushes, the speed is just that (Glocker & Pfeiffer 1995). Rows of joints and motions keep their velocities.
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.contact.complementarity import one_sided
from mbproj.dynamics.contact.freedom import Freedom
from mbproj.dynamics.friction.balance import Balance, forces
from mbproj.dynamics.friction.problem import Cone, contact_problem, independent
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class Impact:
    """q' after (7n,), the impulse of each stop (k,) in N s or N m s, the energy that is lost in the stops, and the work
    that motions do, which keep their speeds, J. `rubbed`: of what is lost
    the part of frictions, by their numbers."""

    v: Array
    impulse: Array
    lost: float
    work: float
    rubbed: tuple[Integers, Array] | None = None


def impact(freedom: Freedom, v: Array, N: Array, rate: Array, restitution: Array) -> Impact | None:
    """At stops that touch, with rows N (k, f), gap rates before (k,) and restitutions (k,); one that is left keeps its
    speed. None where nothing that the joints allow opens the gaps: a motion drives into a stop."""
    b = np.where(rate < 0.0, (1.0 + restitution) * rate, rate)
    z = one_sided(N, b)
    if z is None:
        return None
    x = N.T @ z
    given = float(0.5 * x @ x + z @ rate)  # each impulse works at the mean of the speeds before and after
    return Impact(v + freedom.changed(x), z, -given, freedom.gained(x) - given)


def impact_with_friction(
    freedom: Freedom, v: Array, N: Array, rate: Array, restitution: Array, rubbing: Rubbing
) -> Impact | None:
    """The same at stops with friction: impulses along their tangents are within the cone of Coulomb, and as far as
    that allows nothing slides after."""
    b = np.concatenate([np.where(rate < 0.0, (1.0 + restitution) * rate, rate), rubbing.rate])
    A = np.vstack([N, rubbing.T])
    problem = Balance(
        A=A,
        b=b,
        static=rubbing.coefficient,
        sliding=rubbing.coefficient,
        direction=np.zeros(len(rubbing.rate)),
        partner=rubbing.partner,
        stop=rubbing.by,
        loads=lambda y: y[rubbing.by],
    )
    y = forces(problem)
    if y is None:
        return None
    x = A.T @ y
    given = float(0.5 * x @ x + y @ np.concatenate([rate, rubbing.rate]))
    taken = -y[len(rate) :] * (rubbing.rate + 0.5 * (rubbing.T @ x))
    return Impact(v + freedom.changed(x), y[: len(rate)], -given, freedom.gained(x) - given, (rubbing.numbers, taken))


@dataclass(frozen=True, eq=False)
class Rubbing:
    """Friction along tangents of stops that touch: rows T (k, f), rates before (k,), the coefficient of each, the other
    tangent of its plane, the number of its stop among those that touch, and its own of all frictions, (k,) each."""

    T: Array
    rate: Array
    coefficient: Array
    partner: Integers
    by: Integers
    numbers: Integers


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
