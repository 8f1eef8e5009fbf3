"""The largest loads of a run, stored by the run or computed from its samples, and their duty: the time above a level,
and the number of swings.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array
from mbproj.base.errors import InputError, Problem, choose_from, shortened
from mbproj.results.between_samples import size
from mbproj.results.largest_loads import SOURCES, Cycle, Load, Recorded, loads, open_directions
from mbproj.results.record import Results


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


# --- Reactions and contact forces that are not unique, in words -------------------------------------------------------
# Redundant joints, stops and frictions share them arbitrarily.


Marks = npt.NDArray[np.bool_]
#: The paths of reactions in the results.
REACTIONS = ("joints/reaction_force", "joints/reaction_torque")
#: The most joints that are listed with the same components.
SHOWN = 8


def open_components(joints: Sequence[str], force_unique: Marks, torque_unique: Marks) -> dict[str, str]:
    """The components that are not unique, as "Fy Tx Tz", by joint. `force_unique` and `torque_unique` (nj, 3) mark the
    unique ones. Joints with unique reactions are left out."""
    words = {}
    for name, *marks in zip(joints, force_unique, torque_unique, strict=True):
        pairs = zip("FT", marks, strict=True)
        components = [kind + "xyz"[axis] for kind, unique in pairs for axis in np.flatnonzero(~unique)]
        if components:
            words[name] = " ".join(components)
    return words


def reactions_not_unique(results: Results) -> dict[str, str] | None:
    """The components that are not unique in a results file, as "Fy Tx Tz", by joint; None where the file has no
    marks."""
    marks = [results.constant(f"{path}_unique") for path in REACTIONS]
    if marks[0] is None or marks[1] is None:
        return None
    return open_components(results.names("joints"), marks[0], marks[1])


def shared_at_contacts(results: Results) -> dict[str, float]:
    """The first time (s) at which contacts share a force arbitrarily, by its owner: "stop 'a'", "friction 'b'", "joint
    'C'"."""
    first: dict[str, float] = {}
    for event in results.events:
        if event.kind == "shared" and event.direction == 1:
            first.setdefault(event.name, event.time)
    return first


def in_words(components: Mapping[str, str]) -> str:
    """A text of the components by joint. Joints with the same components stand together: "Fy Tx Tz of A, B, C, D"."""
    joints: dict[str, list[str]] = {}
    for joint, open_ in components.items():
        joints.setdefault(open_, []).append(joint)
    return "; ".join(f"{open_} of {shortened(names, SHOWN)}" for open_, names in joints.items())
