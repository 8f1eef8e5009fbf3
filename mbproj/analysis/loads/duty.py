"""The duty of a load: how long it is above a level, and how often it swings."""

from __future__ import annotations

from importlib import import_module
from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array
from mbproj.errors import InputError, Problem
from mbproj.results import Results
from mbproj.results.loads.between_samples import size
from mbproj.results.loads.largest import SOURCES, Load

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
    found = [(swing, mean, count) for swing, mean, count, _, _ in rainflow.extract_cycles(values.tolist())]
    largest = max((swing for swing, _, _ in found), default=0.0)
    if largest == 0.0:
        return []
    classes: dict[int, list[tuple[float, float, float]]] = {}
    for each in found:
        classes.setdefault(min(int(CLASSES * each[0] / largest), CLASSES - 1), []).append(each)
    counted = []
    for number in sorted(classes, reverse=True):
        members = np.array(classes[number])
        swing, mean = np.average(members[:, :2], axis=0, weights=members[:, 2])
        counted.append(Swings(float(swing), float(mean), float(members[:, 2].sum())))
    return counted
