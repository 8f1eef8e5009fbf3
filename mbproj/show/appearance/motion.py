"""The poses of bodies over time: recorded by a run, or of a scene at its start."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.equations.kinematics import attached, pose_of
from mbproj.model.euler_parameters import product, rotation_matrix
from mbproj.model.system import System
from mbproj.results.record import Results


@dataclass(frozen=True, eq=False)
class PoseHistory:
    """Centres of mass `position` (T, n, 3) in m and Euler parameters `orientation` (T, n, 4) at `time` (T,) in s."""

    time: Array
    position: Array
    orientation: Array

    @property
    def finite(self) -> Integers:
        """The numbers of the samples at which the poses of all bodies are finite."""
        whole = np.isfinite(self.position).all(axis=(1, 2)) & np.isfinite(self.orientation).all(axis=(1, 2))
        return np.flatnonzero(whole)

    def at(self, rows: Integers | Sequence[int]) -> PoseHistory:
        """The history at these samples only."""
        return PoseHistory(self.time[rows], self.position[rows], self.orientation[rows])

    def point(self, body: int, local: Array) -> Array:
        """The path (T, 3) of a point of a body. A point of the ground (-1) rests."""
        if body < 0:
            return np.broadcast_to(local, (len(self.time), 3))
        return self.position[:, body] + rotation_matrix(self.orientation[:, body]) @ local

    def vector(self, body: int, local: Array) -> Array:
        """A vector of a body over time (T, 3), in global axes."""
        if body < 0:
            return np.broadcast_to(local, (len(self.time), 3))
        turned: Array = rotation_matrix(self.orientation[:, body]) @ local
        return turned


def motion_at(system: System, q: Array) -> PoseHistory:
    """The poses of all bodies at the coordinates q (7n,) of the carriers, as a history of one sample."""
    pose = pose_of(q)
    position = attached(pose, system.body_carrier, system.body_offset, np.ones(len(system.body_carrier)))
    orientation = product(pose.orientation[system.body_carrier], system.body_turn)
    return PoseHistory(np.zeros(1), position[None], orientation[None])


# --- The motion in a results file -------------------------------------------------------------------------------------


def motion_of(results: Results) -> PoseHistory:
    """The motion of all bodies. Raises InputError where at no sample all poses are finite."""
    motion = PoseHistory(results.time, results["bodies/position"], results["bodies/orientation"])
    if not len(motion.finite):
        message = f"'{results.path}' has no sample to show"
        raise InputError(Problem(message, hint=f"its status: {results.status}"))
    return motion
