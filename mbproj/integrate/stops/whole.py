"""The motion of a whole mechanism, and what its stops keep."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.gaps import gaps, stored_energy
from mbproj.dynamics.equations.kinematics import Pose, body_rates, pose_of, twist_of
from mbproj.model.system import System


def stored(system: System, pose: Pose, turns: Integers) -> Array:
    """What compliant stops keep at poses, (...,), in J."""
    if system.stops is None:
        return np.zeros(pose.position.shape[:-2])
    return np.asarray(stored_energy(system.stops, gaps(system.stops, pose, turns)))


def speed_of(system: System, state: State) -> float:
    """How fast the fastest part of a mechanism moves, in its lengths and rad per s."""
    pose = pose_of(state.q)
    twist = twist_of(pose, state.v)
    return float(np.abs(twist.velocity).max() / system.length + np.abs(body_rates(pose, twist)).max())
