"""The pose nearest to one that is beyond stops at which all stops are respected, if there is one."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dynamics.assembly.assemble import State, coordinate_values, nearest, scaled_residual, scaled_rows
from mbproj.dynamics.assembly.gauss_newton import gauss_newton, set_rows
from mbproj.dynamics.blocks import Rows, stacked
from mbproj.dynamics.equations.gaps import gaps
from mbproj.dynamics.equations.kinematics import Pose, pose_of
from mbproj.dynamics.equations.motions import drive_at
from mbproj.dynamics.equations.teeth import near
from mbproj.dynamics.equations.turning import turns_of
from mbproj.model.system import Conditions, System
from mbproj.thresholds import THRESHOLDS

NO_CONDITIONS = Conditions(np.zeros(0, dtype=np.intp), np.zeros(0))


def stop_sizes(system: System) -> Array:
    """Return the scales of gaps, (S,): the mechanism's length in m, and 1 rad."""
    assert system.stops is not None
    return np.where(system.stops.coordinates.is_length, system.length, 1.0)


def nearest_inside(system: System, state: State) -> tuple[Array, Array]:
    """Return a pose q at which the joints close and no stop is passed, searched from the pose of a state, and its gaps
    (S,). A gap below 0 belongs to a stop that could not be respected."""
    system = system.at_positions
    stops, drive, none = system.stops, drive_at(system, state.t), NO_CONDITIONS
    assert stops is not None
    sizes = stop_sizes(system)
    start = coordinate_values(system, pose_of(state.q)) + 2.0 * np.pi * state.turns

    def gap(pose: Pose) -> Array:
        return np.asarray(gaps(stops, pose, _turns(system, pose, start)))

    def residual(pose: Pose) -> Array:
        passed = np.minimum(gap(pose), 0.0) / sizes
        return np.concatenate([scaled_residual(system, pose, none, drive), passed])

    def rows(pose: Pose) -> Rows:
        factor = np.where(gap(pose) < 0.0, stops.side / sizes, 0.0)
        passed = set_rows(system, stops.coordinates, pose).scaled(factor)
        return stacked(system.bodies, [scaled_rows(system, pose, none), passed])

    between, _ = gauss_newton(system, state.q, residual, rows, THRESHOLDS.assembled)
    q, _ = nearest(system, between, none, drive, THRESHOLDS.assembled)  # joints have priority
    return q, gap(pose_of(q))


def _turns(system: System, pose: Pose, start: Array) -> Integers:
    """Return whole turns (nc,) of the joints' coordinates at a pose near one where the coordinates were `start`."""
    angles = coordinate_values(system, pose)
    return turns_of(system, near(system, angles, start), angles)
