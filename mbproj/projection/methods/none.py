"""No projection: direct integration of Eq. 14, in which the constraints drift. It is there to show the drift."""

from __future__ import annotations

from typing import final

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.projection.methods.method import Method


@final
@dataclass(frozen=True)
class Unprojected(Method):
    """Direct integration of Eq. 14."""

    def stabilised(self, gamma: Array, C: Array, C_dot: Array) -> Array:
        return gamma


METHOD = Unprojected
