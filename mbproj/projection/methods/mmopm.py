"""MMOPM, the modified mass-orthogonal projection (Eqs. 56-61): weighted by M + α C_qᵀC_q with a large α."""

from __future__ import annotations

from typing import final

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.projection.methods.method import Projection, weighted_correction


@final
@dataclass(frozen=True)
class Mmopm(Projection):
    """Penalty factor `alpha`, 1e7 in the paper. By Eq. 78 the result does not depend on it; the round-off does."""

    alpha: float

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 60 and 61, with A_α of Eq. 53."""
        return weighted_correction(M + self.alpha * (C_q.T @ C_q), C_q, violation)


METHOD = Mmopm
