"""The distance between two points."""

from __future__ import annotations

from typing import final

import numpy as np

from mbproj.arrays import Numbers
from mbproj.constraints.primitive import Primitive
from mbproj.dataclass import dataclass


@final
@dataclass(frozen=True)
class Distance(Primitive):
    """C = |p2 - p1| in metres, not its square, so that a violation is a length (Haug 1989, Eq. 9.4.10)."""

    slots = ("point", "point")
    rows = 1
    unit = "m"

    def value(self, x: Numbers) -> Numbers:
        line = x[..., 1, :] - x[..., 0, :]
        return np.sqrt(np.sum(line * line, axis=-1))[..., None]

    def gradient(self, x: Numbers) -> Numbers:
        along = (x[..., 1, :] - x[..., 0, :]) / self.value(x)
        return np.stack([-along, along], axis=-2)[..., None, :, :]

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        length = self.value(x)
        along = (x[..., 1, :] - x[..., 0, :]) / length
        rate = x_dot[..., 1, :] - x_dot[..., 0, :]
        stretch = np.sum(along * rate, axis=-1)[..., None]
        return (np.sum(rate * rate, axis=-1)[..., None] - stretch * stretch) / length
