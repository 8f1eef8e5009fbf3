"""What a program's file hands over."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import isfinite
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
#: Samples, evenly spread, of so many seconds.
SAMPLES, END = 10, 0.2
TIMES = np.linspace(0.0, END, SAMPLES + 1)[1:]


class Problem(Protocol):
    """A mechanism in the coordinates of the equations that are derived by hand for it."""

    @property
    def k(self) -> float:
        """Its dial, N/m."""

    @property
    def name(self) -> str:
        """For tables."""

    @property
    def start(self) -> Array:
        """Coordinates and speeds at the start, (2n,)."""

    def slope(self, _: float, y: Array) -> Array:
        """y'."""

    def points(self, angles: Array) -> Array:
        """Where errors are measured: two points (..., 4), m, for coordinates (..., n)."""


class NotDone(Exception):
    """A setting with which a program does not finish."""


@dataclass(frozen=True)
class Setting:
    """A step or a tolerance. `run` gives the seconds of processor time of the integration alone, and the points at the
    samples (T, 4); it may raise NotDone."""

    label: str
    run: Callable[[], tuple[float, Array]]


@dataclass(frozen=True)
class Program:
    """A program as it is used here, with its settings from coarse to fine and the accelerations of the coordinates
    that it finds at the start."""

    name: str
    settings: Callable[[], Iterator[Setting]]
    accelerations: Callable[[], Array]


def off(points: Array, reference: Array) -> float:
    """The largest distance of a point, m."""
    pairs = (points - reference).reshape(len(points), -1, 2)
    found = float(np.linalg.norm(pairs, axis=2).max())
    return found if isfinite(found) else np.inf


def steps() -> Iterator[int]:
    """Fixed steps between two samples, two to each doubling."""
    return (round(2.0 ** (k / 2)) for k in range(1, 29))


def tolerances(tightest: int) -> Iterator[float]:
    """From 1e-2 on, three to each decade."""
    return (10.0 ** (-k / 3) for k in range(6, 3 * tightest + 1))
