"""GOPM, the geometrical orthogonal projection (Eqs. 37-41): the smallest correction of the coordinates themselves."""

from __future__ import annotations

from typing import final

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.projection.methods.method import Projection


@final
@dataclass(frozen=True)
class Gopm(Projection):
    """Weight A = I. Metres and Euler parameters are summed as they stand: the result depends on the unit of length."""

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 39 and 41."""
        return -C_q.T @ np.linalg.solve(C_q @ C_q.T, violation)


METHOD = Gopm
