"""The largest loads of a run, stored by the run or computed from its samples, and their duty: the time above a level,
and the number of swings."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array
from mbproj.errors import InputError, Problem, choose_from
from mbproj.results import Results
from mbproj.results.loads.between_samples import size
from mbproj.results.loads.largest import SOURCES, Cycle, Load, Recorded, loads, open_directions


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
        lambda path: open_directions(results.constant, path),
    )


def cycle_of(results: Results, name: str) -> Cycle:
    """The joint coordinate that tells the place in the cycle. Raises InputError for an unknown name."""
    names = results.names("coordinates")
    if name not in names:
        raise InputError(Problem(f"there is no joint coordinate '{name}'", hint=choose_from(name, names)))
    coordinate = results.coordinate(name)
    return Cycle(name, coordinate.unit, coordinate.value)


#: The number of classes of a rainflow count.
CLASSES = 10


class Swings(NamedTuple):
    """A class of a rainflow count: the range and mean of its swings, in the unit of the load, and their number."""

    range: float
    mean: float
    cycles: float


def samples_of(results: Results, load: Load) -> Array:
    """The values (T,) of a load: magnitudes for vectors, signed values for scalars."""
    quantity = "force" if load.quantity == "power" else load.quantity
    able = [each for each in SOURCES if (each.kind, each.quantity) == (load.kind, quantity)]
    source = next(each for each in able if load.name in results.names(each.names))
    column = results.names(source.names).index(load.name)
    values = results[source.path][:, column]
    if load.quantity == "power" and source.power is not None:
        values = results[source.power][:, column]
    elif load.quantity == "power" and source.rate is not None:
        values = values * results[source.rate][:, column]
    return size(values.reshape(len(values), 1, -1))[:, 0]


def duration_above(time: Array, values: Array, level: float) -> float:
    """The time (s) for which the magnitude of a curve (T,) is above `level`, with straight lines between samples."""
    beyond = np.abs(values) - level
    before, after = beyond[:-1], beyond[1:]
    step = np.abs(after - before)
    upper = np.maximum(before, after)
    share = np.where(upper <= 0.0, 0.0, np.minimum(1.0, upper / np.where(step > 0.0, step, 1.0)))
    whole = np.minimum(before, after) >= 0.0
    return float(np.sum(np.diff(time) * np.where(whole, 1.0, share)))


def swings(values: Array) -> list[Swings]:
    """The rainflow count of a curve (T,) by ASTM E1049, largest range first. Raises InputError where the package
    `rainflow` is missing."""
    try:
        rainflow = import_module("rainflow")
    except ImportError as error:
        problem = Problem("rainflow counts need the package 'rainflow'", hint='pip install "mbproj[loads]"')
        raise InputError(problem) from error
    cycles = [(swing, mean, count) for swing, mean, count, _, _ in rainflow.extract_cycles(values.tolist())]
    largest = max((swing for swing, _, _ in cycles), default=0.0)
    if largest == 0.0:
        return []
    classes: dict[int, list[tuple[float, float, float]]] = {}
    for each in cycles:
        classes.setdefault(min(int(CLASSES * each[0] / largest), CLASSES - 1), []).append(each)
    counted = []
    for number in sorted(classes, reverse=True):
        members = np.array(classes[number])
        swing, mean = np.average(members[:, :2], axis=0, weights=members[:, 2])
        counted.append(Swings(float(swing), float(mean), float(members[:, 2].sum())))
    return counted
