"""GPOPM, the generalised physical orthogonal projection (Eqs. 67-74): weighted by M though M is singular."""

from __future__ import annotations

from typing import final

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.projection.methods.method import Projection, weighted_correction


@final
@dataclass(frozen=True)
class Gpopm(Projection):
    """The smallest correction in the energy norm ΔᵀMΔ; exists where Eq. 20 holds and C_q has full rank."""

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 73 and 74, with A1 of Eq. 72."""
        return weighted_correction(M + C_q.T @ C_q, C_q, violation)


METHOD = Gpopm
