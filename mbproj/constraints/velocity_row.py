"""Rows at velocity level: A(x) x' = 0, where A is the gradient of no function."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Numbers
from mbproj.constraints.primitive import Primitive

#: A complex step, whose square vanishes beside 1.
STEP = 1e-100


class VelocityRow(Primitive):
    """A row that is not integrable, in m/s. Its value is 0: the projection of a position requires A δ = 0 of it."""

    rows = 1
    unit = "m"
    integrable = False

    def value(self, x: Numbers) -> Numbers:
        return np.zeros((*x.shape[:-2], 1), dtype=x.dtype)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        """Return A' x': the complex step of the gradient along the motion, exact to round-off (Squire and Trapp
        1998)."""
        bent = self.gradient(x + 1j * STEP * x_dot).imag / STEP
        return np.asarray((bent * x_dot[..., None, :, :]).sum(axis=(-2, -1)))
