"""How far the energy is from what it should be."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.thresholds import THRESHOLDS

EPSILON = float(np.finfo(float).eps)


@dataclass(frozen=True)
class EnergyDrift:
    """max |E(t) - E(0) - W + D| in J, and the same over the energy that the run exchanged."""

    absolute: float
    relative: float


def energy_drift(balance: Array, kinetic: Array, potential: Array) -> EnergyDrift:
    """The drift of a run from its series (T) in J, T >= 1.

    The relative drift is over the largest kinetic energy plus the range of the potential energy: E(0) may be zero.
    Where nothing but round-off moved it is 0. Without any exchange a drift is infinite; NaN in any series gives NaN.
    """
    absolute, size = float(np.max(np.abs(balance))), exchanged(kinetic, potential)
    if max(size, absolute) <= THRESHOLDS.rests * EPSILON * float(np.max(np.abs(potential))):
        return EnergyDrift(absolute, 0.0)
    if size == 0.0:
        return EnergyDrift(absolute, 0.0 if absolute == 0.0 else float("inf"))
    return EnergyDrift(absolute, absolute / size)


def exchanged(kinetic: Array, potential: Array) -> float:
    """The largest kinetic energy plus the range of the potential energy of series (T) in J."""
    return float(np.max(kinetic) + np.ptp(potential))
