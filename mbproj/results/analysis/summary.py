"""The summary of a run in a few numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.results.layout import COUNTERS
from mbproj.results.record import Results

# --- The energy drift of a run: the error of its energy balance -------------------------------------------------------


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


# --- The summary of a run in a few numbers ----------------------------------------------------------------------------


def summary(results: Results) -> dict[str, Any]:
    """The numbers of a run by name: state, sizes, counters, violations with time and joint, energy drift.

    Values are numbers, strings, lists, dictionaries of those, or None where a number does not exist (no samples, no
    joints). Names are those of `mbproj run --json`.
    """
    return {
        "title": results.title,
        "file": str(results.path),
        "status": results.status,
        "partial": results.partial,
        "bodies": len(results.names("bodies")),
        "joints": len(results.names("joints")),
        "markers": len(results.names("markers")),
        "coordinates": len(results.names("coordinates")),
        "samples": len(results.time),
        **(_of_samples(results) if len(results.time) else {}),
    }


def _of_samples(results: Results) -> dict[str, Any]:
    """The numbers of a run that has samples."""
    time = results.time
    position, velocity = (
        peak(time, results[f"diagnostics/{kind}_violation"], kind) for kind in ("position", "velocity")
    )
    joints = results.names("joints")
    lengths, angles = (worst(time, results[f"joints/violation_{kind}"], joints) for kind in ("length", "angle"))
    worst_joint = worst(time, results["joints/violation"], joints)
    energies = (results[f"diagnostics/{name}"] for name in ("energy_balance", "kinetic_energy", "potential_energy"))
    drift = energy_drift(*energies)
    return {
        "start": float(time[0]),
        "end": float(time[-1]),
        **{path.rpartition("/")[2]: int(results[path][-1]) for path in COUNTERS},
        "position_violation_max": position.value,
        "position_violation_time": position.time,
        "velocity_violation_max": velocity.value,
        "velocity_violation_time": velocity.time,
        "worst_joint": worst_joint.name if worst_joint else None,
        "worst_length": _plain(lengths),
        "worst_angle": _plain(angles),
        "energy_drift": drift.absolute,
        "energy_drift_relative": drift.relative,
    }


def _plain(value: SeriesPeak | None) -> dict[str, Any] | None:
    """The peak as a dictionary, for JSON."""
    return None if value is None else asdict(value)


@dataclass(frozen=True)
class SeriesPeak:
    """The largest value of a series, the time (s) when it is first reached, and the name of its column."""

    value: float
    time: float
    name: str


def peak(time: Array, values: Array, name: str) -> SeriesPeak:
    """The largest of `values` (T), T >= 1. NaN counts as larger than any number."""
    row = int(np.argmax(values))
    return SeriesPeak(float(values[row]), float(time[row]), name)


def worst(time: Array, values: Array, names: Sequence[str]) -> SeriesPeak | None:
    """The largest of `values` (T, columns), T >= 1, with the name of its column; None without columns."""
    if not names:
        return None
    row, column = np.unravel_index(int(np.argmax(values)), values.shape)
    return SeriesPeak(float(values[row, column]), float(time[row]), names[int(column)])
