"""Lengths and angles of a rope over points and circles in one plane."""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np

from mbproj.base.arrays import Numbers, dot
from mbproj.base.dataclass import dataclass
from mbproj.joints.primitives.basic import Primitive, SlotKind


class Span(NamedTuple):
    """A straight part of the rope at a pose, between the centres `first` and `last`.

    `line` is the vector ℓ between the centres, X and Y are its components in the plane, D2 = X² + Y². λ is the free
    length, h its part in the plane, w the difference of the radii. `a` and `b` are the weights of λ and of the
    direction θ. `start` is the direction of ℓ at the scene's pose. `runs` (...): the poses at which the rope has this
    part; None: all poses."""

    first: int
    last: int
    line: Numbers
    X: Numbers
    Y: Numbers
    D2: Numbers
    λ: Numbers
    h: Numbers
    w: float
    a: float
    b: float
    start: Numbers | float
    runs: Numbers | None = None

    @property
    def turn(self) -> Numbers:
        """The angle in rad by which ℓ has turned since the scene's pose, within (-π, π]."""
        cosine, sine = np.cos(self.start), np.sin(self.start)
        along, across = cosine * self.X + sine * self.Y, cosine * self.Y - sine * self.X
        real = np.arctan2(across.real, along.real)
        if not np.iscomplexobj(self.X):
            return real
        return real + 1j * (along.real * across.imag - across.real * along.imag) / self.D2.real

    @property
    def direction(self) -> Numbers:
        """The direction θ of the rope in rad."""
        # asin(w/D) = atan(w/h), whose complex form NumPy has for all arguments
        return self.start + self.turn + (np.arctan(self.w / self.h) if self.w else 0.0)

    @property
    def slopes(self) -> tuple[Numbers, Numbers]:
        """∂(b θ)/∂X and ∂(b θ)/∂Y."""
        if not self.b:  # a line between two points does not depend on the plane: D may be 0
            return 0.0 * self.X, 0.0 * self.Y
        out, around = -self.b * self.w / (self.D2 * self.h), self.b / self.D2
        return out * self.X - around * self.Y, out * self.Y + around * self.X

    def where(self, term: Numbers) -> Numbers:
        """The span's `term` (..., more) of a sum: 0 at poses without this span."""
        if self.runs is None:
            return term
        return np.where(self.runs.reshape(self.runs.shape + (1,) * (term.ndim - self.runs.ndim)), term, 0.0)


