"""What a motion keeps, as further rows of the velocity projection: its energy balance, and momenta.

The balance T + V - W = E0 is nonlinear in the velocities, with the gradient p = M v. Along one direction d of the
tangent space it is a scalar quadratic, which is solved exactly: afterwards the joints' rows and the balance hold to
round-off. The least change in the metric A of the method is along the part of A⁻¹p in the tangent space: of v where
masses weigh it, of M v where the coordinates do.
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
    """Scratch of a run: the `energy` E0 in J and the momenta (k,) of the balance at hand. `largest` is their largest
    change of the velocities so far, as a part of them. Counted is how often the rows held, were left near rest
    (`rested`), or were refused. In J: the energy that they have `given`, signed; the largest size of that, `furthest`;
    the sum of the sizes, `moved`."""

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
        """As plain data, as the kernel's marks have it."""
        return {
            "energy": self.energy,
            "momenta": self.momenta.tolist(),
            "often": [self.held, self.rested, self.refused],
            "sizes": [self.given, self.moved, self.furthest, self.largest],
        }

    def restore(self, saved: dict[str, Any]) -> None:
        """Goes on from there."""
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
    """The change of v (7n,) in the tangent space of C_q by which the momenta along `fields` (k, 7n) are `momenta` (k,)
    and T grows by `missing` (J; None: no row of the energy) but for a `grain` (J); False where that row is singular:
    little of the kinetic energy is free, or less than what has to go, or it is no more than `least_energy` (J)."""
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
    # slope² / curve is 2T of what is free, in any metric; of a way that is round-off it may be anything.
    least, whole = THRESHOLDS.row_singular, float(g @ g) if by_coordinates else size2
    left = float(way @ way) if by_coordinates else curve
    if not (slope > 0.0 and slope * slope > least * curve * size2 and left > least * whole and root > 0.0):
        return change, False
    return np.asarray(change + 2.0 * wanted / (slope + np.sqrt(root)) * way), True


def _tangent(method: Projection, M: Array, C_q: Array, g: Array) -> Array:
    """The part of g in the tangent space of C_q, across it in the metric of the method."""
    return g + method.correction(M, C_q, C_q @ g)
