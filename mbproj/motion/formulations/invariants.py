"""The momenta that a mechanism conserves, tested at poses that it can take."""

from __future__ import annotations

from functools import partial

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.settings import ProjectionSettings
from mbproj.equations.assembly.assemble import State
from mbproj.equations.motions import drive_at
from mbproj.equations.rank.row_policy import RowSet
from mbproj.equations.symmetries import Fields, kept_fields, rigid_fields
from mbproj.equations.turning import Teeth, sums_at_start
from mbproj.model.system import System
from mbproj.motion.projection import Gpopm, correct_position


def momenta_of(system: System, state: State, fields: Fields = rigid_fields) -> Array:
    """Return the combinations (j, k) of rigid motions whose momenta are conserved."""
    return kept_fields(system, state, partial(_closed_pose, system, state), fields)


def _closed_pose(system: System, state: State, q: Array) -> Array | None:
    """Return q moved to the constraints; None where that fails."""
    instant = state.instant(system)
    teeth = Teeth(sums_at_start(system, instant.pose, instant.expected), instant.expected)
    drive = drive_at(system, state.t, teeth if system.couplings.size else None)
    try:
        closed = correct_position(system, Gpopm(), ProjectionSettings(), RowSet.regular(system), q, drive)
    except np.linalg.LinAlgError:
        return None
    return closed.q if closed.met else None
