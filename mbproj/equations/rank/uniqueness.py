"""The components of the joints' reactions that C determines: those to which no self-equilibrated forces contribute."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.kinematics import Pose, pose_of
from mbproj.equations.rank.components import loops_of
from mbproj.model.system import System

Marks = npt.NDArray[np.bool_]


def indeterminate(system: System, pose: Pose) -> tuple[Marks, Marks]:
    """Return whether each component of the joints' reaction forces and torques is not unique at this pose, (nj, 3)
    each, global axes. Multipliers λ with Gᵀλ = 0 change such a component. Without redundant rows every component is
    unique.

    Components of more than `large` bodies are taken to have no redundant rows.
    """
    force, torque = _stresses(system, pose)
    return np.any(force != 0.0, axis=0), np.any(torque != 0.0, axis=0)


def _stresses(system: System, pose: Pose) -> tuple[Array, Array]:
    """Return reaction forces times the length of the system, and torques, (k, nj, 3) each, of a basis of
    self-equilibrated multipliers. The largest are of size 1; round-off is 0."""
    from mbproj.equations.rank.row_space import self_stresses
    from mbproj.equations.reactions import reactions

    force, torque = reactions(system, pose, self_stresses(system, pose))
    both = np.stack([force * system.length, torque])
    largest = np.abs(both).max(initial=0.0)
    both = np.where(np.abs(both) > THRESHOLDS.no_part * largest, both / (largest or 1.0), 0.0)
    return both[0], both[1]


def unique_components(system: System, state: State) -> dict[str, Array | Marks]:
    """Return, by the path in a results file, whether each component of the joints' reactions is unique, (nj, 3). Beside
    it are the projections (nj, 3, 3) on the directions along which they are not.

    A component is unique if it is so at the start and, for few bodies, at poses nearby. The result is empty where a
    loop has too many bodies for a decision."""
    loops = loops_of(system)
    if max((len(loop.bodies) for loop in loops), default=0) > THRESHOLDS.large:
        return {}
    none = np.zeros((0, len(system.names.joints), 3))
    at_poses = [_stresses(system, pose_of(state.q)) if loops else (none, none)]
    if any(part.any() for part in at_poses[0]):
        from mbproj.equations.rank.nearby import nearby

        poses = nearby(system, state.q).poses if system.bodies <= THRESHOLDS.few_bodies else ()
        at_poses += [_stresses(system, pose) for pose in poses]
    datasets: dict[str, Array | Marks] = {}
    for name, parts in zip(("force", "torque"), zip(*at_poses, strict=True), strict=True):
        stresses = np.concatenate(parts)
        datasets[f"joints/reaction_{name}_unique"] = ~np.any(stresses != 0.0, axis=0)
        datasets[f"joints/reaction_{name}_open"] = _projections(stresses)
    return datasets


def _projections(stresses: Array) -> Array:
    """Return the orthogonal projections (nj, 3, 3) on the spans of vectors (k, nj, 3)."""
    of_joints = np.concatenate([stresses, np.zeros((3, *stresses.shape[1:]))]).swapaxes(0, 1)
    _, values, axes = np.linalg.svd(of_joints, full_matrices=False)
    spans = (values > THRESHOLDS.no_part * values.max(initial=0.0)).astype(float)
    return np.asarray(np.einsum("jak,ja,jal->jkl", axes, spans, axes))
