"""Impacts: what velocities jump to where stops are struck (Newton's restitution, on the constraints).

Of each stop that touches, the speed after is at least -e times that before, and its push is not negative; where it
pushes, the speed is just that (Glocker & Pfeiffer 1995). Rows of joints and motions keep their velocities.
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.contact.complementarity import one_sided
from mbproj.dynamics.contact.freedom import Freedom


@dataclass(frozen=True, eq=False)
class Impact:
    """q' after (7n,), the impulse of each stop (k,) in N s or N m s, the energy that is lost in the stops, and the work
    that motions do, which keep their speeds, J."""

    v: Array
    impulse: Array
    lost: float
    work: float


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


def contact_pushes(N: Array, acceleration: Array) -> Array | None:
    """The forces (k,) of stops that touch and stay, from what their gaps' accelerations (k,) would be without: none
    pulls, and one that pushes keeps its gap. None where nothing opens the gaps."""
    return one_sided(N, acceleration)
