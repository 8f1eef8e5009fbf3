"""Numbers with a bound on their round-off, carried along through a formula: a running error analysis.

To first order in ε, componentwise (Higham, Accuracy and Stability of Numerical Algorithms, 2002: Eq. 3.13 for
products, Theorem 9.4 for Gaussian elimination with partial pivoting). No constant is chosen: the bounds follow from the
computation, with its condition and scale.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.linalg import lu

from mbproj.arrays import Array
from mbproj.dataclass import dataclass

EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class Rounded:
    """A computed vector or matrix, and a componentwise bound on its difference from the exact result."""

    value: Array
    error: Array

    @classmethod
    def exact(cls, value: Array) -> Rounded:
        """Take numbers as exact: their error is zero."""
        return cls(value, np.zeros_like(value))

    @property
    def T(self) -> Rounded:
        """The transpose."""
        return Rounded(self.value.T, self.error.T)

    def __neg__(self) -> Rounded:
        return Rounded(-self.value, self.error)

    def __add__(self, other: Rounded) -> Rounded:
        total: Array = self.value + other.value
        return Rounded(total, self.error + other.error + EPS * np.abs(total))

    def __sub__(self, other: Rounded) -> Rounded:
        return self + (-other)

    def __matmul__(self, other: Rounded) -> Rounded:
        left, right = np.abs(self.value), np.abs(other.value)
        inherited = self.error @ right + left @ other.error
        own: Array = self.value.shape[-1] * EPS * (left @ right)
        return Rounded(self.value @ other.value, inherited + own)

    def __getitem__(self, index: Any) -> Rounded:
        return Rounded(self.value[index], self.error[index])


def product(factor: float, given: Rounded) -> Rounded:
    """The product factor · x of a number and a vector or matrix."""
    value: Array = factor * given.value
    error: Array = abs(factor) * given.error + EPS * np.abs(value)
    return Rounded(value, error)


def solve(A: Rounded, b: Rounded) -> Rounded:
    """A⁻¹ b by Gaussian elimination: |δx| <= |A⁻¹| (|δA| |x| + |δb| + n ε |L| |U| |x|). Raises LinAlgError."""
    x = np.linalg.solve(A.value, b.value)
    P, L, U = lu(A.value)
    grown = P @ (np.abs(L) @ np.abs(U))
    residual = (A.error + len(A.value) * EPS * grown) @ np.abs(x) + b.error
    return Rounded(np.asarray(x), np.asarray(np.abs(np.linalg.inv(A.value)) @ residual))


def concatenated(*parts: Rounded) -> Rounded:
    """The vectors `parts`, one after another."""
    return Rounded(np.concatenate([part.value for part in parts]), np.concatenate([part.error for part in parts]))


def bordered(A: Rounded, C: Rounded) -> Rounded:
    """The block matrix [[A, Cᵀ], [C, 0]]."""
    none = np.zeros((len(C.value), len(C.value)))
    return Rounded(np.block([[A.value, C.value.T], [C.value, none]]), np.block([[A.error, C.error.T], [C.error, none]]))
