"""Self-stresses: forces of the joints that balance each other, Gᵀλ = 0. There is one for each redundant row."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.dynamics.rank.blocks import block_rows, loops_of
from mbproj.dynamics.rank.row_space import shares, split, unit_rows
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


def self_stresses(system: System, pose: Pose) -> Array:
    """A basis of the multipliers λ (d, k) of joints and motions that exert nothing on any body, Gᵀλ = 0; torques are of
    the order of 1, and forces of 1 / length."""
    blocks = [block for block in loops_of(system) if len(block.bodies) <= THRESHOLDS.large]
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
