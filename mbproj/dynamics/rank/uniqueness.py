"""Which components of the joints' reactions C determines: those that no forces in balance with themselves add to."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.kinematics import Pose, pose_of
from mbproj.dynamics.observe.reactions import reactions
from mbproj.dynamics.rank.components import loops_of
from mbproj.dynamics.rank.row_space import self_stresses
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

Marks = npt.NDArray[np.bool_]


def indeterminate(system: System, pose: Pose) -> tuple[Marks, Marks]:
    """Components of each joint's reaction force and torque, (nj, 3) each, global axes, that are not unique at this
    pose: multipliers λ with Gᵀλ = 0 change them. None is where no row is redundant.

    A mechanism of components of more than `large` bodies is taken to have no redundant rows there.
    """
    stresses = self_stresses(system, pose)
    force, torque = reactions(system, pose, stresses)
    largest = max(np.abs(force).max(initial=0.0) * system.length, np.abs(torque).max(initial=0.0))
    return (
        np.any(np.abs(force) * system.length > THRESHOLDS.no_part * largest, axis=0),
        np.any(np.abs(torque) > THRESHOLDS.no_part * largest, axis=0),
    )


def unique_components(system: System, state: State) -> dict[str, Marks]:
    """Which components of the joints' reactions are unique, (nj, 3), by their paths in a results file: those that are
    so at the start and, for few bodies, at poses nearby. Empty where a loop has too many bodies to tell."""
    loops = loops_of(system)
    if max((len(loop.bodies) for loop in loops), default=0) > THRESHOLDS.large:
        return {}
    force, torque = (np.zeros((len(system.names.joints), 3), dtype=bool) for _ in range(2))
    if loops:
        force, torque = indeterminate(system, pose_of(state.q))
    if force.any() or torque.any():
        from mbproj.dynamics.rank.nearby import nearby

        for pose in nearby(system, state.q).poses if system.bodies <= THRESHOLDS.few_bodies else ():
            marks = indeterminate(system, pose)
            force, torque = force | marks[0], torque | marks[1]
    return {"joints/reaction_force_unique": ~force, "joints/reaction_torque_unique": ~torque}
