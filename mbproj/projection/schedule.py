"""After a step: is it time to project, and the projection itself with its stop tests."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.constraint_equations import constraint, jacobian, time_derivative
from mbproj.dynamics.equations import mass_matrix
from mbproj.dynamics.kinematics import Pose, pose_of
from mbproj.dynamics.motions import Drive
from mbproj.model.system import System
from mbproj.projection.method import Projection
from mbproj.projection.tolerance import PAPER_TOLERANCE, row_tolerances
from mbproj.scene.records import ProjectionSettings

#: A pass that leaves more than this part of the violation has reached round-off, or does not converge.
STAGNATION = 0.5


@dataclass(frozen=True, eq=False)
class Projected:
    """The state after a projection, the passes it took, and whether the position met its test."""

    q: Array
    v: Array
    projections: int = 0
    position_iterations: int = 0
    velocity_iterations: int = 0
    failures: int = 0


def project_after(
    step: int,
    system: System,
    method: Projection,
    settings: ProjectionSettings,
    q: Array,
    v: Array,
    drive: Drive | None = None,
) -> Projected:
    """The state (q, v) after step number `step` (from 1), projected if the schedule says so: every k-th step, and
    with a threshold only the levels whose violation exceeds it (velocities always after a moved position).

    `drive` is what the motions prescribe at the time of the state, where the system has any."""
    if step % settings.every:
        return Projected(q, v)
    position, velocity = settings.position, settings.velocity
    if settings.threshold is not None:
        pose = pose_of(q)
        position = position and float(np.abs(constraint(system, pose, drive)).max()) > settings.threshold
        excess = float(np.abs(jacobian(system, pose) @ v + time_derivative(system, drive)).max()) > settings.threshold
        velocity = velocity and (position or excess)
    if not (position or velocity):
        return Projected(q, v)
    iterations, met = 0, True
    if position:
        q, iterations, met = correct_position(system, method, settings, q, drive)
    passes = 0
    if velocity:
        v, passes = correct_velocity(system, method, settings, pose_of(q), v, drive)
    return Projected(q, v, 1, iterations, passes, int(not met))


def correct_position(
    system: System, method: Projection, settings: ProjectionSettings, q: Array, drive: Drive | None = None
) -> tuple[Array, int, bool]:
    """q with C(q) = 0, the passes taken, and whether the stop test was met."""
    correct = _by_violation if settings.test == "violation" else _by_paper
    return correct(system, method, settings, q, drive)


def _by_violation(
    system: System, method: Projection, settings: ProjectionSettings, q: Array, drive: Drive | None
) -> tuple[Array, int, bool]:
    """Until |C| <= tolerance in every row; a violation that no longer falls has reached round-off and ends the loop."""
    pose = pose_of(q)
    C = constraint(system, pose, drive)
    tolerances = row_tolerances(system, settings, pose)
    for passes in range(settings.max_iterations):
        if np.all(np.abs(C) <= tolerances):
            return q, passes, True
        change = method.correction(mass_matrix(system, pose), jacobian(system, pose), C)
        pose = pose_of(q + change)
        previous, C = C, constraint(system, pose, drive)
        if passes and not np.abs(C).max() < STAGNATION * np.abs(previous).max():
            return q, passes + 1, False
        q = q + change
    return q, settings.max_iterations, bool(np.all(np.abs(C) <= tolerances))


def _by_paper(
    system: System, method: Projection, settings: ProjectionSettings, q: Array, drive: Drive | None
) -> tuple[Array, int, bool]:
    """Until ΔqᵀMΔq <= tolerance (sect. 5). M is singular along Λ, so this test does not see the length of Λ."""
    tolerance = PAPER_TOLERANCE if settings.tolerance is None else settings.tolerance
    for passes in range(settings.max_iterations):
        pose = pose_of(q)
        M = mass_matrix(system, pose)
        change = method.correction(M, jacobian(system, pose), constraint(system, pose, drive))
        q = q + change
        if change @ M @ change <= tolerance:
            return q, passes + 1, True
    return q, settings.max_iterations, False


def correct_velocity(
    system: System,
    method: Projection,
    settings: ProjectionSettings,
    pose: Pose,
    v: Array,
    drive: Drive | None = None,
) -> tuple[Array, int]:
    """v with C_q v + C_t = 0 at this pose, and the passes taken: one (Eq. 46), more where the method is a penalty."""
    M, C_q, C_t = mass_matrix(system, pose), jacobian(system, pose), time_derivative(system, drive)
    C_dot = C_q @ v + C_t
    for passes in range(settings.max_iterations):
        v = v + method.correction(M, C_q, C_dot)
        previous, C_dot = C_dot, C_q @ v + C_t
        if not method.iterates_velocity or not np.abs(C_dot).max() < STAGNATION * np.abs(previous).max():
            return v, passes + 1
    return v, settings.max_iterations
