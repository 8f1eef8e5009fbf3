"""A closed convex curve in a plane of one body and a flat face of another: their distance, and their point of
contact."""

from __future__ import annotations

from typing import ClassVar, final

import numpy as np

from mbproj.arrays import Integers, Numbers, dot
from mbproj.constraints.curves.profile import FootGeometry, OnCurve
from mbproj.dataclass import dataclass


@dataclass(frozen=True)
class OnFace(OnCurve):
    """A primitive that depends on where a face with the normal m touches: where the outward normal of the curve points
    along (a, b) = (u·m, w·m). The foot does not depend on the face's point p2.

    The foot moves by σ' = ω/κ, with the rate ω = ±t·(a', b')/√(a² + b²) at which m turns in the plane; the sign is κ's.
    """

    slots = ("vector", "vector", "vector", "point", "point")  # type: ignore[assignment]  # those of a point are four
    meets: ClassVar[str] = "face"

    def _place(self, x: Numbers) -> Numbers:
        return np.stack([dot(x[..., 0, :], x[..., 2, :]), dot(x[..., 1, :], x[..., 2, :])], axis=-1)

    def _foot(self, d: Numbers) -> tuple[Numbers, Integers]:
        return self.curve.facing(d, self.piece)

    @staticmethod
    def _line(x: Numbers) -> Numbers:
        return x[..., 4, :] - x[..., 3, :]

    def _size(self, x: Numbers) -> Numbers:
        """Return r = √(a² + b²): 1 for a face normal to the plane."""
        a, b = np.moveaxis(self._place(x), -1, 0)
        return np.sqrt(a * a + b * b)

    def _turning(self, x: Numbers, x_dot: Numbers, at: FootGeometry) -> tuple[Numbers, Numbers]:
        """Return ω, and the part of ω' without second derivatives of x."""
        r, rates = self._size(x), []
        for k in (0, 1):
            rates.append(dot(x_dot[..., k, :], x[..., 2, :]) + dot(x[..., k, :], x_dot[..., 2, :]))
        bent = [2.0 * dot(x_dot[..., k, :], x_dot[..., 2, :]) for k in (0, 1)]
        side = np.sign(at.κ.real)
        ω, d = side * _product(at.t, rates) / r, self._place(x)
        growth = (rates[0] * d[..., 0] + rates[1] * d[..., 1]) / r
        return ω, (side * _product(at.t, bent) - 2.0 * ω * growth) / r


@final
@dataclass(frozen=True)
class Face(OnFace):
    """C = m·ℓ - (a c0 + b c1) in metres: the distance of the face from the curve. The normal m points away from the
    curve."""

    def value(self, x: Numbers) -> Numbers:
        c, d = self.contact(x).c, self._place(x)
        return (dot(x[..., 2, :], self._line(x)) - c[0] * d[..., 0] - c[1] * d[..., 1])[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        c, m = self.contact(x).c, x[..., 2, :]
        place = c[0][..., None] * x[..., 0, :] + c[1][..., None] * x[..., 1, :]
        parts = [-c[0][..., None] * m, -c[1][..., None] * m, self._line(x) - place, -m, m]
        return np.stack(parts, axis=-2)[..., None, :, :]

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        at = self.contact(x)
        ω, _ = self._turning(x, x_dot, at)
        place = at.c[0][..., None] * x_dot[..., 0, :] + at.c[1][..., None] * x_dot[..., 1, :]
        bent = 2.0 * dot(x_dot[..., 2, :], self._line(x_dot) - place)
        return (bent - self._size(x) * ω**2 / (np.sign(at.κ.real) * at.κ))[..., None]


@dataclass(frozen=True)
class AlongFace(OnFace):
    """p = t·(c - d) in metres, d = (u·ℓ, w·ℓ): the point of contact on the face, along the curve's direction from p2.
    Subclasses may be functions of p and of σ, the arc length of the contact along the curve."""

    def _gradient(self, x: Numbers, *, slips: bool) -> Numbers:
        """The gradient of p, or of σ - p."""
        at, line, m = self.contact(x), self._line(x), x[..., 2, :]
        apart, sign = _product(at.n, self._gap(x, at)), -1.0 if slips else 1.0
        turned = np.sign(at.κ.real) * (-apart if slips else apart + 1.0 / at.κ) / self._size(x)
        first, second = (each[..., None] for each in at.t)
        along = first * x[..., 0, :] + second * x[..., 1, :]
        own = turned[..., None] * m - sign * line
        parts = [first * own, second * own, turned[..., None] * along, sign * along, -sign * along]
        return np.stack(parts, axis=-2)[..., None, :, :]

    def _curvature(self, x: Numbers, x_dot: Numbers, *, slips: bool) -> Numbers:
        at, line, line_dot = self.contact(x), self._line(x), self._line(x_dot)
        (ω, ω_bias), apart = self._turning(x, x_dot, at), self._gap(x, at)
        rate = [dot(x_dot[..., k, :], line) + dot(x[..., k, :], line_dot) for k in (0, 1)]
        bias = [2.0 * dot(x_dot[..., k, :], line_dot) for k in (0, 1)]
        across = 2.0 * _product(at.n, rate) + ω * _product(at.t, apart)
        curvature = ω_bias * _product(at.n, apart) - ω * across - _product(at.t, bias)
        if slips:
            return -np.asarray(curvature)[..., None]
        return np.asarray(curvature + ω_bias / at.κ - ω**2 * at.κ_σ / at.κ**3)[..., None]

    def _gap(self, x: Numbers, at: FootGeometry) -> tuple[Numbers, Numbers]:
        """Return c - d."""
        line = self._line(x)
        return at.c[0] - dot(x[..., 0, :], line), at.c[1] - dot(x[..., 1, :], line)


@final
@dataclass(frozen=True)
class FacePlace(AlongFace):
    """p."""

    def value(self, x: Numbers) -> Numbers:
        at = self.contact(x)
        return _product(at.t, self._gap(x, at))[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        return self._gradient(x, slips=False)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        return self._curvature(x, x_dot, slips=False)


@final
@dataclass(frozen=True)
class FaceSlip(AlongFace):
    """σ - p, whose rate is that of sliding of the face along the curve. Its value is 0, as with `SlipOfTwo`."""

    def value(self, x: Numbers) -> Numbers:
        at = self.contact(x)
        way = self.curve.length_at(at.s, at.piece) - _product(at.t, self._gap(x, at))
        return (way - way.real)[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        return self._gradient(x, slips=True)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        return self._curvature(x, x_dot, slips=True)


def _product(e: tuple[Numbers, Numbers], d: tuple[Numbers, Numbers] | list[Numbers]) -> Numbers:
    return e[0] * d[0] + e[1] * d[1]
