"""Two vectors stay perpendicular: a·b = 0."""

from __future__ import annotations

from typing import final

import numpy as np

from mbproj.arrays import Numbers
from mbproj.constraints.primitive import Primitive
from mbproj.dataclass import dataclass


@final
@dataclass(frozen=True)
class Perpendicular(Primitive):
    """C = a·b of two unit vectors, in radians to first order (Haug 1989, Eq. 9.4.2: dot-1)."""

    slots = ("vector", "vector")
    rows = 1
    unit = "rad"

    def value(self, x: Numbers) -> Numbers:
        return np.sum(x[..., 0, :] * x[..., 1, :], axis=-1)[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        return x[..., None, ::-1, :]

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        return 2.0 * np.sum(x_dot[..., 0, :] * x_dot[..., 1, :], axis=-1)[..., None]
