"""The file of a sweep: a scene, the ranges of its varied values, their combination, and the measures."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from dataclasses import field
from functools import cached_property
from math import prod
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeAlias

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem
from mbproj.scene.blocks.expectations import MEASURES, ExpectationKeys, complaints, items_of, measures_of, untimely
from mbproj.scene.changes import Change
from mbproj.scene.fields.fields import ByPath, NameChoice, Record, Text
from mbproj.scene.fields.quantities import Integer
from mbproj.scene.fields.reading import Reading, in_text_order
from mbproj.scene.ranges import RANGE, Item, Listed, Points, Range, column_of, read_mapping, scene_named, units_of
from mbproj.scene.records import Expectation, KeyPath
from mbproj.scene.scene import SceneText
from mbproj.scene.settings import settings_to_run
from mbproj.scene.text.nodes import Node, from_value
from mbproj.studies.store import Keys

# --- The cases of a sweep ---------------------------------------------------------------------------------------------
# Every combination of the values, one after another, or samples of the unit cube.


#: A function of dimensions d, samples n and seed that returns samples (n, d), or more rows.
Sampler: TypeAlias = "Callable[[int, int, int], Array]"
MONTECARLO, LHS, SOBOL, SALTELLI = "montecarlo", "lhs", "sobol", "saltelli"
#: Designs that are balanced only with 2, 4, 8, .. samples.
POWERS_OF_TWO = frozenset({SOBOL, SALTELLI})
#: The values of a case, in the order of the design's paths.
Case: TypeAlias = tuple[Item, ...]


def montecarlo(dimensions: int, samples: int, seed: int) -> Array:
    """Independent samples; a larger number begins with the same samples."""
    return np.random.default_rng(seed).random((samples, dimensions))


def latin_hypercube(dimensions: int, samples: int, seed: int) -> Array:
    """One sample in each of n slices of every dimension."""
    from scipy.stats import qmc

    points: Array = qmc.LatinHypercube(dimensions, seed=np.random.default_rng(seed)).random(samples)
    return points


def sobol(dimensions: int, samples: int, seed: int) -> Array:
    """Sobol's sequence, scrambled; a larger number begins with the same samples."""
    from scipy.stats import qmc

    points: Array = qmc.Sobol(dimensions, seed=np.random.default_rng(seed)).random(samples)
    return points


def saltelli(dimensions: int, samples: int, seed: int) -> Array:
    """Saltelli's design for Sobol' indices, (n (d + 2), d): samples A, further samples B, and A with each one of its
    columns from B (Saltelli et al. 2010, Computer Physics Communications 181, 259-270)."""
    both = sobol(2 * dimensions, samples, seed)
    A, B = both[:, :dimensions], both[:, dimensions:]
    mixed = np.repeat(A[None], dimensions, axis=0)
    for column in range(dimensions):
        mixed[column, :, column] = B[:, column]
    return np.concatenate([A, B, mixed.reshape(-1, dimensions)])


SAMPLERS: Mapping[str, Sampler] = MappingProxyType(
    {LHS: latin_hypercube, SOBOL: sobol, SALTELLI: saltelli, MONTECARLO: montecarlo}
)


@dataclass(frozen=True)
class Design(ABC):
    """The ranges of the varied values, by path, and their combination, which has a `name`."""

    name: str
    ranges: Mapping[str, Range]

    @property
    def paths(self) -> tuple[str, ...]:
        """The paths of the varied values."""
        return tuple(self.ranges)

    @property
    @abstractmethod
    def count(self) -> int:
        """The number of cases."""

    @abstractmethod
    def case(self, number: int) -> Case:
        """The values of case `number`."""


@dataclass(frozen=True)
class Grid(Design):
    """All combinations of the values; the last quantity varies fastest."""

    ranges: Mapping[str, Points]

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """The number of values of each quantity."""
        return tuple(each.count for each in self.ranges.values())

    @property
    def count(self) -> int:
        return prod(self.shape)

    def case(self, number: int) -> Case:
        items = []
        for each in reversed(tuple(self.ranges.values())):
            number, index = divmod(number, each.count)
            items.append(each.item(index))
        return tuple(reversed(items))


@dataclass(frozen=True)
class Zip(Design):
    """Case k has the k-th value of each quantity; a quantity with one value has it in all cases."""

    ranges: Mapping[str, Points]

    @property
    def count(self) -> int:
        return max(each.count for each in self.ranges.values())

    def case(self, number: int) -> Case:
        return tuple(each.item(number if each.count > 1 else 0) for each in self.ranges.values())


