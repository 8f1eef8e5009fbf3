"""GPOPM by the Moore-Penrose inverse of the bordered matrix (Eqs. 62-66)."""

from __future__ import annotations

from typing import final

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.projection.methods.method import Projection


@final
@dataclass(frozen=True)
class GpopmPinv(Projection):
    """Eqs. 65-66. Eq. 63 as printed, (DᵀD)⁻¹Dᵀ, does not exist because D = EME is singular. Its Moore-Penrose inverse
    is computed here from its eigenvalues; those of the admissible motions, 7n - m of them, differ from zero."""

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 65 and 66, -(C_q⁺ - P M C_q⁺) violation with P = D⁺. Raises LinAlgError where
        the rank of D is too small."""
        C_plus = np.linalg.solve(C_q @ C_q.T, C_q).T
        E = np.eye(len(M)) - C_plus @ C_q
        geometric = C_plus @ violation
        return _pseudo_inverse(E @ M @ E, len(M) - len(C_q)) @ (M @ geometric) - geometric


def _pseudo_inverse(D: Array, rank: int) -> Array:
    """Return D⁺ of a symmetric semi-definite D of known `rank`, which is checked against the eigenvalues."""
    eigenvalues, vectors = np.linalg.eigh(0.5 * (D + D.T))
    kept, V = eigenvalues[len(D) - rank :], vectors[:, len(D) - rank :]
    if rank and kept[0] <= len(D) * np.finfo(float).eps * kept[-1]:
        raise np.linalg.LinAlgError("D = EME has a smaller rank than the degrees of freedom (Eq. 20 does not hold)")
    return (V / kept) @ V.T


METHOD = GpopmPinv
