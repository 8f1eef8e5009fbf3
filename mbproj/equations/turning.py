"""Whole turns of the joints' angles, counted from step to step.

A pose determines an angle up to whole turns. The rates of a step predict the change of the angle. The prediction uses
the trapezoidal rule, or the stages of the step where the pose at its end is not known. A driven angle follows its
motion, however many turns that is. Where the pose differs too much from the prediction, the step is too coarse to count
turns.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.kinematics import Pose, attached, slots_of
from mbproj.equations.motions import Drive
from mbproj.model.system import System

# --- Teeth and threads ------------------------------------------------------------------------------------------------
# A pose determines the row of a gear or screw up to a whole number of them; counted turns give it.


@dataclass(frozen=True, eq=False)
class Teeth:
    """The teeth in mesh at a state. `expected` (..., nc): the joints' coordinates with turns, angles to within half a
    turn. `start` (k,): `sums_at_start` of the k gears and screws."""

    start: Array
    expected: Array


def sums_at_start(system: System, pose: Pose, coordinate: Array) -> Array:
    """Return the whole teeth and threads of each gear and screw, (k,), at the initial pose, in the rows' units.

    `coordinate` (nc,) are the joints' coordinates with turns. The result stays the same however far the wheels turn."""
    couplings = system.couplings
    rows = system.joints.value(attached(pose, *slots_of(system.joints)))[couplings.row]
    counted = couplings.sums(coordinate) - rows
    if couplings.rolls.any():
        value = system.coordinates.value(attached(pose, *slots_of(system.coordinates)))
        # 0 where the roller closes with laps and turns counted from the initial pose
        rolled = (_rolled(system, value, coordinate, rows) + rows).astype(float)
        open_by = THRESHOLDS.open_limit * system.row_scale[system.bodies + couplings.row]
        counted[couplings.rolls] = np.where(np.abs(rolled) <= open_by, 0.0, rolled)[couplings.rolls]
    return np.asarray(counted, dtype=float)


def _rolled(system: System, value: Numbers, expected: Array, rows: Numbers) -> npt.NDArray[np.longdouble]:
    """Return the laps and turns (..., k) of rollers on curves; `value` are the coordinates computed from the pose."""
    couplings = system.couplings
    apart = couplings.sums(near(system, value, expected)) - system.joints.offset[couplings.row] - rows
    return couplings.rolled(value, expected, apart)


def to_the_tooth(system: System, pose: Pose, teeth: Teeth, rows: Numbers) -> Numbers:
    """Return the joints' rows (..., m), with gears and screws moved from the nearest tooth to the one in mesh."""
    couplings = system.couplings
    # The real part: this value only decides on whole teeth, which a complex step does not change.
    value = system.coordinates.value(attached(pose, *slots_of(system.coordinates))).real
    counted = couplings.sums(near(system, value, teeth.expected)) - teeth.start
    values = rows.copy()
    nearest = rows[..., couplings.row]
    values[..., couplings.row] = nearest + couplings.whole(counted - nearest)
    if couplings.rolls.any():
        rolled, rolls = _rolled(system, value, teeth.expected, nearest), couplings.rolls
        values[..., couplings.row[rolls]] = nearest[..., rolls] + (rolled - teeth.start)[..., rolls].astype(float)
    return values


def near(system: System, value: Numbers, expected: Numbers) -> Numbers:
    """Return joint coordinates (..., nc) with the whole turns that bring each angle nearest to its expected value."""
    angle = ~system.coordinates.is_length
    return value + 2.0 * np.pi * angle * np.round((expected - value) / (2.0 * np.pi))


# --- Whole turns of the joints' angles, counted from step to step -----------------------------------------------------


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
