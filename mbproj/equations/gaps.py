"""Gaps: the distances of a mechanism from its stops, their rates and their scales."""

from __future__ import annotations

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.equations.constraints import set_velocity
from mbproj.equations.kinematics import Pose, Twist, attached, slots_of
from mbproj.model.contacts import Stops
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import System


def gaps(stops: Stops, pose: Pose, turns: Integers) -> Numbers:
    """Return g = side (s - bound) at poses (...) with whole turns (..., nc) of the joints' angles, (..., S), in m or
    rad."""
    value = counted_values(stops.coordinates, stops.joint_coordinate, pose, turns)
    return np.asarray(stops.side * (value - stops.bound))


def counted_values(coordinates: PrimitiveSet, joint_coordinate: Integers, pose: Pose, turns: Integers) -> Numbers:
    """Return s at poses (...) with whole turns (..., nc) of the joints' angles, (..., k). `joint_coordinate` (k,) is
    the number of each s among the joints' coordinates, -1 for none."""
    value = coordinates.value(attached(pose, *slots_of(coordinates)))
    counts = ((joint_coordinate >= 0) & ~coordinates.is_length).astype(float)
    counted = turns[..., joint_coordinate] * counts if np.shape(turns)[-1] else 0.0
    return np.asarray(value + 2.0 * np.pi * counted)


def gap_rates(stops: Stops, pose: Pose, twist: Twist) -> Numbers:
    """Return g', (..., S), in m/s or rad/s."""
    with np.errstate(divide="ignore", invalid="ignore"):  # points that coincide have no rate
        return np.asarray(stops.side * set_velocity(stops.coordinates, pose, twist))


def stop_sizes(system: System) -> Array:
    """Return the scales of gaps, (S,): the mechanism's length in m, and 1 rad."""
    assert system.stops is not None
    return np.where(system.stops.coordinates.is_length, system.length, 1.0)
