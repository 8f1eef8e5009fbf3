"""The quantity that an expectation is about, over all samples of a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from math import inf

import numpy as np

from mbproj.analysis.energy import exchanged
from mbproj.analysis.reactions import REACTIONS
from mbproj.arrays import Array
from mbproj.results import Results
from mbproj.scene.records import Expectation


def series(expectation: Expectation, results: Results) -> Array:
    """All samples of the quantity that the expectation names: (T, k), k components."""
    found = _SERIES[expectation.of](results, expectation.item, expectation.quantity)
    return np.asarray(found, dtype=float).reshape(len(results.time), -1)


def is_unique(expectation: Expectation, results: Results) -> bool:
    """Whether the constraints determine it; True where the results do not say."""
    if f"joints/{expectation.quantity}" not in REACTIONS:
        return True
    marks = results.constant(f"joints/{expectation.quantity}_unique")
    if marks is None:
        return True
    mine = marks[results.names("joints").index(expectation.item)]
    return bool(mine["xyz".index(expectation.component)] if expectation.component in ("x", "y", "z") else mine.all())


def _of_joint(results: Results, joint: str, quantity: str) -> Array:
    for name in results.names("coordinates"):
        if name == f"{joint}.{quantity}":
            return results.coordinate(name).value
        if f"{name}_speed" == f"{joint}.{quantity}":
            return results.coordinate(name).speed
    values: Array = getattr(results.joint(joint), quantity)
    return values


def _diagnostic(results: Results, name: str, _: str) -> Array:
    """A series of the file, or the energy balance's size, in J or as a part of the energy that the run exchanged."""
    if not name.startswith("energy_drift"):
        return results[f"diagnostics/{name}"]
    balance: Array = np.abs(results["diagnostics/energy_balance"])
    if name == "energy_drift":
        return balance
    size = exchanged(results["diagnostics/kinetic_energy"], results["diagnostics/potential_energy"])
    return np.where(balance == 0.0, 0.0, balance / size if size else inf)


_SERIES: Mapping[str, Callable[[Results, str, str], Array]] = {
    "marker": lambda results, name, quantity: getattr(results.marker(name), quantity),
    "body": lambda results, name, quantity: getattr(results.body(name), quantity),
    "joint": _of_joint,
    "force": lambda results, name, quantity: getattr(results.force(name), quantity),
    "motion": lambda results, name, quantity: getattr(results.motion(name), quantity),
    "diagnostic": _diagnostic,
}
