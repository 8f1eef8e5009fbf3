"""The wheels of a gear: a ring on the second body of each of the two joints that it couples, at their pitch circles."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.pages.look.parts import Part, bar, triad

#: Axes are parallel where the sine of their angle is below this.
PARALLEL = 1e-6


def radii(points: Sequence[Array], axes: Sequence[Array], teeth: Sequence[float]) -> tuple[float, float] | None:
    """The pitch radii of wheels with `teeth` (a negative number: teeth inside) about two global axes (3,) through
    `points`; None where the axes are not parallel, or are one, so that the scene does not say them."""
    first, second = (axis / np.linalg.norm(axis) for axis in axes)
    if np.linalg.norm(np.cross(first, second)) > PARALLEL:
        return None
    between = points[1] - points[0]
    distance = float(np.linalg.norm(between - (between @ first) * first))
    whole = abs(teeth[0] + teeth[1])
    if distance == 0.0 or whole == 0.0:
        return None
    return abs(teeth[0]) * distance / whole, abs(teeth[1]) * distance / whole


def wheel(point: Array, axis: Array, normal: Array, radius: float, r: float) -> Iterator[Part]:
    """A ring with two spokes, r thick."""
    yield Part("tube", (radius + 0.3 * r, max(radius - 1.2 * r, 0.5 * radius), 1.2 * r), point, triad(axis, normal))
    for spoke in (normal, np.cross(axis, normal)):
        yield bar(point - 0.9 * radius * spoke, point + 0.9 * radius * spoke, 0.4 * r)[0]
