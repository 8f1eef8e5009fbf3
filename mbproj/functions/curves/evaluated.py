"""Pieces as arrays: points and their derivatives at many parameters at once."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np

from mbproj.arrays import Array, Integers, Numbers
from mbproj.functions.curves.piece import NUMBERS, TERMS, Form, Piece

#: The point with its derivatives, 0 to 3, and the derivatives of f and g that these need, 0 to 4.
POINT_ORDERS, ORDERS = 4, 5


class Pieces:
    """n pieces as arrays. They are evaluated at many parameters at once; each parameter names its piece."""

    def __init__(self, pieces: Sequence[Piece]) -> None:
        self.start = np.array([each.start for each in pieces])
        self.origin = np.array([each.origin for each in pieces])
        self.form = np.array([each.form for each in pieces], dtype=np.intp)
        self.numbers = np.array([[each.f, each.g] for each in pieces], dtype=float).reshape(len(pieces), 2, NUMBERS)
        orders = np.arange(ORDERS)
        polynomials = [self.numbers[..., :TERMS]]
        for _ in orders[1:]:
            derivative = polynomials[-1][..., 1:] * np.arange(1, TERMS)
            polynomials.append(np.append(derivative, np.zeros((len(pieces), 2, 1)), axis=-1))
        a, self._w, p = (self.numbers[..., TERMS + k, None] for k in range(3))
        self._coefficients, self._a, self._p = np.stack(polynomials, axis=2), a * self._w**orders, p + 0.5 * pi * orders

    def derivatives(self, s: Numbers, piece: Integers) -> Numbers:
        """The point and its three derivatives by s (...), which may be complex: (POINT_ORDERS, 2, ...)."""
        form = self.form[piece]
        values = np.moveaxis(self._values((s - self.origin[piece])[..., None, None], piece), (-1, -2), (0, 1))
        points, f = values[:POINT_ORDERS].copy(), values[:, 0]
        if not form.any():
            return points
        bent, none = f[0] + f[2], 0.0 * s  # the radius of curvature
        outward = {
            Form.POLAR: [f[0], f[1], f[2] - f[0], f[3] - 3.0 * f[1]],
            Form.SUPPORT: [f[0], none, -bent, -2.0 * (f[1] + f[3])],
        }
        around = {
            Form.POLAR: [none, f[0], 2.0 * f[1], 3.0 * f[2] - f[0]],
            Form.SUPPORT: [f[1], bent, f[1] + f[3], f[2] + f[4] - bent],
        }
        cosine, sine = np.cos(s), np.sin(s)
        for kind in outward:
            if (form == kind).any():
                n, t = np.array(outward[kind]), np.array(around[kind])
                turned = np.stack([n * cosine - t * sine, n * sine + t * cosine], axis=1)
                points = np.where(form == kind, turned, points)
        return points

    def radius_of_curvature(self, s: Array, piece: Integers) -> Array:
        """The radius f + f'' in m at s (...), for pieces of the form SUPPORT."""
        values = self._values((s - self.origin[piece])[..., None, None], piece)
        return np.asarray(values[..., 0, 0] + values[..., 0, 2])

    def _values(self, u: Numbers, piece: Integers) -> Numbers:
        """f and g with their derivatives at u (..., 1, 1): (..., 2, ORDERS)."""
        coefficients = self._coefficients[piece]
        value = coefficients[..., -1] + 0.0 * u
        for k in reversed(range(TERMS - 1)):
            value = value * u + coefficients[..., k]
        return np.asarray(value + self._a[piece] * np.sin(self._w[piece] * u + self._p[piece]))
