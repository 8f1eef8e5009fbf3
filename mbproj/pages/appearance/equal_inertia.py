"""The homogeneous solid with a body's mass and moments of inertia, drawn for a body without shapes."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.pages.appearance.parts import Solid, box, triad

#: The relative difference of two principal moments up to which they count as equal.
ROUND = 1e-6


def solid_of(mass: float, inertia: Array, thinnest: float) -> Solid | None:
    """A cylinder where two principal moments are equal, otherwise a box, in body axes about the centre of mass.

    No edge is thinner than `thinnest`. None for a body without mass or moments, because a point has no size."""
    if mass <= 0.0:
        return None
    moments, axes = np.linalg.eigh(np.asarray(inertia, dtype=float))
    if moments[2] <= 0.0:
        return None
    low, middle, high = moments / mass
    if high - middle <= ROUND * high:
        return _cylinder(low, high, axes[:, 0], axes[:, 2], thinnest)
    if middle - low <= ROUND * high:
        return _cylinder(high, low, axes[:, 2], axes[:, 0], thinnest)
    squares = 6.0 * (np.array([middle + high - low, low + high - middle, low + middle - high]))
    edges = np.maximum(np.sqrt(np.maximum(squares, 0.0)), thinnest)
    return box(edges.tolist(), np.zeros(3), triad(axes[:, 2], axes[:, 0]))


def _cylinder(axial: float, across: float, axis: Array, normal: Array, thinnest: float) -> Solid:
    """A cylinder of mass 1: C = R²/2 along its axis, A = (3R² + L²)/12 across."""
    radius = max(np.sqrt(2.0 * axial), 0.5 * thinnest)
    length = max(np.sqrt(max(12.0 * across - 6.0 * axial, 0.0)), thinnest)
    return Solid("cylinder", (float(radius), float(length)), np.zeros(3), triad(axis, normal))
