"""Ranges as records: those with a finite number of values, and distributions, which are sampled."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import field
from math import exp, log
from statistics import NormalDist
from typing import TypeAlias

from mbproj.dataclass import dataclass
from mbproj.scene.expressions.units import Dimension
from mbproj.scene.text.nodes import Node

#: A value: a number in SI, or a word, or a list or mapping in YAML's flow style.
Item: TypeAlias = "float | str"


@dataclass(frozen=True)
class Range(ABC):
    """A range of a quantity. `nodes` are its values as written, which the reader of the quantity checks; `dimension` is
    that of its numbers, None where it is not known."""

    nodes: tuple[Node, ...] = field(repr=False, compare=False)
    dimension: Dimension | None

    @abstractmethod
    def quantile(self, share: float) -> Item:
        """The value below which this share of samples lies, 0 < share < 1; `Points` are sampled evenly."""


@dataclass(frozen=True)
class Points(Range):
    """A range with a finite number of values."""

    @property
    @abstractmethod
    def count(self) -> int:
        """The number of values."""

    @abstractmethod
    def item(self, number: int) -> Item:
        """The value with this number, from 0."""

    @property
    def items(self) -> tuple[Item, ...]:
        """All values, in order."""
        return tuple(map(self.item, range(self.count)))


@dataclass(frozen=True)
class Listed(Points):
    """A range of values that are listed one by one."""

    given: tuple[Item, ...]

    @property
    def count(self) -> int:
        return len(self.given)

    def item(self, number: int) -> Item:
        return self.given[number]

    def quantile(self, share: float) -> Item:
        return self.given[min(int(share * len(self.given)), len(self.given) - 1)]


@dataclass(frozen=True)
class Spaced(Points):
    """`count` values from `first` to `last`, evenly spaced, or evenly by their logarithms."""

    first: float
    last: float
    steps: int
    logarithmic: bool = False

    @property
    def count(self) -> int:
        return self.steps

    def item(self, number: int) -> float:
        if number == self.steps - 1:
            return self.last
        return self.quantile(number / (self.steps - 1)) if number else self.first

    def quantile(self, share: float) -> float:
        if self.logarithmic:
            return exp(log(self.first) + share * (log(self.last) - log(self.first)))
        return self.first + share * (self.last - self.first)


@dataclass(frozen=True)
class Uniform(Range):
    """The uniform distribution between `low` and `high`."""

    low: float
    high: float

    def quantile(self, share: float) -> float:
        return self.low + share * (self.high - self.low)


@dataclass(frozen=True)
class Normal(Range):
    """The normal distribution of this mean and standard deviation."""

    mean: float
    deviation: float

    def quantile(self, share: float) -> float:
        return NormalDist(self.mean, self.deviation).inv_cdf(share)
