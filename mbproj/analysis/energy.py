"""The energy drift of a run: the error of its energy balance."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.thresholds import THRESHOLDS

EPSILON = float(np.finfo(float).eps)


@dataclass(frozen=True)
class EnergyDrift:
    """The drift max |E(t) - E(0) - W + D| in J, and relative to the energy that the run exchanged."""

    absolute: float
    relative: float


def energy_drift(balance: Array, kinetic: Array, potential: Array) -> EnergyDrift:
    """The energy drift of a run from its series (T) in J, T >= 1.

    The relative drift refers to the largest kinetic energy plus the range of the potential energy, because E(0) may be
    zero. Where only round-off moved the mechanism it is 0. Where no energy was exchanged, a drift is infinite. NaN in
    any series gives NaN.
    """
    absolute = float(np.max(np.abs(balance)))
    return EnergyDrift(absolute, float(relative_drift(np.array(absolute), kinetic, potential)))


def relative_drift(drift: Array, kinetic: Array, potential: Array) -> Array:
    """Drifts in J, >= 0, relative to the energy that their run exchanged; special cases are as in `energy_drift`."""
    size, largest = exchanged(kinetic, potential), float(np.max(drift))
    if max(size, largest) <= THRESHOLDS.rounding * float(np.max(np.abs(potential))):
        return np.zeros_like(drift)
    return np.where(drift == 0.0, 0.0, drift / size if size else np.inf)


def exchanged(kinetic: Array, potential: Array) -> float:
    """The largest kinetic energy plus the range of the potential energy of series (T) in J."""
    return float(np.max(kinetic) + np.ptp(potential))
