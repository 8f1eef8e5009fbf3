"""How small a violation is asked for, row by row."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.kinematics import Pose
from mbproj.model.system import System
from mbproj.scene.records import ProjectionSettings

#: The smallest default tolerance of the violation test: rad, and m, or the mechanism's length where that is below 1 m.
FLOOR = 1e-13
#: Default tolerance of the paper's test ΔqᵀMΔq (sect. 5).
PAPER_TOLERANCE = 1e-12
#: Violations up to so many ε of the largest coordinate in a row may be round-off.
ROUND_OFF = 64.0


def row_tolerances(system: System, settings: ProjectionSettings, pose: Pose) -> Array:
    """The tolerance of each row of C, (m,): as set, or max(1e-13, 4 ε × the largest coordinate that enters the row)."""
    if settings.tolerance is not None and settings.test == "violation":
        return np.full(system.constraints, settings.tolerance)
    return np.maximum(FLOOR * np.minimum(1.0, system.row_scale), 4.0 * row_grain(system, pose))


def row_grain(system: System, pose: Pose) -> Array:
    """ε × the largest coordinate that enters each row of C, (m,): 1 in rows of vectors; in rows of points, the
    positions of their bodies and their places in them."""
    largest, first = np.zeros(system.constraints), system.bodies
    for bound in [system.joints] if system.motions is None else [system.joints, system.motions.rows]:
        reach = np.abs(pose.position).max(axis=-1)[bound.body] + np.abs(bound.local).max(axis=-1)
        reach *= bound.is_point
        np.maximum.at(largest, first + bound.entry_row, reach[bound.entry_slot])
        first += bound.size
    return np.finfo(float).eps * np.maximum(largest, np.minimum(1.0, system.row_scale))
