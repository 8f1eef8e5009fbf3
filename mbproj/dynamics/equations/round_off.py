"""The residuals of C = 0 and C' = 0 that round-off alone leaves, row by row: no projection can close joints further.

A row is computed from coordinates that are stored to ε of their size, so it is known to ε times the largest coordinate
in it. The solution of the projection's equations adds ε times their condition number times the violation before the
last pass. This second part is smaller: for positions the violation is itself near round-off, and where pivots are small
the solution is refined.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dynamics.equations.kinematics import Pose, Twist
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

EPSILON = float(np.finfo(float).eps)
#: Motions whose inertia is below this part of the largest are reported: round-off of forces on other bodies changes
#: them by `no_motion`, relatively.
HARDLY_ANY = EPSILON / THRESHOLDS.no_motion


def has_light_bodies(system: System) -> bool:
    """Return whether a body has hardly any mass, or moment of inertia, beside the others."""
    moments = np.linalg.eigvalsh(system.inertia)
    light = system.mass.min() <= HARDLY_ANY * system.mass.max() or moments.min() <= HARDLY_ANY * moments.max()
    return bool(light)


def position_grain(system: System, pose: Pose) -> Array:
    """Return ε times the largest coordinate in each row of C, (m,): 1 for vectors, and for points their local
    coordinates plus the positions of their bodies."""
    reach = np.abs(pose.position).max(axis=-1)
    largest = _largest(system, lambda body, size, is_point: (reach[body] + size) * is_point)
    return EPSILON * np.maximum(largest, np.minimum(1.0, system.row_scale))


def velocity_grain(system: System, pose: Pose, twist: Twist) -> Array:
    """Return ε times the largest velocity in each row of C', (m,), per s: of points, of vectors (their length is 1),
    and of the coordinates from which velocities of points are computed."""
    speed = np.abs(twist.velocity).max(axis=-1)
    turning = 2.0 * np.linalg.norm(twist.rate, axis=-1)
    reach = np.abs(pose.position).max(axis=-1)
    largest = _largest(
        system,
        lambda body, size, is_point: np.where(
            is_point, speed[body] + turning[body] * np.maximum(size, reach[body]), turning[body]
        ),
    )
    largest[: system.bodies] = turning[: system.bodies]
    return EPSILON * largest


def _largest(system: System, of_slot: Callable[[Integers, Array, Array], Array]) -> Array:
    """Return the largest value in each row, (m,), from `of_slot(body, largest local coordinate, is_point)`, (S,)."""
    largest, bound = np.zeros(system.constraints), system.rows
    values = of_slot(bound.body, np.abs(bound.local).max(axis=-1), bound.is_point)
    np.maximum.at(largest, system.bodies + bound.entry_row, values[bound.entry_slot])
    return largest
