"""The wheels of gears, drawn at their pitch circles on the second body of each coupled joint, and the two parts of a
Geneva drive."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.pages.appearance.parts import Solid, bar, cylinder, triad
from mbproj.pages.appearance.plates import Outline, track

#: Axes are parallel where the sine of their angle is below this.
PARALLEL = 1e-6


def radii(points: Sequence[Array], axes: Sequence[Array], teeth: Sequence[float]) -> tuple[float, float] | None:
    """The pitch radii of two wheels with `teeth` (negative for inner teeth) about global axes (3,) through `points`.
    None where the axes are not parallel, or coincide, as these give no radii."""
    first, second = (axis / np.linalg.norm(axis) for axis in axes)
    if np.linalg.norm(np.cross(first, second)) > PARALLEL:
        return None
    between = points[1] - points[0]
    distance = float(np.linalg.norm(between - (between @ first) * first))
    whole = abs(teeth[0] + teeth[1])
    if distance == 0.0 or whole == 0.0:
        return None
    return abs(teeth[0]) * distance / whole, abs(teeth[1]) * distance / whole


def wheel(point: Array, axis: Array, normal: Array, radius: float, r: float) -> Iterator[Solid]:
    """A ring with two spokes, for links with the radius r."""
    yield Solid("tube", (radius + 0.3 * r, max(radius - 1.2 * r, 0.5 * radius), 1.2 * r), point, triad(axis, normal))
    for spoke in (normal, np.cross(axis, normal)):
        yield bar(point - 0.9 * radius * spoke, point + 0.9 * radius * spoke, 0.4 * r)[0]


def pin(point: Array, axis: Array, along: Array, crank: float, r: float) -> Iterator[Solid]:
    """The arm of a Geneva driver with its pin."""
    yield bar(point, point + crank * along, r)[0]
    yield cylinder(0.7 * r, 4.0 * r, point + crank * along, axis)


def slotted(point: Array, axis: Array, along: Array, distance: float, slots: int, r: float) -> Solid:
    """The slotted wheel of a Geneva drive, with one slot in the direction `along`. Slots reach as far as the pin comes,
    and widen outward so that the whole rim is visible from the centre."""
    rim, bottom = distance * np.cos(np.pi / slots), distance * (1.0 - np.sin(np.pi / slots)) - 0.8 * r
    wide, step = 0.8 * r / rim, 2.0 * np.pi / slots
    corners = []
    for slot in range(slots):
        angles = slot * step + np.linspace(wide, step - wide, 7)
        corners += [(bottom, slot * step - 0.9 * wide), (bottom, slot * step + 0.9 * wide), *((rim, a) for a in angles)]
    radius, angle = np.array(corners).T
    outline = Outline(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]), True, True, 0.0, 0.0)
    return track(outline, point, triad(axis, along), r)
