"""The tolerance of the violation, row by row."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.dynamics.equations.round_off import position_grain
from mbproj.model.system import System
from mbproj.scene.records import ProjectionSettings
from mbproj.thresholds import THRESHOLDS


def row_tolerances(system: System, settings: ProjectionSettings, pose: Pose) -> Array:
    """Return the tolerance of each row of C, (m,): as set, or max(1e-13, 4 ε × the largest coordinate in the row)."""
    if settings.tolerance is not None and settings.test == "violation":
        return np.full(system.constraints, settings.tolerance)
    return np.maximum(
        THRESHOLDS.closed_to * np.minimum(1.0, system.row_scale),
        THRESHOLDS.closed_grains * position_grain(system, pose),
    )
