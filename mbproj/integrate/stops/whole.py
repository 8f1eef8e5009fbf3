"""The largest speed of a mechanism, and the energy stored in its stops."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.gaps import gaps, stored_energy
from mbproj.dynamics.equations.kinematics import Pose, body_rates, pose_of, twist_of
from mbproj.model.system import System


def stored(system: System, pose: Pose, turns: Integers) -> Array:
    """Return the energy stored in compliant stops at poses (...), (...), in J."""
    if system.stops is None:
        return np.zeros(pose.position.shape[:-2])
    return np.asarray(stored_energy(system.stops, gaps(system.stops, pose, turns)))


def speed_of(system: System, state: State) -> float:
    """Return the speed of the fastest body of a mechanism, in the mechanism's lengths and rad per s."""
    pose = pose_of(state.q)
    twist = twist_of(pose, state.v)
    return float(np.abs(twist.velocity).max() / system.length + np.abs(body_rates(pose, twist)).max())
