"""Stops, which limit joint coordinates, distances and points, as frozen records in SI units and radians."""

from __future__ import annotations

import math
from collections.abc import Iterator

from mbproj.dataclass import dataclass

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class StopLaw:
    """The law of a stop: rigid where `stiffness` is infinite, else a push of stiffness δ^exponent (1 + c δ').

    Either `restitution` is given, the ratio of the speed after a free impact to the speed of approach, or `damping`,
    c in s/m or s/rad; the other is None.
    """

    stiffness: float = math.inf
    exponent: float = 1.0
    restitution: float | None = None
    damping: float | None = None


@dataclass(frozen=True)
class Limit:
    """The lower and the upper bound of a scalar coordinate, in m or rad; None for no bound."""

    low: float | None
    high: float | None
    law: StopLaw

    def sides(self) -> Iterator[tuple[int, float]]:
        """The sides that have a bound, as (side, bound): 0 is the lower side, 1 the upper one."""
        return ((at, bound) for at, bound in enumerate((self.low, self.high)) if bound is not None)

    def names(self, joint: str, coordinate: str) -> list[str]:
        """The names in results of the sides of a joint's limit."""
        return [f"{joint}.{coordinate}.{('low', 'high')[at]}" for at, _ in self.sides()]


@dataclass(frozen=True)
class OfBody:
    """A point or a direction of a body: global at the scene's pose, or in the body's own axes (a point from its centre
    of mass) where `local`."""

    body: str
    vector: Vector
    local: bool = False


@dataclass(frozen=True)
class DistanceStop:
    """A stop that keeps the distance of a point of one body from a point of another within `limit`."""

    name: str
    first: OfBody
    second: OfBody
    limit: Limit

    @property
    def stops(self) -> list[str]:
        """The names in results of the stop's sides: its own name where it has one side."""
        words = [("shortest", "longest")[at] for at, _ in self.limit.sides()]
        return [self.name] if len(words) == 1 else [f"{self.name}.{word}" for word in words]


@dataclass(frozen=True)
class PlaneFriction:
    """Dry friction of a point, ball or wheel on a plane: coefficients of the push while it slides and while it sticks.
    `stribeck_speed` in m/s is the speed over which the static one falls to the sliding one; None: it falls at once."""

    sliding: float
    static: float
    stribeck_speed: float | None = None


@dataclass(frozen=True)
class PlaneStop:
    """A stop that keeps a ball of `radius` in m (0: a point) around `point` on the side of a plane to which `normal`
    points.

    With an `axis`, a direction of the point's body, it is a wheel: a thin disk about that axis."""

    name: str
    location: OfBody
    normal: OfBody
    point: OfBody
    radius: float
    law: StopLaw
    friction: PlaneFriction | None = None
    axis: OfBody | None = None

    @property
    def stops(self) -> list[str]:
        """The name in results of the stop, as a list of one."""
        return [self.name]

    @property
    def frictions(self) -> list[str]:
        """The names in results of its friction along each of the two tangents of the plane."""
        return [] if self.friction is None else [f"{self.name}.{tangent}" for tangent in (1, 2)]
