"""What joints and points may not pass, as frozen records in SI units and radians."""

from __future__ import annotations

import math
from collections.abc import Iterator

from mbproj.dataclass import dataclass

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class StopLaw:
    """What a stop does: rigid where `stiffness` is infinite, or else it pushes with stiffness δ^exponent (1 + c δ').

    Either `restitution` is given, the part of the speed of approach with which a free impact ends, or `damping`, c in
    s/m or s/rad; the other is None.
    """

    stiffness: float = math.inf
    exponent: float = 1.0
    restitution: float | None = None
    damping: float | None = None


@dataclass(frozen=True)
class Limit:
    """The least and the most that a scalar coordinate may be, in m or rad; None: as little, as much as it likes."""

    low: float | None
    high: float | None
    law: StopLaw

    def sides(self) -> Iterator[tuple[int, float]]:
        """Those that are not open: 0 for the least and 1 for the most, and the bound."""
        return ((at, bound) for at, bound in enumerate((self.low, self.high)) if bound is not None)

    def names(self, joint: str, coordinate: str) -> list[str]:
        """What results call the sides of a joint's limit."""
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
    """The distance of a point of one body from one of another stays within `limit`."""

    name: str
    first: OfBody
    second: OfBody
    limit: Limit

    @property
    def stops(self) -> list[str]:
        """What results call its sides: by its own name where it has but one."""
        words = [("shortest", "longest")[at] for at, _ in self.limit.sides()]
        return [self.name] if len(words) == 1 else [f"{self.name}.{word}" for word in words]


@dataclass(frozen=True)
class PlaneFriction:
    """Dry friction of a point, ball or wheel on a plane: coefficients of the push while it slides and while it sticks.
    `stribeck_speed` in m/s is that over which the one falls to the other, None where it falls at once."""

    sliding: float
    static: float
    stribeck_speed: float | None = None


@dataclass(frozen=True)
class PlaneStop:
    """A ball of `radius` in m (0: a point) around `point` stays on that side of a plane to which `normal` points.

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
        """What results call it."""
        return [self.name]

    @property
    def frictions(self) -> list[str]:
        """What results call its friction along either tangent of the plane."""
        return [] if self.friction is None else [f"{self.name}.{tangent}" for tangent in (1, 2)]
