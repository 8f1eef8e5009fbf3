"""Turns of the joints' angles, counted from step to step.

A pose knows an angle but for whole turns. A step takes it on by its rates: by the trapezoidal rule or, where the pose
is not known there, by the stages of the step; its motion leads a driven one, however many turns that makes. Where the
pose is not there either, the step is too coarse to tell the turns.
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.motions import Drive
from mbproj.dynamics.equations.teeth import near
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

#: Steps that turn no joint by more, in rad, can tell: RK4 is off by 0.04 rad then, methods of order 1 and 2 by more.
HALF_TURN = np.pi


@dataclass(frozen=True)
class Slip:
    """A step that cannot tell turns: the `coordinate`, how far it turns in the step, and how far from that the pose
    comes out, in rad."""

    coordinate: int
    turned: float
    off: float

    @property
    def shorter(self) -> float:
        """The part of the step in which it turns by half a turn at most; half of the step, where that is shorter."""
        return min(0.5, HALF_TURN / self.turned) if self.turned > 0.0 else 0.5


@dataclass(frozen=True, eq=False)
class Turning:
    """The joints' coordinates (nc,) at time t in s, turns counted, and their rates; `prescribed` (k,) by motions."""

    t: float
    coordinate: Array
    speed: Array
    prescribed: Array

    def by_rates(self, t: float, speed: Array) -> Array:
        """By how much the coordinates change until t, where their rates are `speed`, (nc,): the trapezoidal rule."""
        return 0.5 * (t - self.t) * (self.speed + speed)

    def count(self, system: System, coordinate: Array, change: Array, drive: Drive) -> tuple[Array, Slip | None]:
        """The joints' coordinates (nc,) with turns after a step in which they `change` (nc,) by their rates, driven
        ones as their motions do; and the one whose turns can be told least, where that is not well enough."""
        change = driven_to(system, change, drive.value - self.prescribed)
        expected = self.coordinate + change
        counted = near(system, coordinate, expected)
        off = np.where(system.coordinates.is_length, 0.0, np.abs(counted - expected))
        if off.max(initial=0.0) <= THRESHOLDS.turns_told:
            return counted, None
        worst = int(np.argmax(off))
        return counted, Slip(worst, float(abs(change[worst])), float(off[worst]))

    def between(self, system: System, after: Turning, t: float, drive: Drive) -> Array:
        """The coordinates (nc,) at a time before that of another state, on the cubics through both; driven ones where
        their motions are."""
        h = after.t - self.t
        s = (t - self.t) / h
        rest = 1.0 - s
        first = rest**2 * ((1.0 + 2.0 * s) * self.coordinate + s * h * self.speed)
        last = s**2 * ((1.0 + 2.0 * rest) * after.coordinate - rest * h * after.speed)
        return driven_to(system, first + last, drive.value)

    def far(self, system: System, t: float) -> Slip | None:
        """The joint coordinate that turns by most on the way to t, where that is more than half a turn."""
        turned = np.where(system.coordinates.is_length, 0.0, np.abs((t - self.t) * self.speed))
        if turned.max(initial=0.0) <= HALF_TURN:
            return None
        worst = int(np.argmax(turned))
        return Slip(worst, float(turned[worst]), 0.0)


def driven_to(system: System, coordinate: Array, value: Array) -> Array:
    """What is known of joint coordinates (nc,), with `value` (k,) for those that motions drive."""
    found = coordinate.copy()
    found[system.motions.joint_coordinate] = value
    return found


def turns_of(system: System, counted: Array, coordinate: Array) -> Integers:
    """The whole turns (..., nc) between coordinates with and without them."""
    return np.round((counted - coordinate) / (2.0 * np.pi)).astype(np.intp) * ~system.coordinates.is_length
