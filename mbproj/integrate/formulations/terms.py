"""The terms of Eq. 14 at a state, in the rows that are held there, and the accelerations that follow from its
solution."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.independent_rows import HeldRows


class Accelerations(NamedTuple):
    """q'' (7n,), λ (m,), and the `power` in W of forces and motions, of dampers, and of separate losses of laws, (2 +
    apart,); empty without any.

    `nearness`: the pose's distance from a singular one, as a part of the largest of the run."""

    acceleration: Array
    multipliers: Array
    power: Array
    nearness: float


@dataclass(frozen=True, eq=False)
class Terms:
    """M, C_q, Q and γ; each reflected inertia has a coordinate and a row of its own after those of `held`. `lasting`
    (m,): multipliers of combinations that are not held. `power` (2,) of forces, and the rates of motions, `driven`."""

    M: Array
    C_q: Array
    Q: Array
    gamma: Array
    held: HeldRows
    lasting: Array
    power: Array
    driven: Array

    def solved(self, acceleration: Array, multipliers: Array) -> Accelerations:
        """Return the accelerations and the multipliers of all rows for a solution of Eq. 14 in these terms."""
        rows, size = self.held.C_q.shape
        spread = self.held.multipliers(multipliers[:rows]) + self.lasting
        power = self.power
        if len(self.driven):
            power = power - np.append(spread[-len(self.driven) :] @ self.driven, np.zeros(len(power) - 1))
        return Accelerations(acceleration[:size], spread, power, self.held.nearness)
