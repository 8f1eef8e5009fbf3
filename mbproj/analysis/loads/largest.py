"""The largest loads of a run, as it kept them or from its samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.errors import InputError, Problem
from mbproj.results import Results
from mbproj.results.loads.largest import SOURCES, Cycle, Load, Recorded, loads
from mbproj.scene.text.suggestions import choose_from


def loads_of(results: Results, over: str | None = None) -> Sequence[Load]:
    """The largest loads, as the run kept them; computed from the samples in files of older programs, and where the
    place in the cycle is told by the coordinate `over` ("crank.angle"). Raises InputError where there is none."""
    if over is None and results.stored_loads:
        return results.stored_loads
    recorded = recorded_in(results)
    return loads(recorded, cycle_of(results, over) if over else recorded.cycle())


def recorded_in(results: Results) -> Recorded:
    """What the loads are computed from."""
    kinds = {kind for source in SOURCES for kind in (source.names, source.units_of) if kind is not None}
    return Recorded(
        {kind: results.names(kind) for kind in kinds},
        lambda path, columns: results[path][:, columns],
        results.time,
        np.array([event.time for event in results.events]),
        lambda path: results.constant(f"{path}_unique"),
    )


def cycle_of(results: Results, name: str) -> Cycle:
    """The coordinate of a joint as what tells the place in the cycle."""
    names = results.names("coordinates")
    if name not in names:
        raise InputError(Problem(f"there is no joint coordinate '{name}'", hint=choose_from(name, names)))
    found = results.coordinate(name)
    return Cycle(name, found.unit, found.value)
