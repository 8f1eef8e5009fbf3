"""Teeth and threads: a pose alone knows the row of a gear or screw but for whole ones; counted turns tell which."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Numbers
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.kinematics import Pose, attached, slots_of
from mbproj.model.system import System


@dataclass(frozen=True, eq=False)
class Teeth:
    """What is in mesh at a state: `expected` (..., nc), the joints' coordinates there, turns counted, each angle to
    less than half a turn; and `start` (k,), what the sums of the k gears and screws count from (`sums_at_start`)."""

    start: Array
    expected: Array


def sums_at_start(system: System, pose: Pose, coordinate: Array) -> Array:
    """The whole teeth and threads of each gear and screw, (k,), at the pose where a run begins, in the rows' units;
    `coordinate` (nc,) are the joints', turns counted. They stay what they are however far the wheels turn."""
    rows = system.joints.value(attached(pose, *slots_of(system.joints)))[system.couplings.row]
    return np.asarray(system.couplings.sums(coordinate) - rows, dtype=float)


def to_the_tooth(system: System, pose: Pose, teeth: Teeth, rows: Numbers) -> Numbers:
    """The joints' rows (..., m), those of gears and screws counted on from the nearest tooth to the one in mesh."""
    couplings = system.couplings
    value = system.coordinates.value(attached(pose, *slots_of(system.coordinates)))
    counted = couplings.sums(near(system, value, teeth.expected)) - teeth.start
    found = rows.copy()
    nearest = rows[..., couplings.row]
    found[..., couplings.row] = nearest + couplings.whole(counted - nearest)
    return found


def near(system: System, value: Numbers, expected: Numbers) -> Numbers:
    """Joint coordinates (..., nc) with the whole turns that bring angles next to what is expected of them."""
    angle = ~system.coordinates.is_length
    return value + 2.0 * np.pi * angle * np.round((expected - value) / (2.0 * np.pi))
