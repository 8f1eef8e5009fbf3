"""Passages near singular positions, where the constraints of a loop are nearly dependent."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.rank.components import component_rows, loops_of
from mbproj.model.euler_parameters import product, rotation_matrix
from mbproj.model.system import System
from mbproj.pages.appearance.motion import PoseHistory
from mbproj.thresholds import THRESHOLDS

#: The most bodies for which passages are searched: with more, the search would take longer than all else.
MOST_BODIES = 60


def passages(system: System, motion: PoseHistory) -> Iterator[tuple[float, float]]:
    """The time (s) of the nearest frame of each passage, and its distance: the smallest singular value of a loop's
    rows, relative to its largest value in this motion."""
    loops = loops_of(system) if system.bodies <= MOST_BODIES else []
    if not loops or len(motion.time) < 3:
        return
    q = carried(system, motion)
    by_frame = [
        [np.linalg.svd(rows, compute_uv=False) for rows in component_rows(system, pose_of(each), loops)] for each in q
    ]
    for loop in range(len(loops)):
        values = np.array([frame[loop] for frame in by_frame])
        rank = int((values > THRESHOLDS.dependent * values[:, :1]).sum(axis=1).max())
        smallest = values[:, rank - 1] / values[:, rank - 1].max()
        for row in dips(smallest, THRESHOLDS.near_singular):
            yield float(motion.time[row]), float(smallest[row])


def dips(values: Array, below: float) -> Iterator[int]:
    """The rows of the minima of `values` (T,) in each stretch below a limit that begins and ends above it."""
    low = np.concatenate([[False], values < below, [False]])
    starts, ends = np.flatnonzero(~low[:-1] & low[1:]), np.flatnonzero(low[:-1] & ~low[1:])
    for start, end in zip(starts, ends, strict=True):
        if start > 0 and end < len(values):
            yield int(start + np.argmin(values[start:end]))


def carried(system: System, motion: PoseHistory) -> Array:
    """The coordinates (T, 7n) of the carriers, each computed from the first body fixed to it."""
    first = np.array([np.flatnonzero(system.body_carrier == carrier)[0] for carrier in range(system.bodies)])
    back = system.body_turn[first] * [1.0, -1.0, -1.0, -1.0]
    orientation = product(motion.orientation[:, first], np.broadcast_to(back, (len(motion.time), *back.shape)))
    arm = (rotation_matrix(orientation) @ system.body_offset[first][..., None])[..., 0]
    q = np.concatenate([motion.position[:, first] - arm, orientation], axis=-1)
    return q.reshape(len(motion.time), -1)
