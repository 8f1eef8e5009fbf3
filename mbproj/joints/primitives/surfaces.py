"""Primitives of a surface of revolution of one body that a point or a ball of another follows: the distance from it,
and the place along its meridian.

The meridian is a curve in the half plane of the distance ρ = |c|, c = z × ℓ, from the axis z through p1, and of the
height h = z·ℓ, ℓ = p2 - p1. So these are the primitives of a plane curve, of d = (ρ, h).

On the axis ρ has a kink, and a smooth surface has none: the component of its normal along ρ, over ρ, goes to
-κ t_ρ² / (1 - κ φ). The arc length has a kink there, as it begins to grow again.
"""

from __future__ import annotations

from typing import Any, ClassVar, NamedTuple, final

import numpy as np

from mbproj.base.arrays import Numbers, cross, dot
from mbproj.base.dataclass import dataclass
from mbproj.joints.primitives.basic import Line
from mbproj.joints.primitives.plane_curves import Arc, OnCurve, Profile

#: A part that is smaller is lost in round-off where it is the difference of two numbers, or a first-order term.
SMALL = float(np.sqrt(np.finfo(float).eps))
#: The circles and the meridians by which pictures show a surface, and the points of a circle.
CIRCLES, MERIDIANS, CORNERS = 7, 8, 48


class AboutAxis(NamedTuple):
    """The point p2 about the axis: z, ℓ, c = z × ℓ, and ρ."""

    z: Numbers
    line: Numbers
    c: Numbers
    ρ: Numbers


class OnSurface(OnCurve):
    """A primitive that depends on the foot of d = (ρ, h) on a meridian."""

    slots = ("vector", "point", "point")  # type: ignore[assignment]  # those in a plane are four
    acts_in_plane = False
    off_plane: ClassVar[str] = "follows a surface in space"

    @classmethod
    def lines(cls, curve: Any) -> tuple[Line, ...]:
        """Return circles at places along the meridian, and meridians around the axis."""
        beside = np.flatnonzero(curve.places.point[:, 0] >= 0.0)  # a curve may cross the axis, and come back
        ρ, h = curve.places.point[beside].T
        parts = np.split(np.arange(len(beside)), np.flatnonzero(np.diff(beside) > 1) + 1)
        turns = np.linspace(0.0, 2.0 * np.pi, CORNERS + 1)
        around = np.column_stack([np.cos(turns), np.sin(turns)])
        circles = [
            Line(np.column_stack([ρ[k] * around, np.full(CORNERS + 1, h[k])]), True)
            for k in np.linspace(0, len(ρ) - 1, CIRCLES).astype(int).tolist()
            if ρ[k] > SMALL * ρ.max()
        ]
        meridians = [
            Line(np.column_stack([ρ[part, None] * each, h[part]]), False)
            for each in around[: -1 : CORNERS // MERIDIANS]
            for part in parts
            if len(part) > 1
        ]
        return (*circles, *meridians)

    def _about(self, x: Numbers) -> AboutAxis:
        z, line = x[..., 0, :], x[..., 2, :] - x[..., 1, :]
        c = cross(z, line)
        return AboutAxis(z, line, c, np.sqrt(dot(c, c)))

    def _place(self, x: Numbers) -> Numbers:
        at = self._about(x)
        return np.stack([at.ρ, dot(at.z, at.line)], axis=-1)

    def _share(self, x: Numbers, along_ρ: Numbers) -> Numbers:
        """Return the component along ρ of what is differentiated, over ρ; on the axis 0, or its limit."""
        return _over(along_ρ, self._about(x).ρ)

    def _gradient_along(self, x: Numbers, e: tuple[Numbers, Numbers], factor: Numbers | float) -> Numbers:
        at = self._about(x)
        share, height = (factor * self._share(x, e[0]))[..., None], np.asarray(factor * e[1])[..., None]
        along = height * at.z + share * cross(at.c, at.z)
        return np.stack([height * at.line + share * cross(at.line, at.c), -along, along], axis=-2)[..., None, :, :]

    def _rates(self, x: Numbers, x_dot: Numbers) -> tuple[tuple[Numbers, Numbers], tuple[Numbers, Numbers]]:
        at, line_dot = self._about(x), x_dot[..., 2, :] - x_dot[..., 1, :]
        z_dot = x_dot[..., 0, :]
        ρ_dot, spread = self._spread(x, x_dot)
        return (ρ_dot, dot(z_dot, at.line) + dot(at.z, line_dot)), (_over(spread, at.ρ), 2.0 * dot(z_dot, line_dot))

    def _spread(self, x: Numbers, x_dot: Numbers) -> tuple[Numbers, Numbers]:
        """Return ρ', and ρ ρ'' without second derivatives of x."""
        at, z_dot, line_dot = self._about(x), x_dot[..., 0, :], x_dot[..., 2, :] - x_dot[..., 1, :]
        c_dot = cross(z_dot, at.line) + cross(at.z, line_dot)
        ρ_dot = _over(dot(at.c, c_dot), at.ρ)
        return ρ_dot, np.asarray(dot(c_dot, c_dot) + 2.0 * dot(at.c, cross(z_dot, line_dot)) - ρ_dot * ρ_dot)


def _over(number: Numbers, ρ: Numbers) -> Numbers:
    """Return number / ρ, 0 on the axis."""
    off = np.asarray(ρ).real > 0.0
    return np.where(off, number / np.where(off, ρ, 1.0), 0.0)


@final
@dataclass(frozen=True)
class Surface(OnSurface, Profile):
    """C = ±φ - R in metres: a ball of radius R, 0 for a point, touches the surface from the left of its meridian
    (`side` 1) or from the right (-1)."""

    in_kernel = "profile"

    def _share(self, x: Numbers, along_ρ: Numbers) -> Numbers:
        at, ρ = self.contact(x), self._about(x).ρ
        near = (np.abs(at.n[0].real) <= SMALL) & (np.abs((at.κ * ρ).real) <= SMALL)
        return np.where(near, -at.κ * at.t[0] ** 2 / (1.0 - at.κ * at.φ), _over(along_ρ, ρ))

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        at, (rate, bias), (_, spread) = self.contact(x), self._rates(x, x_dot), self._spread(x, x_dot)
        along = at.t[0] * rate[0] + at.t[1] * rate[1]
        bent = self._share(x, at.n[0]) * spread + at.n[1] * bias[1]
        return (self.side * (bent - at.κ / (1.0 - at.κ * at.φ) * along**2))[..., None]


@final
@dataclass(frozen=True)
class Meridian(OnSurface, Arc):
    """The arc length σ along the meridian from its beginning, in metres."""

    in_kernel = "arc"
    off_plane = OnSurface.off_plane
