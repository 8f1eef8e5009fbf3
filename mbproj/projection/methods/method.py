"""The interface of projection methods, which keep C = 0 and C' = 0 while an ordinary integrator runs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, final

import numpy as np

from mbproj.arrays import Array


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