@final
@dataclass(frozen=True)
class Rope(Primitive):
    """C = Σ (a λ + b θ) over the spans between k centres, in m: free lengths λ, and lengths on the circles. With a = 1
    and b = w it is the length of the rope; with a = 0 it is the length that lies on one circle.

    `radii` (k,) are positive where the rope bends left, from x towards y, negative where it bends right, 0 for points.
    A span from radius r1 to r2 has w = r1 - r2, the free length λ = √(ℓ² - w²) and the direction θ = β + asin(w/D). β
    is the angle of the line between its centres. The rope is fixed to a circle at an end, which does not turn relative
    to x and y. `directions` (k-1,) are the angles β at the scene's pose; each β stays within half a turn of this angle.
    `by_length` and `by_angle` (k-1,) are a and b. `wound` is subtracted: the length on the circles of the ends at the
    scene's pose. `lifts` are the circles that the rope may leave; no two are neighbours. Where its wrap there would be
    negative, the rope runs straight past. The length has no kink then, but its curvature jumps. A step ends where a
    `watched` C changes its sign.
    """

    radii: tuple[float, ...]
    directions: tuple[float, ...]
    by_length: tuple[float, ...]
    by_angle: tuple[float, ...]
    wound: float = 0.0
    lifts: tuple[int, ...] = ()
    watched: bool = False

    rows = 1
    follows = "rope"
    off_plane = "runs over sheaves at different depths, or out of the plane"
    unit = "m"

    @property
    def slots(self) -> tuple[SlotKind, ...]:
        """The vectors x and y of the plane, then the centres."""
        point: SlotKind = "point"
        return ("vector", "vector", *[point for _ in self.radii])

    def spans(self, x: Numbers) -> list[Span]:
        """The straight parts in their order. The span that runs past a circle comes before the two that touch it."""
        passing: list[Span] = []
        touching = [
            self._span(x, k, k + 1, self.directions[k], a, b)
            for k, (a, b) in enumerate(zip(self.by_length, self.by_angle, strict=True))
        ]
        for k in self.lifts:
            before, after = touching[k - 1 : k + 1]
            on = np.sign(self.radii[k]) * (after.direction - before.direction).real >= 0.0
            past = self._span(x, k - 1, k + 1, 0.0, before.a, before.b + after.b)
            start = before.direction.real - np.arctan(past.w / past.h.real)
            touching[k - 1], touching[k] = before._replace(runs=on), after._replace(runs=on)
            passing.append(past._replace(start=start, runs=~on))
        return sorted([*touching, *passing], key=lambda span: (span.first, -span.last))

    def _span(self, x: Numbers, first: int, last: int, start: float, a: float, b: float) -> Span:
        line, w = x[..., 2 + last, :] - x[..., 2 + first, :], self.radii[first] - self.radii[last]
        X, Y = dot(x[..., 0, :], line), dot(x[..., 1, :], line)
        D2 = X * X + Y * Y
        with np.errstate(invalid="ignore"):  # no rope runs between circles that overlap: λ is NaN
            λ, h = np.sqrt(dot(line, line) - w * w), np.sqrt(D2 - w * w)
        return Span(first, last, line, X, Y, D2, λ, h, w, a, b, start)

    def wraps(self, x: Numbers) -> Numbers:
        """The angles of wrap (..., j) in rad on the j circles between the ends, negative where the rope is off."""
        spans = [self._span(x, k, k + 1, start, 0.0, 0.0) for k, start in enumerate(self.directions)]
        pairs = zip(self.radii[1:-1], spans[1:], spans[:-1], strict=True)
        angles = [np.sign(radius) * (after.direction - before.direction) for radius, after, before in pairs if radius]
        return np.stack(angles, axis=-1) if angles else np.zeros((*x.shape[:-2], 0))

    def value(self, x: Numbers) -> Numbers:
        total = np.zeros(x.shape[:-2], dtype=x.dtype)
        for span in self.spans(x):
            total = total + span.where(span.a * span.λ)
            if span.b:
                total = total + span.where(span.b * span.direction)
        return total[..., None] - self.wound

    def gradient(self, x: Numbers) -> Numbers:
        gradient = np.zeros((*x.shape[:-1], 3), dtype=x.dtype)
        for span in self.spans(x):
            f_X, f_Y = (each[..., None] for each in span.slopes)
            along = span.where(span.a * span.line / span.λ[..., None] + f_X * x[..., 0, :] + f_Y * x[..., 1, :])
            gradient[..., 0, :] += span.where(f_X * span.line)
            gradient[..., 1, :] += span.where(f_Y * span.line)
            gradient[..., 2 + span.first, :] -= along
            gradient[..., 2 + span.last, :] += along
        return gradient[..., None, :, :]

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        total = np.zeros(x.shape[:-2], dtype=np.result_type(x, x_dot))
        for span in self.spans(x):
            total = total + span.where(_bend(span, x, x_dot))
        return total[..., None]


def _bend(span: Span, x: Numbers, x_dot: Numbers) -> Numbers:
    """A span's term of the curvature."""
    f_X, f_Y = span.slopes
    rate = x_dot[..., 2 + span.last, :] - x_dot[..., 2 + span.first, :]
    stretch = dot(span.line, rate)
    total = span.a * (dot(rate, rate) - stretch**2 / span.λ**2) / span.λ
    total = total + 2.0 * (f_X * dot(x_dot[..., 0, :], rate) + f_Y * dot(x_dot[..., 1, :], rate))
    if not span.b:
        return total
    X_dot = dot(x_dot[..., 0, :], span.line) + dot(x[..., 0, :], rate)
    Y_dot = dot(x_dot[..., 1, :], span.line) + dot(x[..., 1, :], rate)
    out, around = span.X * X_dot + span.Y * Y_dot, span.X * Y_dot - span.Y * X_dot
    bend = (2.0 / span.D2 + 1.0 / span.h**2) * out**2 - X_dot**2 - Y_dot**2
    return total + span.b * span.w / (span.D2 * span.h) * bend - 2.0 * span.b * around * out / span.D2**2
