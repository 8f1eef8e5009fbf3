"""Euler parameters Λ = (Λ0, Λ1, Λ2, Λ3), scalar first, body to global; leading axes are free.

A(Λ) = E Lᵀ is quadratic in Λ, so that for any Λ, unit or not, A = |Λ|² R with a rotation R, and along a motion
A' = 2 E L'ᵀ and A'' = 2 E L''ᵀ + 2 E' L'ᵀ exactly (Nikravesh 1988, sect. 6.3).
"""

from __future__ import annotations

import numpy as np

from mbproj.base.arrays import Numbers, like_of

# L and E are linear in Λ: which component of Λ stands at each place of the 3 x 4 matrix, and with which sign (Eq. 13).
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
    return E_times_L(orientation, orientation)


def E_times_L(first: Numbers, second: Numbers) -> Numbers:
    """E(Λ1) L(Λ2)ᵀ, shape (..., 3, 3)."""
    if first.ndim < 3:
        return matrix_E(first) @ np.swapaxes(matrix_L(second), -1, -2)
    # Entry by entry: over many samples four times as fast, and the same for a sample in blocks of any length.
    matrix = np.empty((*first.shape[:-1], 3, 3), dtype=first.dtype, order="F", like=like_of(first, second))
    a, b = ([each[..., place] for place in range(4)] for each in (first, second))
    scalar, x, y, z = (a[place] * b[place] for place in range(4))
    matrix[..., 0, 0], matrix[..., 1, 1] = scalar + x - y - z, scalar - x + y - z
    matrix[..., 2, 2] = scalar - x - y + z
    for i, j, k in ((1, 2, 3), (2, 3, 1), (3, 1, 2)):
        across, about = a[i] * b[j] + a[j] * b[i], a[k] * b[0] + a[0] * b[k]
        matrix[..., i - 1, j - 1], matrix[..., j - 1, i - 1] = across - about, across + about
    return matrix


def product(first: Numbers, second: Numbers) -> Numbers:
    """Euler parameters (..., 4) of one rotation after another: A(product) = A(first) A(second)."""
    a0, a1, a2, a3 = (first[..., place] for place in range(4))
    b0, b1, b2, b3 = (second[..., place] for place in range(4))
    return np.stack(
        [
            a0 * b0 - a1 * b1 - a2 * b2 - a3 * b3,
            a0 * b1 + b0 * a1 + a2 * b3 - a3 * b2,
            a0 * b2 + b0 * a2 + a3 * b1 - a1 * b3,
            a0 * b3 + b0 * a3 + a1 * b2 - a2 * b1,
        ],
        axis=-1,
    )


def turning(orientation: Numbers, rate: Numbers) -> Numbers:
    """Return ω = 2 L Λ' in body axes, (..., 3). Entry by entry it is five times as fast over many samples as with
    matrices."""
    a0, a1, a2, a3 = (orientation[..., place] for place in range(4))
    b0, b1, b2, b3 = (rate[..., place] for place in range(4))
    return 2.0 * np.stack(
        [
            a0 * b1 - a1 * b0 + a3 * b2 - a2 * b3,
            a0 * b2 - a2 * b0 + a1 * b3 - a3 * b1,
            a0 * b3 - a3 * b0 + a2 * b1 - a1 * b2,
        ],
        axis=-1,
    )
