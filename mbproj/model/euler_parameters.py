"""Euler parameters Λ = (Λ0, Λ1, Λ2, Λ3), scalar first, body to global; leading axes are free.

A(Λ) = E Lᵀ is quadratic in Λ, so that for any Λ, unit or not, A = |Λ|² R with a rotation R, and along a motion
A' = 2 E L'ᵀ and A'' = 2 E L''ᵀ + 2 E' L'ᵀ exactly (Nikravesh 1988, sect. 6.3).
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Numbers, cross

# L and E are linear in Λ: which Λ stands at each place of the 3 x 4 matrix, and with which sign (Eq. 13).
_INDEX = np.array([[1, 0, 3, 2], [2, 3, 0, 1], [3, 2, 1, 0]])
_L_SIGN = np.array([[-1.0, 1, 1, -1], [-1, -1, 1, 1], [-1, 1, -1, 1]])
_E_SIGN = np.array([[-1.0, 1, -1, 1], [-1, 1, 1, -1], [-1, -1, 1, 1]])


def matrix_L(orientation: Numbers) -> Numbers:
    """L of Eq. 13, shape (..., 3, 4): ω = 2 L Λ' in body axes, and L Λ = 0."""
    return orientation[..., _INDEX] * _L_SIGN


def matrix_E(orientation: Numbers) -> Numbers:
    """E, shape (..., 3, 4): ω = 2 E Λ' in global axes, and E Λ = 0."""
    return orientation[..., _INDEX] * _E_SIGN


def rotation_matrix(orientation: Numbers) -> Numbers:
    """A = E Lᵀ, shape (..., 3, 3): body to global; |Λ|² times a rotation where Λ is not a unit."""
    return matrix_E(orientation) @ np.swapaxes(matrix_L(orientation), -1, -2)


def product(first: Numbers, second: Numbers) -> Numbers:
    """Euler parameters (..., 4) of one rotation after another: A(product) = A(first) A(second)."""
    vector = first[..., None, :1] * second[..., None, 1:] + second[..., None, :1] * first[..., None, 1:]
    across = cross(first[..., 1:], second[..., 1:])
    scalar = first[..., 0] * second[..., 0] - np.sum(first[..., 1:] * second[..., 1:], axis=-1)
    return np.concatenate([scalar[..., None], vector[..., 0, :] + across], axis=-1)
