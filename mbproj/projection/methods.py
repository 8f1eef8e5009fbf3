"""The paper's projection methods: the correction of each, in the order of its equations.

A method keeps C = 0 and C' = 0 while an ordinary integrator runs. A new one is a class here and an entry of
`mbproj.registry.PROJECTIONS`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, final

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass


class Method(ABC):
    """A way to suppress the violation of the constraints. Its options are the fields of the final classes."""

    #: Whether the accelerations need C and C', as in Baumgarte's method.
    stabilises: ClassVar[bool] = False

    @abstractmethod
    def stabilised(self, gamma: Array, C: Array, C_dot: Array) -> Array:
        """Return γ (m,) with this method's terms in the violations C and C' (m,): unchanged unless the method
        `stabilises`."""


class Projection(Method):
    """A method that moves a violating state back to the constraints after a step: Eqs. 39-74."""

    #: Whether the velocity correction removes the violation only in the limit (a penalty), so that it is iterated.
    iterates_velocity: ClassVar[bool] = False

    @final
    def stabilised(self, gamma: Array, C: Array, C_dot: Array) -> Array:
        return gamma

    @abstractmethod
    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return Δ (7n,) with C_q Δ = -violation, the smallest in this method's metric, from M (7n, 7n), C_q (m, 7n).

        The same formula corrects q (violation C) and q' (violation C'). Raises LinAlgError where it does not exist.
        """

    def refusal(self, M: Array) -> str | None:
        """Return why this method cannot be used with the mass matrix M, and which can; None where it can."""
        return None


def weighted_correction(A: Array, C_q: Array, violation: Array) -> Array:
    """Return -A⁻¹C_qᵀ (C_q A⁻¹ C_qᵀ)⁻¹ violation, Eq. 28: the smallest Δ in the norm of A with C_q Δ = -violation."""
    X = np.linalg.solve(A, C_q.T)
    return -X @ np.linalg.solve(C_q @ X, violation)


@final
@dataclass(frozen=True)
class Unprojected(Method):
    """Direct integration of Eq. 14, in which the constraints drift. It is there to show the drift."""

    def stabilised(self, gamma: Array, C: Array, C_dot: Array) -> Array:
        return gamma


@final
@dataclass(frozen=True)
class Baumgarte(Method):
    """Baumgarte's stabilisation (ref. 9): C'' + 2αC' + β²C = 0 in place of C'' = 0. `gains` (α, β) in 1/s; the paper
    takes 25 for both. Critically damped where α = β."""

    gains: tuple[float, float]

    stabilises = True

    def stabilised(self, gamma: Array, C: Array, C_dot: Array) -> Array:
        alpha, beta = self.gains
        return gamma - 2.0 * alpha * C_dot - beta**2 * C


@final
@dataclass(frozen=True)
class Gopm(Projection):
    """GOPM, the geometrical orthogonal projection (Eqs. 37-41): the smallest correction of the coordinates, A = I.
    Metres and Euler parameters are summed as they stand: the result depends on the unit of length."""

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 39 and 41."""
        return -C_q.T @ np.linalg.solve(C_q @ C_q.T, violation)


@final
@dataclass(frozen=True)
class Popm(Projection):
    """POPM, the physical orthogonal projection (Eqs. 42-45): weighted by M, which must be positive definite."""

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


@final
@dataclass(frozen=True)
class MassOrthogonal(Projection):
    """The mass-orthogonal projection of Bayo and Ledesma as Blajer writes it (Eqs. 48-55). Penalty factor `alpha`, 1e7
    in ref. 28. A pass leaves of order 1/α of the violation, so both levels iterate."""

    alpha: float

    iterates_velocity: ClassVar[bool] = True

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 52 and 55, with A_α of Eq. 53."""
        A_alpha = M + self.alpha * (C_q.T @ C_q)
        return np.linalg.solve(A_alpha, -self.alpha * (C_q.T @ violation))


@final
@dataclass(frozen=True)
class Mmopm(Projection):
    """MMOPM, the modified mass-orthogonal projection (Eqs. 56-61): weighted by M + α C_qᵀC_q. Penalty factor `alpha`,
    1e7 in the paper. By Eq. 78 the result does not depend on it; the round-off does."""

    alpha: float

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 60 and 61, with A_α of Eq. 53."""
        return weighted_correction(M + self.alpha * (C_q.T @ C_q), C_q, violation)


@final
@dataclass(frozen=True)
class GpopmPinv(Projection):
    """GPOPM by the Moore-Penrose inverse of the bordered matrix (Eqs. 62-66).

    Eq. 63 as printed, (DᵀD)⁻¹Dᵀ, does not exist because D = EME is singular. Its Moore-Penrose inverse is computed here
    from its eigenvalues; those of the admissible motions, 7n - m of them, differ from zero."""

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


@final
@dataclass(frozen=True)
class Gpopm(Projection):
    """GPOPM, the generalised physical orthogonal projection (Eqs. 67-74): the smallest correction in the energy norm
    ΔᵀMΔ, though M is singular. It exists where Eq. 20 holds and C_q has full rank."""

    def correction(self, M: Array, C_q: Array, violation: Array) -> Array:
        """Return the correction of Eqs. 73 and 74, with A1 of Eq. 72."""
        return weighted_correction(M + C_q.T @ C_q, C_q, violation)
