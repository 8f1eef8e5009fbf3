"""Gaps: the distances of a mechanism from its stops."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers, Numbers, total
from mbproj.dynamics.equations.constraint_equations import set_velocity
from mbproj.dynamics.equations.kinematics import Pose, Twist, attached, slots_of
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.stops import Stops


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


def pressing(stops: Stops, by: Array, gap: Numbers, rate: Numbers) -> Numbers:
    """Return the forces of compliant stops at these gaps (..., S) and rates, in N or N m; 0 for rigid ones. `by` (S,)
    are their coefficients of damping, `Stops.pushes_by`."""
    δ = np.maximum(-gap, 0.0)
    elastic, given = _stiffness(stops) * δ**stops.exponent, np.isnan(stops.restitution)
    speed = np.sqrt(rate**2 + by * δ ** (stops.exponent + 1.0) + np.finfo(float).tiny)
    part = np.where(given, by, stops.resistance / speed) * rate
    return np.asarray(np.where(δ > 0.0, elastic * np.maximum(1.0 - part, 0.0), 0.0))


def stored_energy(stops: Stops, gap: Numbers) -> Numbers:
    """Return the energy stored in compliant stops, Σ k δᵖ⁺¹ / (p + 1), shape (...), in J."""
    δ, p = np.maximum(-gap, 0.0), stops.exponent
    return total(_stiffness(stops) * δ ** (p + 1.0) / (p + 1.0))


def _stiffness(stops: Stops) -> Array:
    """Return k of compliant stops, 0 of rigid ones, (S,)."""
    return np.where(stops.is_rigid, 0.0, stops.stiffness)
