"""Baumgarte's stabilisation (ref. 9): C'' + 2αC' + β²C = 0 in place of C'' = 0."""

from __future__ import annotations

from typing import final

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.projection.methods.method import Method


@final
@dataclass(frozen=True)
class Baumgarte(Method):
    """`gains` (α, β) in 1/s; the paper takes 25 for both. Critically damped where α = β."""

    gains: tuple[float, float]

    stabilises = True

    def stabilised(self, gamma: Array, C: Array, C_dot: Array) -> Array:
        alpha, beta = self.gains
        return gamma - 2.0 * alpha * C_dot - beta**2 * C


METHOD = Baumgarte
