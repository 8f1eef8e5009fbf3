"""Rows that couple coordinates of joints: threads, teeth, a rack with its pinion, a cam with its follower."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise
from types import MappingProxyType
from typing import Literal, Protocol, final

import numpy as np

from mbproj.base.arrays import Numbers
from mbproj.base.dataclass import dataclass
from mbproj.joints.primitives.basic import Along, Angle, Distance, Primitive, SlotKind


class CoordinateFunction(Protocol):
    """Interface of a function of a coordinate (...), which may be complex, with its first and second derivative."""

    def __call__(self, s: Numbers) -> tuple[Numbers, Numbers, Numbers]: ...

    def on_branches(self, held: tuple[float, ...]) -> CoordinateFunction:
        """Return the function with its switches on these branches."""


#: The primitives that can be coupled, each of one row.
COORDINATES: Mapping[str, Primitive] = MappingProxyType({"angle": Angle(), "along": Along(), "distance": Distance()})


@final
@dataclass(frozen=True)
class Coupling(Primitive):
    """C = Σ kᵢ sᵢ - f(s₀) of coordinates sᵢ, less the nearest multiple of `period`: one tooth, or one thread; 0 for
    none.

    `coordinates` are names in COORDINATES, or a further name for the primitive `other`; `weights` are the kᵢ. The row
    and its period are in metres where one of the coordinates is a length. The slots are those of the first coordinate,
    then those of the next. The multiple follows from counted turns of angles. So a turn of an angle s₀ must change f by
    a whole number of periods, or by 0.
    """

    coordinates: tuple[str, ...]
    weights: tuple[float, ...]
    period: float
    function: CoordinateFunction | None = None
    other: Primitive | None = None

    rows = 1
    follows = "coordinates"
    off_plane = "couples coordinates that are not in the plane"

    @property
    def slots(self) -> tuple[SlotKind, ...]:
        """The kind of each slot: point or vector."""
        return tuple(slot for each in self._primitives() for slot in each.slots)

    @property
    def unit(self) -> Literal["m", "rad"]:
        """The unit of the row: m where a coordinate is a length, or stands for one."""
        return "rad" if {*self.coordinates} <= {"angle"} else "m"

    @property
    def rolls(self) -> bool:
        """Whether the row is that of a roller on a curve. The lap, which is the period, and the roller's turn have no
        common measure."""
        return self.coordinates[0] == "lap"

    @property
    def growth(self) -> float:
        """The change of f by a turn of s₀: whole periods, up to round-off."""
        if self.function is None or self.coordinates[0] != "angle":
            return 0.0
        first, last = self.function(np.array([-np.pi, np.pi]))[0].real.tolist()
        return float(self.period * np.round((last - first) / self.period)) if self.period else 0.0

    def _primitives(self) -> list[Primitive]:
        terms = [COORDINATES.get(name, self.other) for name in self.coordinates]
        return [each for each in terms if each is not None]

    def terms(self) -> Iterator[tuple[Primitive, float, slice]]:
        """Yield each coordinate, its weight, and its slots."""
        primitives = self._primitives()
        ends = np.cumsum([0, *(len(each.slots) for each in primitives)]).tolist()
        for primitive, weight, (first, end) in zip(primitives, self.weights, pairwise(ends), strict=True):
            yield primitive, weight, slice(first, end)

    def on_branches(self, held: tuple[float, ...]) -> Coupling:
        """Return the coupling with its function on these branches."""
        return self if self.function is None else replace(self, function=self.function.on_branches(held))

    def value(self, x: Numbers) -> Numbers:
        total = self._sum(lambda primitive, slots: primitive.value(x[..., slots, :]))
        if self.function is not None:
            total = total - self._curve(x)[0]
        return total - self.period * np.round(total.real / self.period) if self.period else total

    def gradient(self, x: Numbers) -> Numbers:
        parts = [weight * primitive.gradient(x[..., slots, :]) for primitive, weight, slots in self.terms()]
        if self.function is not None:
            first, _, slots = next(self.terms())
            parts[0] = parts[0] - self._curve(x)[1][..., None, None] * first.gradient(x[..., slots, :])
        return np.concatenate(parts, axis=-2)

    def rate(self, x: Numbers, x_dot: Numbers) -> Numbers:
        total = self._sum(lambda primitive, slots: primitive.rate(x[..., slots, :], x_dot[..., slots, :]))
        return total if self.function is None else total - self._curve(x)[1] * self._first_rate(x, x_dot)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        total = self._sum(lambda primitive, slots: primitive.curvature(x[..., slots, :], x_dot[..., slots, :]))
        if self.function is None:
            return total
        (first, _, slots), (_, slope, bend) = next(self.terms()), self._curve(x)
        of_first = first.curvature(x[..., slots, :], x_dot[..., slots, :])
        return total - slope * of_first - bend * self._first_rate(x, x_dot) ** 2

    def _curve(self, x: Numbers) -> tuple[Numbers, Numbers, Numbers]:
        """Return f, f' and f'' at s₀."""
        assert self.function is not None
        first, _, slots = next(self.terms())
        return self.function(first.value(x[..., slots, :]))

    def _first_rate(self, x: Numbers, x_dot: Numbers) -> Numbers:
        """Return s₀'."""
        first, _, slots = next(self.terms())
        return first.rate(x[..., slots, :], x_dot[..., slots, :])

    def _sum(self, of: Callable[[Primitive, slice], Numbers]) -> Numbers:
        first, *others = [weight * of(primitive, slots) for primitive, weight, slots in self.terms()]
        for other in others:
            first = first + other
        return first