@dataclass(frozen=True)
class Sampled(Design):
    """Samples of the unit cube, whose coordinates are probabilities in the distributions of the quantities. `samples`
    is the requested number; Saltelli's design makes more."""

    samples: int
    seed: int

    @cached_property
    def shares(self) -> Array:
        """The samples (n, d), each above 0 and below 1."""
        inner = np.nextafter(0.0, 1.0), np.nextafter(1.0, 0.0)
        points = SAMPLERS[self.name](len(self.varying), self.samples, self.seed)
        return np.clip(points, *inner)

    @cached_property
    def varying(self) -> tuple[str, ...]:
        """The quantities that have more than one value."""
        return tuple(path for path, each in self.ranges.items() if not (isinstance(each, Points) and each.count == 1))

    @property
    def count(self) -> int:
        return self.samples * (len(self.varying) + 2 if self.name == SALTELLI else 1)

    def case(self, number: int) -> Case:
        shares = dict(zip(self.varying, self.shares[number].tolist(), strict=True))
        return tuple(each.quantile(shares.get(path, 0.5)) for path, each in self.ranges.items())


def design_of(
    ranges: Mapping[str, Range], name: str, samples: int | None, seed: int | None, reading: Reading
) -> Design | None:
    """The design of this name; None where these ranges do not allow it, which is reported."""
    before = len(reading.problems)
    if name in SAMPLERS:
        _check_samples(name, samples, reading)
        return Sampled(name, ranges, samples or 1, seed or 0) if len(reading.problems) == before else None
    for key, value in (("samples", samples), ("seed", seed)):
        if value is not None:
            hint = f"leave it out, or combine: {', '.join(SAMPLERS)}"
            reading.report(f"'{name}' takes no '{key}'", reading.places[(key,)], hint)
    points = {path: each for path, each in ranges.items() if isinstance(each, Points)}
    for path in ranges.keys() - points.keys():
        hint = f"combine: {', '.join(SAMPLERS)}, or list its values"
        reading.report(f"'{name}' cannot take a distribution", reading.places[("vary", path)], hint)
    if len(reading.problems) > before:
        return None
    if name == "grid":
        return Grid(name, points)
    _check_lengths(points, reading)
    return Zip(name, points) if len(reading.problems) == before else None


#: The combinations of ranges, by name; the first is the default.
COMBINATIONS = ("grid", "zip", *SAMPLERS)


def _check_samples(name: str, samples: int | None, reading: Reading) -> None:
    if samples is None:
        place = reading.places.get(("combine",))
        reading.report(f"'{name}' needs 'samples'", place, "add it: how many, a whole number")
    elif name in POWERS_OF_TWO and samples & (samples - 1):
        below = 1 << (samples.bit_length() - 1)
        hint = f"take {below} or {2 * below}"
        reading.report(f"'{name}' needs a power of 2 of samples, found {samples}", reading.places[("samples",)], hint)


def _check_lengths(points: Mapping[str, Points], reading: Reading) -> None:
    longest = max(points, key=lambda path: points[path].count)
    most = points[longest].count
    for path, each in points.items():
        if each.count not in (1, most):
            message = f"'{path}' has {each.count} values, and '{longest}' has {most}"
            reading.report(message, reading.places[("vary", path)], "zip takes ranges of one length")


# --- The file of a sweep ----------------------------------------------------------------------------------------------


FORMAT = "1"
#: The most values of a list, or cases of a zip, that are checked before the sweep. Any other value that does not fit
#: makes a failed case.
MOST = 300
#: The cases whose results files are kept.
KEEP = ("none", "failed", "all")
#: Columns of the summary that are neither parameters nor measures.
COLUMNS = ("case", "status", "message", "time", "joint", "formulation", "seconds", "file")
SPEC: Record[dict[str, Any]] = Record(
    "a sweep",
    {
        "sweep": NameChoice("format version", lambda: (FORMAT,)),
        "scene": Text(),
        "vary": ByPath(
            "path of a value of the scene: a range", RANGE, "say what varies, as in  parameters.length: 0.8:1.2:5"
        ),
        "combine": NameChoice("combination", lambda: COMBINATIONS),
        "samples": Integer(1),
        "seed": Integer(0),
        "measure": MEASURES,
        "keep": NameChoice("word for what to keep", lambda: KEEP),
    },
    dict,
    required=("sweep", "scene", "vary", "measure"),
)


