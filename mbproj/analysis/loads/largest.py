"""The largest loads of a run: those stored by the run, or computed from its samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.errors import InputError, Problem
from mbproj.results import Results
from mbproj.results.loads.largest import SOURCES, Cycle, Load, Recorded, loads
from mbproj.scene.text.suggestions import choose_from


def loads_of(results: Results, over: str | None = None) -> Sequence[Load]:
    """The largest loads as the run stored them. They are computed from the samples in files of older programs, and
    where the coordinate `over` ("crank.angle") tells the place in the cycle. Raises InputError where there is no such
    coordinate."""
    if over is None and results.stored_loads:
        return results.stored_loads
    recorded = recorded_in(results)
    return loads(recorded, cycle_of(results, over) if over else recorded.cycle())


def recorded_in(results: Results) -> Recorded:
    """The recorded data from which loads are computed."""
    kinds = {kind for source in SOURCES for kind in (source.names, source.units_of) if kind is not None}
    return Recorded(
        {kind: results.names(kind) for kind in kinds},
        lambda path, columns: results[path][:, columns],
        results.time,
        np.array([event.time for event in results.events]),
        lambda path: results.constant(f"{path}_unique"),
    )


def cycle_of(results: Results, name: str) -> Cycle:
    """The joint coordinate that tells the place in the cycle. Raises InputError for an unknown name."""
    names = results.names("coordinates")
    if name not in names:
        raise InputError(Problem(f"there is no joint coordinate '{name}'", hint=choose_from(name, names)))
    coordinate = results.coordinate(name)
    return Cycle(name, coordinate.unit, coordinate.value)
