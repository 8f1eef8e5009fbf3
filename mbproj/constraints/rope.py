"""The length of a rope over points and circles in one plane."""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np

from mbproj.arrays import Numbers, dot
from mbproj.constraints.primitive import Primitive, SlotKind
from mbproj.dataclass import dataclass


class Span(NamedTuple):
    """A straight part of the rope at a pose: its line ℓ between two centres, with the components X and Y of ℓ in the
    plane; D² = X² + Y²; the free length λ; and h, the part of λ in the plane."""

    line: Numbers
    X: Numbers
    Y: Numbers
    D2: Numbers
    λ: Numbers
    h: Numbers


@final
@dataclass(frozen=True)
class Rope(Primitive):
    """C = Σ λ + w θ in metres, over the spans between k centres: free lengths λ, and what lies on the circles.

    `radii` (k,) are positive where the rope bends left, from x towards y, negative where it bends right, 0 of points.
    A span from radius r1 to r2 has w = r1 - r2 and the direction θ = β + asin(w/D), with the angle β of the line of
    its centres; λ² = ℓ² - w². An end with a radius holds the rope on its circle, which does not turn with respect to x
    and y. `directions` (k-1,) are the angles β at the scene's pose: each β is within half a turn of its own. `wound` in
    m is not counted: what lies on the circles of the ends there.
    """

    radii: tuple[float, ...]
    directions: tuple[float, ...]
    wound: float = 0.0

    rows = 1
    unit = "m"

    @property
    def slots(self) -> tuple[SlotKind, ...]:
        """Two vectors of the plane, x and y, then the centres."""
        point: SlotKind = "point"
        return ("vector", "vector", *[point for _ in self.radii])

    def span(self, x: Numbers, number: int) -> Span:
        """One of the straight parts."""
        line = x[..., 3 + number, :] - x[..., 2 + number, :]
        X, Y, w2 = dot(x[..., 0, :], line), dot(x[..., 1, :], line), self._w(number) ** 2
        D2 = X * X + Y * Y
        with np.errstate(invalid="ignore"):  # circles that overlap have no rope between them: it has no length
            return Span(line, X, Y, D2, np.sqrt(dot(line, line) - w2), np.sqrt(D2 - w2))

    def turned(self, span: Span, number: int) -> Numbers:
        """How far the line of its centres has turned since the scene's pose, within (-π, π]."""
        cosine, sine = np.cos(self.directions[number]), np.sin(self.directions[number])
        along, across = cosine * span.X + sine * span.Y, cosine * span.Y - sine * span.X
        real = np.arctan2(across.real, along.real)
        if not np.iscomplexobj(span.X):
            return real
        return real + 1j * (along.real * across.imag - across.real * along.imag) / span.D2.real

    def direction(self, span: Span, number: int) -> Numbers:
        """θ, the direction of the rope."""
        w = self._w(number)
        # asin(w/D) = atan(w/h), whose complex form numpy has for all arguments
        return self.directions[number] + self.turned(span, number) + (np.arctan(w / span.h) if w else 0.0)

    def wraps(self, x: Numbers) -> Numbers:
        """The angles (..., k, j) in rad that lie on the j circles between the ends, negative where the rope is off."""
        θ = [self.direction(self.span(x, number), number) for number in range(len(self.directions))]
        pairs = zip(self.radii[1:-1], θ[1:], θ[:-1], strict=True)
        found = [np.sign(radius) * (after - before) for radius, after, before in pairs if radius]
        return np.stack(found, axis=-1) if found else np.zeros((*x.shape[:-2], 0))

    def value(self, x: Numbers) -> Numbers:
        total = np.zeros(x.shape[:-2], dtype=x.dtype)
        for number in range(len(self.directions)):
            span, w = self.span(x, number), self._w(number)
            total = total + span.λ
            if w:
                total = total + w * self.direction(span, number)
        return total[..., None] - self.wound

    def gradient(self, x: Numbers) -> Numbers:
        found = np.zeros((*x.shape[:-1], 3), dtype=x.dtype)
        for number in range(len(self.directions)):
            span = self.span(x, number)
            f_X, f_Y = self._slopes(span, number)
            along = span.line / span.λ[..., None] + f_X[..., None] * x[..., 0, :] + f_Y[..., None] * x[..., 1, :]
            found[..., 0, :] += f_X[..., None] * span.line
            found[..., 1, :] += f_Y[..., None] * span.line
            found[..., 2 + number, :] -= along
            found[..., 3 + number, :] += along
        return found[..., None, :, :]

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        total = np.zeros(x.shape[:-2], dtype=np.result_type(x, x_dot))
        for number in range(len(self.directions)):
            span, w2 = self.span(x, number), self._w(number) ** 2
            f_X, f_Y = self._slopes(span, number)
            rate = x_dot[..., 3 + number, :] - x_dot[..., 2 + number, :]
            stretch = dot(span.line, rate)
            total = total + (dot(rate, rate) - stretch**2 / span.λ**2) / span.λ
            total = total + 2.0 * (f_X * dot(x_dot[..., 0, :], rate) + f_Y * dot(x_dot[..., 1, :], rate))
            if not w2:
                continue
            X_dot = dot(x_dot[..., 0, :], span.line) + dot(x[..., 0, :], rate)
            Y_dot = dot(x_dot[..., 1, :], span.line) + dot(x[..., 1, :], rate)
            out, around = span.X * X_dot + span.Y * Y_dot, span.X * Y_dot - span.Y * X_dot
            bend = w2 / (span.D2 * span.h) * (2.0 / span.D2 + 1.0 / span.h**2) * out**2
            total = total + bend - w2 / (span.D2 * span.h) * (X_dot**2 + Y_dot**2)
            total = total - 2.0 * self._w(number) * around * out / span.D2**2
        return total[..., None]

    def _w(self, number: int) -> float:
        return self.radii[number] - self.radii[number + 1]

    def _slopes(self, span: Span, number: int) -> tuple[Numbers, Numbers]:
        """∂(w θ)/∂X and ∂(w θ)/∂Y."""
        w = self._w(number)
        if not w:  # straight from point to point, whatever the plane: D may be 0
            return 0.0 * span.X, 0.0 * span.Y
        out, around = -w * w / (span.D2 * span.h), w / span.D2
        return out * span.X - around * span.Y, out * span.Y + around * span.X
