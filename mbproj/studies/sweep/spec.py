"""The cases of a sweep: every combination of the values, one after another, or samples of the unit cube."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import cached_property
from math import prod
from types import MappingProxyType
from typing import TypeAlias

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.scene.fields.reading import Reading
from mbproj.scene.ranges import Item, Points, Range

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
    for key, given in (("samples", samples), ("seed", seed)):
        if given is not None:
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
