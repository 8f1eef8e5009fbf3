"""Dry frictions at one state: their rates, and which of them are at rest."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Flags
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.constraint_equations import set_velocity
from mbproj.dynamics.equations.kinematics import pose_of, twist_of
from mbproj.integrate.stops.whole import speed_of
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


def friction_sizes(system: System) -> Array:
    """Return the scales of the frictions' coordinates, (K,): the mechanism's length in m, or 1 rad."""
    assert system.frictions is not None
    return np.where(system.frictions.coordinates.is_length, system.length, 1.0)


def friction_rates(system: System, state: State) -> Array:
    """Return s' of the frictions, (K,)."""
    assert system.frictions is not None
    pose = pose_of(state.q)
    return np.asarray(set_velocity(system.frictions.coordinates, pose, twist_of(pose, state.v)))


def at_rest(system: System, state: State) -> Flags:
    """Return whether each friction is at rest, (K,): no faster than round-off of the mechanism's motion. Both frictions
    of a plane rest together."""
    frictions = system.frictions
    assert frictions is not None
    rate = friction_rates(system, state)
    across = np.where(frictions.partner >= 0, rate[frictions.partner], 0.0)
    slow = THRESHOLDS.stop_rests * speed_of(system, state) * friction_sizes(system)
    return np.asarray(np.hypot(rate, across) <= slow)
