"""Whole turns of the joints' angles, counted from step to step.

A pose determines an angle up to whole turns. The rates of a step predict the change of the angle. The prediction uses
the trapezoidal rule, or the stages of the step where the pose at its end is not known. A driven angle follows its
motion, however many turns that is. Where the pose differs too much from the prediction, the step is too coarse to count
turns.
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.motions import Drive
from mbproj.dynamics.equations.teeth import near
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

#: The turn of a joint in one step, in rad, up to which turns can be counted: RK4 is off by 0.04 rad then, methods of
#: order 1 and 2 by more.
HALF_TURN = np.pi


@dataclass(frozen=True)
class UncertainTurn:
    """A step that is too long to count turns: the `coordinate`, by what it `turned` in the step, and how far the
    prediction is `off`, both in rad."""

    coordinate: int
    turned: float
    off: float

    @property
    def shorter(self) -> float:
        """The part of the step in which the coordinate turns by half a turn at most; half of the step, where that is
        shorter."""
        return min(0.5, HALF_TURN / self.turned) if self.turned > 0.0 else 0.5


@dataclass(frozen=True, eq=False)
class Turning:
    """The joints' coordinates (nc,) with turns at time t in s, and their rates; `prescribed` (k,): the motions'
    values."""

    t: float
    coordinate: Array
    speed: Array
    prescribed: Array

    def by_rates(self, t: float, speed: Array) -> Array:
        """Return the change of the coordinates until t, (nc,), where their rates are `speed`, by the trapezoidal
        rule."""
        return 0.5 * (t - self.t) * (self.speed + speed)

    def count(
        self, system: System, coordinate: Array, change: Array, drive: Drive
    ) -> tuple[Array, UncertainTurn | None]:
        """Return the joints' coordinates (nc,) with turns after a step, and the worst turn that is uncertain, if any.

        The prediction is `change` (nc,); driven coordinates follow their motions."""
        change = driven_to(system, change, drive.value - self.prescribed)
        expected = self.coordinate + change
        counted = near(system, coordinate, expected)
        off = np.where(system.coordinates.is_length, 0.0, np.abs(counted - expected))
        if off.max(initial=0.0) <= THRESHOLDS.turns_told:
            return counted, None
        worst = int(np.argmax(off))
        return counted, UncertainTurn(worst, float(abs(change[worst])), float(off[worst]))

    def between(self, system: System, after: Turning, t: float, drive: Drive) -> Array:
        """Return the coordinates (nc,) at a time between two states, on the cubics through both; driven ones at the
        values of their motions."""
        h = after.t - self.t
        s = (t - self.t) / h
        rest = 1.0 - s
        first = rest**2 * ((1.0 + 2.0 * s) * self.coordinate + s * h * self.speed)
        last = s**2 * ((1.0 + 2.0 * rest) * after.coordinate - rest * h * after.speed)
        return driven_to(system, first + last, drive.value)

    def far(self, system: System, t: float) -> UncertainTurn | None:
        """Return the joint coordinate that turns most until t; None where it turns by half a turn or less."""
        turned = np.where(system.coordinates.is_length, 0.0, np.abs((t - self.t) * self.speed))
        if turned.max(initial=0.0) <= HALF_TURN:
            return None
        worst = int(np.argmax(turned))
        return UncertainTurn(worst, float(turned[worst]), 0.0)


def driven_to(system: System, coordinate: Array, value: Array) -> Array:
    """Return joint coordinates (nc,) with `value` (k,) in place of those that motions drive."""
    coordinates = coordinate.copy()
    coordinates[system.motions.joint_coordinate] = value
    return coordinates


def turns_of(system: System, counted: Array, coordinate: Array) -> Integers:
    """Return the whole turns (..., nc) between coordinates with and without them."""
    # A length may be NaN, where a rope's circles overlap.
    off = np.where(system.coordinates.is_length, 0.0, counted - coordinate)
    return np.round(off / (2.0 * np.pi)).astype(np.intp)
