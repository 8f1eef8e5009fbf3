"""Beams on points under them, as rows of contacts."""

from __future__ import annotations

import numpy as np

from tests.laws import Cone

MASS, INERTIA, WEIGHT, HEIGHT = 3.0, 0.2, 30.0, 0.25


def beam(places, force, arm):
    """B and b of a beam on points under it: rows of the gaps, then of what slides along; pushed at an `arm` above."""
    gaps = np.array([[0.0, 1.0, x] for x in places])
    along = np.array([[1.0, 0.0, HEIGHT] for _ in places])
    rows = np.vstack([gaps, along])
    inverse = np.diag([1.0 / MASS, 1.0 / MASS, 1.0 / INERTIA])
    return rows @ inverse @ rows.T, rows @ inverse @ [force, -WEIGHT, -force * arm]


def feet(count, most, slides=()):
    return [Cone(k, (count + k,), most, slides) for k in range(count)]
