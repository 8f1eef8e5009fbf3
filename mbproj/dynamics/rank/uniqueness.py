"""The components of the joints' reactions that C determines: those to which no self-equilibrated forces contribute."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.kinematics import Pose, pose_of
from mbproj.dynamics.rank.components import loops_of
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

Marks = npt.NDArray[np.bool_]


def indeterminate(system: System, pose: Pose) -> tuple[Marks, Marks]:
    """Return whether each component of the joints' reaction forces and torques is not unique at this pose, (nj, 3)
    each, global axes. Multipliers λ with Gᵀλ = 0 change such a component. Without redundant rows every component is
    unique.

    Components of more than `large` bodies are taken to have no redundant rows.
    """
    from mbproj.dynamics.observe.reactions import reactions
    from mbproj.dynamics.rank.row_space import self_stresses

    stresses = self_stresses(system, pose)
    force, torque = reactions(system, pose, stresses)
    largest = max(np.abs(force).max(initial=0.0) * system.length, np.abs(torque).max(initial=0.0))
    return (
        np.any(np.abs(force) * system.length > THRESHOLDS.no_part * largest, axis=0),
        np.any(np.abs(torque) > THRESHOLDS.no_part * largest, axis=0),
    )


def unique_components(system: System, state: State) -> dict[str, Marks]:
    """Return whether each component of the joints' reactions is unique, (nj, 3), by its path in a results file.

    A component is unique if it is so at the start and, for few bodies, at poses nearby. The result is empty where a
    loop has too many bodies for a decision."""
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
