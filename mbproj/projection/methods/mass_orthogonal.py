"""The mass-orthogonal projection of Bayo and Ledesma as Blajer writes it (Eqs. 48-55): a penalty α on the violation."""

from __future__ import annotations

from typing import ClassVar, final

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.projection.methods.method import Projection


@final
@dataclass(frozen=True)
class MassOrthogonal(Projection):
    """Penalty factor `alpha`, 1e7 in ref. 28. A pass leaves of order 1/α of the violation, so both levels iterate."""

    alpha: float

    iterates_velocity: ClassVar[bool] = True

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 52 and 55, with A_α of Eq. 53."""
        A_alpha = M + self.alpha * (C_q.T @ C_q)
        return np.linalg.solve(A_alpha, -self.alpha * (C_q.T @ violation))


METHOD = MassOrthogonal
