"""Coordinates of joints that one row couples: threads, teeth, a rack with its pinion."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise
from types import MappingProxyType
from typing import Literal, final

import numpy as np

from mbproj.arrays import Numbers
from mbproj.constraints.along import Along
from mbproj.constraints.angle import Angle
from mbproj.constraints.primitive import Primitive, SlotKind
from mbproj.dataclass import dataclass

#: The primitives that can be coupled, each of one row.
COORDINATES = MappingProxyType({"angle": Angle(), "along": Along()})


@final
@dataclass(frozen=True)
class Coupling(Primitive):
    """C = Σ kᵢ sᵢ of coordinates sᵢ, less the nearest multiple of `period`: one tooth, or one thread.

    `coordinates` are names in COORDINATES, `weights` the kᵢ. The row and its period are in metres where one of them is
    a length. The slots are those of the first coordinate, then those of the next. Who counts the turns of angles knows
    which multiple it is.
    """

    coordinates: tuple[str, ...]
    weights: tuple[float, ...]
    period: float

    rows = 1

    @property
    def slots(self) -> tuple[SlotKind, ...]:
        """What each point or vector is."""
        return tuple(slot for name in self.coordinates for slot in COORDINATES[name].slots)

    @property
    def unit(self) -> Literal["m", "rad"]:
        """m where a coordinate is a length."""
        return "m" if "along" in self.coordinates else "rad"

    def parts(self) -> Iterator[tuple[Primitive, float, slice]]:
        """Each coordinate, its weight, and its slots."""
        own = [COORDINATES[name] for name in self.coordinates]
        ends = np.cumsum([0, *(len(each.slots) for each in own)]).tolist()
        for primitive, weight, (first, end) in zip(own, self.weights, pairwise(ends), strict=True):
            yield primitive, weight, slice(first, end)

    def value(self, x: Numbers) -> Numbers:
        total = self._sum(lambda primitive, slots: primitive.value(x[..., slots, :]))
        return total - self.period * np.round(total.real / self.period)

    def gradient(self, x: Numbers) -> Numbers:
        parts = [weight * primitive.gradient(x[..., slots, :]) for primitive, weight, slots in self.parts()]
        return np.concatenate(parts, axis=-2)

    def rate(self, x: Numbers, x_dot: Numbers) -> Numbers:
        return self._sum(lambda primitive, slots: primitive.rate(x[..., slots, :], x_dot[..., slots, :]))

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        return self._sum(lambda primitive, slots: primitive.curvature(x[..., slots, :], x_dot[..., slots, :]))

    def _sum(self, of: Callable[[Primitive, slice], Numbers]) -> Numbers:
        first, *others = [weight * of(primitive, slots) for primitive, weight, slots in self.parts()]
        for other in others:
            first = first + other
        return first
