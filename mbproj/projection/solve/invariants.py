"""Conserved quantities as further rows of the velocity projection: the energy balance, and momenta.

The balance T + V - W = E0 is nonlinear in the velocities, with the gradient p = M v. Along one direction d of the
tangent space it is a scalar quadratic, which is solved exactly. The joints' rows and the balance then hold to
round-off. The least change in the metric A of the method is along the tangential part of A⁻¹p. This is the tangential
part of v for A = M, and of M v for A = I.
"""

from __future__ import annotations

from dataclasses import field
from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.projection.methods.gopm import Gopm
from mbproj.projection.methods.method import Projection
from mbproj.thresholds import THRESHOLDS


@dataclass
class BalanceScratch:
    """The balance of one run, which changes from step to step: the `energy` E0 in J and the momenta (k,).

    `held`, `rested` and `refused` count the steps at which the rows were satisfied, left out near rest, or refused.
    `given` is the signed sum of the energy in J that they have added. `furthest` is its largest absolute value so far,
    and `moved` the sum of absolute values. `largest` is the largest change of the velocities so far, divided by the
    velocities."""

    energy: float = 0.0
    momenta: Array = field(default_factory=lambda: np.zeros(0))
    held: int = 0
    rested: int = 0
    refused: int = 0
    given: float = 0.0
    moved: float = 0.0
    furthest: float = 0.0
    largest: float = 0.0

    def save(self) -> dict[str, Any]:
        """Return the data as plain data, in the form of the kernel's marks."""
        return {
            "energy": self.energy,
            "momenta": self.momenta.tolist(),
            "often": [self.held, self.rested, self.refused],
            "sizes": [self.given, self.moved, self.furthest, self.largest],
        }

    def restore(self, saved: dict[str, Any]) -> None:
        """Continue from saved data."""
        self.energy = float(saved["energy"])
        self.momenta = np.array(saved["momenta"], dtype=float)
        self.held, self.rested, self.refused = map(int, saved["often"])
        self.given, self.moved, self.furthest, self.largest = map(float, saved["sizes"])


def corrected(
    method: Projection,
    M: Array,
    C_q: Array,
    v: Array,
    missing: float | None,
    fields: Array,
    momenta: Array,
    grain: float = 0.0,
    least_energy: float = 0.0,
) -> tuple[Array, bool]:
    """Return the change of v (7n,) in the tangent space of C_q that restores momenta and energy.

    The momenta along `fields` (k, 7n) become `momenta` (k,), and T grows by `missing` (J; None: no energy row) with the
    tolerance `grain` (J). The second result is False where the energy row is singular. Then little of the kinetic
    energy is free, or less than must be removed, or T is at most `least_energy` (J)."""
    change, size2 = np.zeros_like(v), float(v @ M @ v)
    by_coordinates = isinstance(method, Gopm)
    across, coupling = fields, np.zeros((0, 0))
    if len(fields):
        if by_coordinates:
            across = np.array([_tangent(method, M, C_q, each) for each in fields @ M])
        coupling = fields @ M @ across.T
        change = np.linalg.solve(coupling, momenta - fields @ M @ v) @ across
    if missing is None:
        return change, True
    if not 0.5 * size2 > max(grain, least_energy):
        return change, False
    g = M @ v if by_coordinates else v
    way = _tangent(method, M, C_q, g)
    if len(fields):
        way = way - np.linalg.solve(coupling, fields @ M @ way) @ across
    wanted = missing - float(0.5 * change @ M @ change + v @ M @ change)
    slope, curve = float((v + change) @ M @ way), float(way @ M @ way)
    root = slope * slope + 2.0 * curve * wanted
    if abs(wanted) <= grain:
        return change, True
    # slope² / curve is 2T of the free part, in any metric. It means nothing where the direction `way` is round-off.
    least, whole = THRESHOLDS.half_digits, float(g @ g) if by_coordinates else size2
    left = float(way @ way) if by_coordinates else curve
    if not (slope > 0.0 and slope * slope > least * curve * size2 and left > least * whole and root > 0.0):
        return change, False
    return np.asarray(change + 2.0 * wanted / (slope + np.sqrt(root)) * way), True


def _tangent(method: Projection, M: Array, C_q: Array, g: Array) -> Array:
    """Return the part of g in the tangent space of C_q, in the metric of the method."""
    return g + method.correction(M, C_q, C_q @ g)
