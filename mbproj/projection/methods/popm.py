"""POPM, the physical orthogonal projection (Eqs. 42-45): weighted by M, which must be positive definite."""

from __future__ import annotations

from typing import final

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.projection.methods.method import Projection, weighted_correction


@final
@dataclass(frozen=True)
class Popm(Projection):
    """Weight A = M."""

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 44 and 45."""
        return weighted_correction(M, C_q, violation)

    def refusal(self, M: Array) -> str | None:
        eigenvalues = np.linalg.eigvalsh(M)
        if eigenvalues[0] > len(M) * np.finfo(float).eps * eigenvalues[-1]:
            return None
        return (
            "'popm' needs a positive definite mass matrix, and with Euler parameters M is singular (Eq. 12); "
            "use 'gpopm': it is the physical correction for singular M, and equals 'popm' where M is definite (Eq. 75)"
        )


METHOD = Popm
