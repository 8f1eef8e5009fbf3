"""How small a violation is asked for, row by row."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.kinematics import Pose
from mbproj.model.system import System
from mbproj.scene.records import ProjectionSettings

#: The smallest default tolerance of the violation test, in m or rad.
FLOOR = 1e-13
#: Default tolerance of the paper's test ΔqᵀMΔq (sect. 5).
PAPER_TOLERANCE = 1e-12


def row_tolerances(system: System, settings: ProjectionSettings, pose: Pose) -> Array:
    """The tolerance of each row of C, (m,): as set, or max(1e-13, 4 ε × the largest coordinate that enters the row)."""
    if settings.tolerance is not None and settings.test == "violation":
        return np.full(system.constraints, settings.tolerance)
    largest, first = np.ones(system.constraints), system.bodies
    for bound in [system.joints] if system.motions is None else [system.joints, system.motions.rows]:
        reach = np.abs(pose.position).max(axis=-1)[bound.body] + np.abs(bound.local).max(axis=-1)
        reach *= bound.is_point
        np.maximum.at(largest, first + bound.entry_row, reach[bound.entry_slot])
        first += bound.size
    return np.maximum(FLOOR, 4.0 * np.finfo(float).eps * largest)
