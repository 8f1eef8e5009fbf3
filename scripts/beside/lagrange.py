"""Lagrange's equations derived by hand in Python: of the four-bar whose coupler a bushing holds together, in four
angles, and of the flyball governor with a stiff spring and damper, in two. Tests hold mbproj against both."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import acos, atan2, cos, hypot, pi, sin

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
GRAVITY = 9.81
#: m between the pins: crank, coupler of both halves, rocker, frame.
CRANK, COUPLER, ROCKER, FRAME = 0.1, 0.3, 0.25, 0.3
HALF = COUPLER / 2
#: kg and kg m² of the crank, a half of the coupler, the rocker; about their centres.
MASSES, INERTIAS = (2.0, 0.15, 0.15, 0.25), (0.01, 2.8e-4, 2.8e-4, 1.3e-3)
START, SPEED = pi / 3, 12.0


@dataclass(frozen=True)
class FourBar:
    """The plane is x-z; angles grow from x to z: of the crank, the near half, the far half, the rocker. k in N/m is the
    stiffness along the coupler, across it is half of that."""

    k: float

    @property
    def stiffness(self) -> Array:
        """Along and across the coupler, N/m, and about its axis, N m/rad."""
        return self.k * np.array([1.0, 0.5, 60.0 / 1e5])

    @property
    def damping(self) -> Array:
        """N s/m and N m s/rad."""
        return np.array([20.0, 10.0, 0.02])

    @cached_property
    def angles(self) -> Array:
        """At the start, at which the bushing is at rest."""
        across, down = FRAME - CRANK * cos(START), -CRANK * sin(START)
        span = hypot(across, down)
        tilt = atan2(down, across) + acos((COUPLER**2 + span**2 - ROCKER**2) / (2 * COUPLER * span))
        end = CRANK * np.array([cos(START), sin(START)]) + COUPLER * np.array([cos(tilt), sin(tilt)])
        return np.array([START, tilt, tilt, atan2(end[1], end[0] - FRAME)])

    @cached_property
    def speeds(self) -> Array:
        """At the start, those of a rigid four-bar, rad/s."""
        start, tilt, _, swing = self.angles
        coupler = SPEED * CRANK * sin(start - swing) / (COUPLER * sin(swing - tilt))
        rocker = SPEED * CRANK * sin(start - tilt) / (ROCKER * sin(swing - tilt))
        return np.array([SPEED, coupler, coupler, rocker])

    @property
    def start(self) -> Array:
        """Angles and speeds, (8,)."""
        return np.concatenate([self.angles, self.speeds])

    def slope(self, _: float, y: Array) -> Array:
        """y' by Lagrange's equations: two double pendulums with the bushing between them."""
        one, two, three, four, *w = y.tolist()
        c1, s1, c2, s2, c3, s3, c4, s4 = (f(angle) for angle in (one, two, three, four) for f in (cos, sin))
        g, (m1, m2, m3, m4) = GRAVITY, MASSES
        x = FRAME + ROCKER * c4 - HALF * c3 - CRANK * c1 - HALF * c2  # from the near half's end to the far half's
        z = ROCKER * s4 - HALF * s3 - CRANK * s1 - HALF * s2
        cm, sm = cos((two + three) / 2), sin((two + three) / 2)
        along, across, bent = x * cm + z * sm, z * cm - x * sm, three - two
        ends = (
            (CRANK * s1, -CRANK * c1),
            (HALF * s2, -HALF * c2),
            (HALF * s3, -HALF * c3),
            (-ROCKER * s4, ROCKER * c4),
        )
        by = [
            (dx * cm + dz * sm + part * across, dz * cm - dx * sm - part * along, turn)
            for (dx, dz), part, turn in zip(ends, (0.0, 0.5, 0.5, 0.0), (0.0, -1.0, 1.0, 0.0), strict=True)
        ]
        push = [
            k * gap + c * sum(row[i] * rate for row, rate in zip(by, w, strict=True))
            for i, (k, c, gap) in enumerate(
                zip(self.stiffness.tolist(), self.damping.tolist(), (along, across, bent), strict=True)
            )
        ]
        q = [-sum(part * force for part, force in zip(row, push, strict=True)) for row in by]
        I1, I2, I3, I4 = INERTIAS
        arm, sine = m2 * CRANK * HALF / 2 * (c1 * c2 + s1 * s2), m2 * CRANK * HALF / 2 * (s1 * c2 - c1 * s2)
        near = _solve(
            I1 + m1 * CRANK**2 / 4 + m2 * CRANK**2,
            I2 + m2 * HALF**2 / 4,
            arm,
            q[0] - sine * w[1] ** 2 - (m1 / 2 + m2) * CRANK * g * c1,
            q[1] + sine * w[0] ** 2 - m2 * HALF / 2 * g * c2,
        )
        arm, sine = -m3 * ROCKER * HALF / 2 * (c4 * c3 + s4 * s3), -m3 * ROCKER * HALF / 2 * (s4 * c3 - c4 * s3)
        far = _solve(
            I4 + m4 * ROCKER**2 / 4 + m3 * ROCKER**2,
            I3 + m3 * HALF**2 / 4,
            arm,
            q[3] - sine * w[2] ** 2 - (m4 / 2 + m3) * ROCKER * g * c4,
            q[2] + sine * w[3] ** 2 + m3 * HALF / 2 * g * c3,
        )
        return np.array([*w, *near, far[1], far[0]])

    @staticmethod
    def watched(y: Array) -> Array:
        """The end of the near half and that of the rocker (..., 2, 3), for angles (and speeds) (..., 4 or 8)."""
        one, two, _, four = np.moveaxis(y[..., :4], -1, 0)
        near = [CRANK * np.cos(one) + HALF * np.cos(two), 0.0 * one, CRANK * np.sin(one) + HALF * np.sin(two)]
        end = [FRAME + ROCKER * np.cos(four), 0.0 * one, ROCKER * np.sin(four)]
        return np.moveaxis(np.array([near, end]), (0, 1), (-2, -1))


def _solve(a: float, b: float, c: float, f: float, g: float) -> tuple[float, float]:
    """[[a, c], [c, b]] x = (f, g)."""
    d = a * b - c * c
    return (b * f - c * g) / d, (a * g - c * f) / d


#: kg: a ball, the collar, the spindle; m: an arm, a link and the arm above it, the arms' pins from the axis, a ball.
BALL, COLLAR, SPINDLE, ARM, LINK, PIN, RADIUS = 1.0, 1.5, 3.0, 0.2, 0.1, 0.03, 0.03
#: kg m²: a ball's, the collar's, the spindle's about and across the axis.
BALL_INERTIA, COLLAR_INERTIA, ABOUT, ACROSS = 0.4 * BALL * RADIUS**2, 2e-3, 0.01, 0.05
LEAN, SPIN = 25.0 * pi / 180.0, 20.0


@dataclass(frozen=True)
class Governor:
    """Angles of the spindle and of the arms from the vertical. k in N/m is the spring's stiffness, and k/1000 in N s/m
    the damper's; the spring has its free length at the start."""

    k: float

    @property
    def damping(self) -> float:
        """N s/m."""
        return 1e-3 * self.k

    @property
    def start(self) -> Array:
        """Angles and speeds, (4,)."""
        return np.array([0.0, LEAN, SPIN, 0.0])

    def slope(self, _: float, y: Array) -> Array:
        """y' by Lagrange's equations, with T = (A θ'² + B ψ'²) / 2."""
        _, arm, spin, rate = y.tolist()
        s, c = sin(arm), cos(arm)
        out = PIN + ARM * s
        A = 2.0 * (BALL * ARM**2 + BALL_INERTIA) + COLLAR * (2.0 * LINK * s) ** 2
        B = 2.0 * (BALL * out**2 + BALL_INERTIA) + COLLAR_INERTIA + ABOUT
        A_slope, B_slope = 2.0 * COLLAR * (2.0 * LINK) ** 2 * s * c, 4.0 * BALL * out * ARM * c
        stretch, stretching = 2.0 * LINK * (c - cos(LEAN)), -2.0 * LINK * s * rate
        pull = self.k * stretch + self.damping * stretching
        moment = pull * 2.0 * LINK * s - 2.0 * (BALL * ARM + COLLAR * LINK) * GRAVITY * s
        return np.array(
            [spin, rate, -B_slope * rate * spin / B, (moment + 0.5 * B_slope * spin**2 - 0.5 * A_slope * rate**2) / A]
        )

    @staticmethod
    def watched(y: Array) -> Array:
        """The right ball from above and the collar's height, NaN for the rest (..., 2, 3); of angles (..., 2 or 4)."""
        spin, arm = np.moveaxis(y[..., :2], -1, 0)
        out, none = PIN + ARM * np.sin(arm), np.full_like(arm, np.nan)
        ball, collar = [out * np.cos(spin), out * np.sin(spin), none], [none, none, -2.0 * LINK * np.cos(arm)]
        return np.moveaxis(np.array([ball, collar]), (0, 1), (-2, -1))