@dataclass(frozen=True, eq=False)
class SweepSpec:
    """The content of a sweep's file. `units` are those of the parameters, by path, "" where unknown. `places` are those
    of the keys."""

    path: Path
    text: str = field(repr=False)
    scene: SceneText
    design: Design
    units: Mapping[str, str]
    measures: tuple[Expectation, ...]
    keep: str
    places: Mapping[KeyPath, Place] = field(repr=False)

    def place(self, *path: str | int) -> Place | None:
        """The place of a key in the file."""
        return self.places.get(path)

    @cached_property
    def _keys(self) -> Keys:
        return Keys(self.scene.whole)

    def key_of(self, case: Case) -> str:
        """The key of a case in the store; it does not depend on the order of the paths."""
        return self._keys.of(sorted(zip(self.design.paths, case, strict=True)))


def read_spec(path: Path) -> SweepSpec:
    """The sweep in the file at `path`. Raises InputError with every problem, at its place in the file or the scene."""
    text, root, reading = read_mapping(path, SPEC.what, f"it begins with 'sweep: {FORMAT}'")
    scene, base = scene_named(path, root, reading, SPEC)
    reading.items = items_of(base)
    blocks = SPEC.read(root, (), reading)
    if blocks is None:
        raise InputError(in_text_order(reading.problems))
    for complaint in complaints(blocks["measure"], base):
        reading.report(complaint.message, reading.places[complaint.path], complaint.hint)
    _check_names(blocks, reading)
    combine = blocks.get("combine", COMBINATIONS[0])
    design = design_of(blocks["vary"], combine, blocks.get("samples"), blocks.get("seed"), reading)
    if design is None or reading.problems:
        raise InputError(in_text_order(reading.problems))
    reading.problems += _misfits(scene, design, blocks["measure"], reading.places)
    if reading.problems:
        raise InputError(in_text_order(reading.problems))
    return SweepSpec(
        path=path,
        text=text,
        scene=scene,
        design=design,
        units=units_of({path: each.dimension for path, each in blocks["vary"].items()}, scene),
        measures=measures_of(blocks["measure"], base),
        keep=blocks.get("keep", KEEP[0]),
        places=reading.places,
    )


def _check_names(blocks: Mapping[str, Any], reading: Reading) -> None:
    """Report measures that have the name of another column of the summary."""
    taken = {column_of(path) for path in blocks["vary"]} | {*COLUMNS}
    for name in blocks["measure"]:
        if name in taken:
            place = reading.places[("measure", name)]
            reading.report(f"'{name}' is another column of the summary", place, "give the measure another name")


def _misfits(
    scene: SceneText, design: Design, measures: Mapping[str, ExpectationKeys], places: Mapping[KeyPath, Place]
) -> list[Problem]:
    """The problems that the scene's reader finds with values of the sweep, and the measures that runs with these values
    would not have."""
    problems: list[Problem] = []
    for changes in _probes(design, places):
        try:
            read = scene.scene(changes)
            settings = settings_to_run(read)
        except InputError as error:
            problems += error.problems
            continue
        for complaint in untimely(measures, settings):
            problems.append(Problem(complaint.message, places[complaint.path], complaint.hint))
    return list(dict.fromkeys(problems))


def _probes(design: Design, places: Mapping[KeyPath, Place]) -> Iterator[dict[str, Change]]:
    """Yield cases such that each value written in the file occurs."""
    where = {path: places[("vary", path)] for path in design.paths}
    if isinstance(design, Zip):
        for number in range(min(design.count, MOST)):
            nodes = {path: _node(each, number, where[path]) for path, each in design.ranges.items()}
            yield {path: Change(node, where[path]) for path, node in nodes.items()}
        return
    first = {path: Change(each.nodes[0], where[path]) for path, each in design.ranges.items()}
    yield first
    for path, each in design.ranges.items():
        for node in each.nodes[1:MOST]:
            yield first | {path: Change(node, where[path])}


def _node(values: Points, number: int, place: Place) -> Node:
    """A value as written in the file, or as a number where it follows from the ends of a range."""
    if isinstance(values, Listed):
        return values.nodes[number if values.count > 1 else 0]
    ends = {0: 0, values.count - 1: 1}
    return values.nodes[ends[number]] if number in ends else from_value(values.item(number), place)
