"""Which components of the joints' reactions C determines: those that no forces in balance with themselves add to."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array
from mbproj.dynamics.assembly import LARGE
from mbproj.dynamics.blocks import block_rows, blocks_of
from mbproj.dynamics.kinematics import Pose
from mbproj.dynamics.observe import reactions
from mbproj.dynamics.row_space import shares, split, unit_rows
from mbproj.model.system import System

#: A component below this part of the largest is none.
NO_PART = 1e-8
Marks = npt.NDArray[np.bool_]


def indeterminate(system: System, pose: Pose) -> tuple[Marks, Marks]:
    """Components of each joint's reaction force and torque, (nj, 3) each, global axes, that are not unique at this
    pose: multipliers λ with Gᵀλ = 0 change them. None is where no row is redundant.

    A mechanism of blocks of more than `LARGE` bodies is taken to have no redundant rows there.
    """
    stresses = self_stresses(system, pose)
    force, torque = reactions(system, pose, stresses)
    largest = max(np.abs(force).max(initial=0.0) * system.length, np.abs(torque).max(initial=0.0))
    return (
        np.any(np.abs(force) * system.length > NO_PART * largest, axis=0),
        np.any(np.abs(torque) > NO_PART * largest, axis=0),
    )


def self_stresses(system: System, pose: Pose) -> Array:
    """A basis of the multipliers λ (d, k) of joints and motions that exert nothing on any body, Gᵀλ = 0; torques are of
    the order of 1, and forces of 1 / length."""
    blocks = [block for block in blocks_of(system) if len(block.bodies) <= LARGE]
    scale = system.row_scale[system.bodies :]
    found = [np.zeros((0, len(scale)))]
    for block, rows in zip(blocks, block_rows(system, pose, blocks), strict=True):
        unit = unit_rows(rows)
        basis, dependent = split(unit, np.arange(len(rows)))
        length = np.where(unit.any(axis=1), np.linalg.norm(rows, axis=1), 1.0)
        part = np.zeros((len(dependent), len(rows)))
        part[np.arange(len(dependent)), dependent] = 1.0
        part[:, basis] = -shares(unit, basis, dependent)
        stress = np.zeros((len(dependent), len(scale)))
        stress[:, block.rows] = part / length / np.abs(part).max(axis=1, initial=1.0, keepdims=True)
        found.append(stress / scale)
    return np.concatenate(found)
