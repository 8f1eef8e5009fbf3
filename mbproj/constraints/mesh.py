"""Threads and teeth: two motions coupled by something periodic, so that whole turns need no counting."""

from __future__ import annotations

from abc import abstractmethod
from typing import final

import numpy as np

from mbproj.arrays import Numbers
from mbproj.constraints.along import Along
from mbproj.constraints.angle import Angle
from mbproj.constraints.primitive import Primitive
from mbproj.dataclass import dataclass

_ALONG, _ANGLE = Along(), Angle()


class Mesh(Primitive):
    """A weighed sum of two joint coordinates, one on the first three slots and one on the others, less the nearest
    multiple of a period: one tooth, or one thread. Who counts the turns of angles knows which multiple it is."""

    @property
    @abstractmethod
    def weights(self) -> tuple[float, float]:
        """What the two coordinates count in the row."""

    @property
    @abstractmethod
    def period(self) -> float:
        """One tooth or thread, in the unit of the row."""


@final
@dataclass(frozen=True)
class Screw(Mesh):
    """C = s - pitch φ / 2π in metres, with the displacement s along z1 and the angle φ about it, to the nearest thread.

    `pitch` is the advance a turn in m, positive for a right-handed screw. Slots: z1, p1, p2 of s; x1, y1, x2 of φ.
    """

    pitch: float

    parameters = ("pitch",)
    slots = ("vector", "point", "point", "vector", "vector", "vector")
    rows = 1
    unit = "m"

    @property
    def lead(self) -> float:
        """The advance a radian, m."""
        return self.pitch / (2.0 * np.pi)

    @property
    def weights(self) -> tuple[float, float]:
        return 1.0, -self.lead

    @property
    def period(self) -> float:
        return abs(self.pitch)

    def value(self, x: Numbers) -> Numbers:
        return self.lead * _nearest(_ALONG.value(x[..., :3, :]) / self.lead - _ANGLE.value(x[..., 3:, :]))

    def gradient(self, x: Numbers) -> Numbers:
        turning = -self.lead * _ANGLE.gradient(x[..., 3:, :])
        return np.concatenate([_ALONG.gradient(x[..., :3, :]), turning], axis=-2)

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        sliding = _ALONG.curvature(x[..., :3, :], x_dot[..., :3, :])
        return sliding - self.lead * _ANGLE.curvature(x[..., 3:, :], x_dot[..., 3:, :])


@final
@dataclass(frozen=True)
class Gear(Mesh):
    """C = (n1 φ1 + n2 φ2) / max(|n1|, |n2|) in radians, to the nearest tooth, for wheels of n1 and n2 `teeth`.

    φ1 and φ2 are the angles of two joints; opposite signs of n1 and n2 make an internal gear or a belt. Slots: x1, y1,
    x2 of the one joint, then of the other.
    """

    teeth: tuple[float, float]

    parameters = ("teeth",)
    slots = ("vector",) * 6
    rows = 1
    unit = "rad"

    @property
    def larger(self) -> float:
        """The larger number of teeth."""
        return max(abs(teeth) for teeth in self.teeth)

    @property
    def weights(self) -> tuple[float, float]:
        first, second = self.teeth
        return first / self.larger, second / self.larger

    @property
    def period(self) -> float:
        return 2.0 * np.pi / self.larger

    def value(self, x: Numbers) -> Numbers:
        first, second = self.teeth
        turned = first * _ANGLE.value(x[..., :3, :]) + second * _ANGLE.value(x[..., 3:, :])
        return _nearest(turned) / self.larger

    def gradient(self, x: Numbers) -> Numbers:
        first, second = self.weights
        return np.concatenate(
            [first * _ANGLE.gradient(x[..., :3, :]), second * _ANGLE.gradient(x[..., 3:, :])], axis=-2
        )

    def curvature(self, x: Numbers, x_dot: Numbers) -> Numbers:
        first, second = self.weights
        one = _ANGLE.curvature(x[..., :3, :], x_dot[..., :3, :])
        return first * one + second * _ANGLE.curvature(x[..., 3:, :], x_dot[..., 3:, :])


def _nearest(angle: Numbers) -> Numbers:
    """The angle less its whole turns, within [-π, π]."""
    return angle - 2.0 * np.pi * np.round(angle.real / (2.0 * np.pi))
