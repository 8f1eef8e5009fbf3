"""The flyball governor with a stiff spring and damper, in two angles: its equations derived by hand, its numbers for
every program."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
GRAVITY = 9.81
#: kg: a ball, the collar, the spindle; m: an arm, a link and the arm above it, the arms' pins from the axis, a ball.
BALL, COLLAR, SPINDLE, ARM, LINK, PIN, RADIUS = 1.0, 1.5, 3.0, 0.2, 0.1, 0.03, 0.03
#: kg m²: a ball's, the collar's, the spindle's about and across the axis.
BALL_INERTIA, COLLAR_INERTIA, ABOUT, ACROSS = 0.4 * BALL * RADIUS**2, 2e-3, 0.01, 0.05
START, SPEED = 25.0 * pi / 180.0, 20.0


@dataclass(frozen=True)
class Governor:
    """Angles of the spindle and of the arms from the vertical. k in N/m is the spring's stiffness, and k/1000 in N s/m
    the damper's; the spring has its free length at the start."""

    k: float
    name: str = "Governor"

    @property
    def damping(self) -> float:
        """N s/m."""
        return 1e-3 * self.k

    @property
    def start(self) -> Array:
        """Angles and speeds, (4,)."""
        return np.array([0.0, START, SPEED, 0.0])

    def slope(self, _: float, y: Array) -> Array:
        """y' by Lagrange's equations, with T = (A θ'² + B ψ'²) / 2."""
        _, arm, spin, rate = y.tolist()
        s, c = sin(arm), cos(arm)
        out = PIN + ARM * s
        A = 2.0 * (BALL * ARM**2 + BALL_INERTIA) + COLLAR * (2.0 * LINK * s) ** 2
        B = 2.0 * (BALL * out**2 + BALL_INERTIA) + COLLAR_INERTIA + ABOUT
        A_slope, B_slope = 2.0 * COLLAR * (2.0 * LINK) ** 2 * s * c, 4.0 * BALL * out * ARM * c
        stretch, stretching = 2.0 * LINK * (c - cos(START)), -2.0 * LINK * s * rate
        pull = self.k * stretch + self.damping * stretching
        moment = pull * 2.0 * LINK * s - 2.0 * (BALL * ARM + COLLAR * LINK) * GRAVITY * s
        return np.array(
            [spin, rate, -B_slope * rate * spin / B, (moment + 0.5 * B_slope * spin**2 - 0.5 * A_slope * rate**2) / A]
        )

    @staticmethod
    def points(angles: Array) -> Array:
        """The right ball's place from above, and the collar's height beside 0 (..., 4): where errors are measured."""
        spin, arm = np.moveaxis(angles, -1, 0)
        out = PIN + ARM * np.sin(arm)
        return np.stack([out * np.cos(spin), out * np.sin(spin), 0.0 * arm, -2.0 * LINK * np.cos(arm)], axis=-1)
