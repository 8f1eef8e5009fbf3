"""Teeth and threads: a pose determines the row of a gear or screw up to a whole number of them; counted turns give
it."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Numbers
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.kinematics import Pose, attached, slots_of
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


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
