"""The projection after a step, if one is due, with its stop tests."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.constraint_equations import constraint, jacobian, time_derivative
from mbproj.dynamics.equations.equations_of_motion import mass_matrix
from mbproj.dynamics.equations.kinematics import Pose, pose_of
from mbproj.dynamics.equations.motions import NO_DRIVE, Drive
from mbproj.dynamics.rank.row_set import RowSet
from mbproj.model.system import System
from mbproj.projection.methods.method import Projection
from mbproj.projection.solve.position import Position, correct_position
from mbproj.scene.records import ProjectionSettings


@dataclass(frozen=True, eq=False)
class ProjectedState:
    """The state after a projection, the passes it took, whether the position met its test, and whether the fallback was
    needed.

    `left_open`: the violation of rows without a gradient near a singular pose, in units of the mechanism's length.
    `nearest`: the smallest distance of the projection's poses from a singular one, divided by the run's largest
    distance."""

    q: Array
    v: Array
    projections: int = 0
    position_iterations: int = 0
    velocity_iterations: int = 0
    failures: int = 0
    fallbacks: int = 0
    left_open: float = 0.0
    nearest: float = 1.0


def project_after(
    step: int,
    system: System,
    method: Projection,
    settings: ProjectionSettings,
    q: Array,
    v: Array,
    drive: Drive = NO_DRIVE,
    rows: RowSet | None = None,
) -> ProjectedState:
    """Return the state (q, v) after step number `step` (from 1), projected if it is due. It is due at every k-th step;
    with a threshold only for levels whose violation exceeds it, and for velocities always after a moved position.

    `drive` holds the motions' values at the time of the state, where the system has any. `rows` decides which rows are
    held; all of them without it."""
    rows = rows or RowSet.regular(system)
    if step % settings.every:
        return ProjectedState(q, v)
    position, velocity = settings.position, settings.velocity
    if settings.threshold is not None:
        pose = pose_of(q)
        position = position and float(np.abs(constraint(system, pose, drive)).max()) > settings.threshold
        excess = float(np.abs(jacobian(system, pose) @ v + time_derivative(system, drive)).max()) > settings.threshold
        velocity = velocity and (position or excess)
    if not (position or velocity):
        return ProjectedState(q, v)
    position_solved = (
        correct_position(system, method, settings, rows, q, drive) if position else Position(q, 0, met=True)
    )
    passes, nearest = 0, position_solved.nearest
    if velocity:
        v, passes, nearness = correct_velocity(system, method, settings, rows, pose_of(position_solved.q), v, drive)
        nearest = min(nearest, nearness)
    return ProjectedState(
        position_solved.q,
        v,
        1,
        position_solved.passes,
        passes,
        int(not position_solved.met),
        int(position_solved.fell_back),
        position_solved.left_open,
        nearest,
    )


def correct_velocity(
    system: System,
    method: Projection,
    settings: ProjectionSettings,
    rows: RowSet,
    pose: Pose,
    v: Array,
    drive: Drive = NO_DRIVE,
) -> tuple[Array, int, float]:
    """Return v with C_q v + C_t = 0 at this pose, the number of passes, and the pose's distance from a singular one.
    One pass is enough (Eq. 46), except for a penalty method."""
    M, held, C_t = mass_matrix(system, pose), rows.to_move(pose, drive), time_derivative(system, drive)
    C_t = held.combined(C_t)
    C_dot = held.C_q @ v + C_t
    for passes in range(settings.max_iterations):
        v = v + method.correction(M, held.C_q, C_dot)
        previous, C_dot = C_dot, held.C_q @ v + C_t
        if not method.iterates_velocity or not np.abs(C_dot).max() < 0.5 * np.abs(previous).max():
            return v, passes + 1, held.nearness
    return v, settings.max_iterations, held.nearness
