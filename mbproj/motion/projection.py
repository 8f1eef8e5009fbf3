"""The projection of a state, Eqs. 37-74: when it is due, and the iteration to C = 0 with any method's correction.

Where the full correction does not reduce the violation, or turns a body too far for its linearised rows, smaller ones
are tried in turn. A metric by masses turns bodies of small inertia by large angles to avoid motions of heavy bodies.
The smallest correction that turns no body by more than ϑ is that of a metric with moments of inertia added to such
bodies: min ½ΔᵀMΔ subject to C_q Δ = -C and |δθ_b| <= ϑ has the conditions (M + Σ μ_b E_b) Δ + C_qᵀλ = 0, with μ_b >= 0
where the bound holds (a trust region: Conn, Gould & Toint 2000, sect. 7). It closes the rows to first order, with an
error of order ϑ², so that some ϑ reduces the violation wherever C_q has full rank.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.constraint_equations import constraint, jacobian, time_derivative
from mbproj.dynamics.equations.equations_of_motion import mass_matrix
from mbproj.dynamics.equations.kinematics import Pose, pose_of
from mbproj.dynamics.equations.motions import NO_DRIVE, Drive
from mbproj.dynamics.equations.round_off import position_grain
from mbproj.dynamics.rank.row_set import RowSet
from mbproj.model.system import System
from mbproj.projection.methods import Gopm, Projection
from mbproj.scene.records import ProjectionSettings
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class ProjectedState:
    """The state (q, v) after a projection, and counts: whether it was projected, passes at both levels, positions that
    did not meet their test, and uses of the fallback.

    `left_open`: the violation of rows that were not held, near a singular pose, in units of the mechanism's length.
    `nearest`: the smallest distance of the poses from a singular one, as a part of the largest of the run."""

    q: Array
    v: Array
    projections: int = 0
    position_iterations: int = 0
    velocity_iterations: int = 0
    failures: int = 0
    fallbacks: int = 0
    left_open: float = 0.0
    nearest: float = 1.0


@dataclass(frozen=True, eq=False)
class Position:
    """q after a projection, the passes taken, whether the stop test was met, and whether the fallback was needed.
    `left_open` and `nearest` are those of `ProjectedState`."""

    q: Array
    passes: int
    met: bool
    fell_back: bool = False
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
    closed = correct_position(system, method, settings, rows, q, drive) if position else Position(q, 0, met=True)
    passes, nearest = 0, closed.nearest
    if velocity:
        v, passes, nearness = correct_velocity(system, method, settings, rows, pose_of(closed.q), v, drive)
        nearest = min(nearest, nearness)
    counts = 1, closed.passes, passes, int(not closed.met), int(closed.fell_back)
    return ProjectedState(closed.q, v, *counts, closed.left_open, nearest)


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


def correct_position(
    system: System,
    method: Projection,
    settings: ProjectionSettings,
    rows: RowSet,
    q: Array,
    drive: Drive = NO_DRIVE,
) -> Position:
    """Return q with C(q) = 0 by the chosen test. Where the method does not converge, GOPM's metric is used if
    allowed."""
    correct = _by_violation if settings.test == "violation" else _by_paper
    corrected = correct(system, method, settings, rows, q, drive)
    if corrected.met or settings.fallback == "none":
        return corrected
    again = _by_violation(system, Gopm(), settings, rows, q, drive)
    nearest = min(corrected.nearest, again.nearest)
    return replace(again, passes=corrected.passes + again.passes, fell_back=True, nearest=nearest)


def _by_violation(
    system: System, method: Projection, settings: ProjectionSettings, rows: RowSet, q: Array, drive: Drive
) -> Position:
    """Iterate until |C| <= tolerance in every row.

    Of the corrections to try, the first is taken that reduces the violation by half of the reduction that Newton's
    method promises. Where none does, round-off is reached, or the iteration does not converge."""
    pose = pose_of(q)
    C, left_open, nearest = constraint(system, pose, drive), 0.0, 1.0
    tolerances = row_tolerances(system, settings, pose)
    for passes in range(settings.max_iterations):
        if np.all(np.abs(C) <= tolerances):
            return Position(q, passes, met=True, nearest=nearest)
        held = rows.to_close(pose, C)
        nearest = min(nearest, held.nearness)
        left_open = held.open(C)
        if left_open and np.all(np.abs(held.closes(C)) <= tolerances):
            return Position(q, passes, met=True, left_open=left_open, nearest=nearest)
        grains = THRESHOLDS.round_off_grains * position_grain(system, pose)
        last = bool(np.all(np.abs(C) <= np.maximum(grains, tolerances)))
        left = _scaled(system, pose, held.closes(C))
        for change, part in damped(method, mass_matrix(system, pose), held.C_q, held.combined(C), q):
            pose = pose_of(q + change)
            C = constraint(system, pose, drive)
            if _scaled(system, pose, held.closes(C)) < (1.0 - 0.5 * part) * left:
                break
            if last:
                return Position(q, passes + 1, met=True, left_open=left_open, nearest=nearest)
        else:
            return Position(q, passes + 1, met=False, left_open=left_open, nearest=nearest)
        q = q + change
    met = bool(np.all(np.abs(C) <= tolerances))
    return Position(q, settings.max_iterations, met=met, left_open=left_open, nearest=nearest)


def _scaled(system: System, pose: Pose, C: Array) -> float:
    """Return the largest |C| of the rows that are open by more than round-off, in units of the mechanism's length. Rows
    at the end of a long chain close only to round-off, which must not decide on a correction at its beginning."""
    beyond = ~(np.abs(C) <= THRESHOLDS.closed_grains * position_grain(system, pose))
    return float(np.max(np.abs(C / system.row_scale), where=beyond, initial=0.0))


def _by_paper(
    system: System, method: Projection, settings: ProjectionSettings, rows: RowSet, q: Array, drive: Drive
) -> Position:
    """Iterate until ΔqᵀMΔq + CᵀC <= tolerance: the paper's test (sect. 5) in the metric of Eq. 72. M alone is singular
    along Λ, so that its length would not count."""
    tolerance = THRESHOLDS.paper_tolerance if settings.tolerance is None else settings.tolerance
    nearest = 1.0
    for passes in range(settings.max_iterations):
        pose = pose_of(q)
        M, C = mass_matrix(system, pose), constraint(system, pose, drive)
        held = rows.to_close(pose, C)
        nearest = min(nearest, held.nearness)
        change = method.correction(M, held.C_q, held.combined(C))
        q = q + change
        if change @ M @ change + C @ C <= tolerance:
            return Position(q, passes + 1, met=True, left_open=held.open(C), nearest=nearest)
    return Position(q, settings.max_iterations, met=False, nearest=nearest)


def row_tolerances(system: System, settings: ProjectionSettings, pose: Pose) -> Array:
    """Return the tolerance of each row of C, (m,): that of the settings, or max(1e-13, 4 ε × the largest coordinate in
    the row)."""
    if settings.tolerance is not None and settings.test == "violation":
        return np.full(system.constraints, settings.tolerance)
    return np.maximum(
        THRESHOLDS.closed_to * np.minimum(1.0, system.row_scale),
        THRESHOLDS.closed_grains * position_grain(system, pose),
    )


def damped(method: Projection, M: Array, C_q: Array, violation: Array, q: Array) -> Iterator[tuple[Array, float]]:
    """Yield corrections Δ (7n,) of q (7n,) for a violation (m,), each with the part of it that Δ closes to first order.

    The first is the method's correction, unless it turns a body too far. The next are the smallest in its metric with
    ever tighter limits on turns. After these, or where the metric cannot limit turns, the method's correction is
    shortened."""
    whole = method.correction(M, C_q, violation)
    widest = _widest(whole, q)
    limit = THRESHOLDS.widest_turn
    if widest <= limit:
        yield whole, 1.0
        limit = THRESHOLDS.tighter * widest
    for _ in range(THRESHOLDS.most_halvings):
        change = _turning_less(method, M, C_q, violation, q, limit)
        if change is None:
            break
        yield change, 1.0
        limit = THRESHOLDS.tighter * min(limit, _widest(change, q))
    part = min(0.5, THRESHOLDS.widest_turn / widest) if widest > 0.0 else 0.5
    while part >= 0.5**THRESHOLDS.most_halvings:
        yield part * whole, part
        part *= 0.5


def _turning_less(method: Projection, M: Array, C_q: Array, violation: Array, q: Array, limit: float) -> Array | None:
    """Return a correction, nearly the smallest in energy, that turns no body by more than `limit` (rad). Return None
    where moments of inertia do not limit turns: in GOPM's metric, or where the rows prescribe the turn."""
    if not limit > 0.0:
        return None
    Λ = q.reshape(-1, 7)[:, 3:]
    index = np.arange(len(Λ))
    across = 4.0 * (np.eye(4) - Λ[:, :, None] * Λ[:, None, :] / np.sum(Λ * Λ, axis=-1)[:, None, None])
    blocks = M.reshape(len(Λ), 7, len(Λ), 7)
    moment = np.einsum("bibi->b", blocks[:, 3:, :, 3:]) / 12.0
    moment = np.maximum(moment, THRESHOLDS.lent_part * moment.mean())
    added, before = np.zeros(len(Λ)), None
    for _ in range(THRESHOLDS.most_passes):
        stiff = blocks.copy()
        stiff[index, 3:, index, 3:] += added[:, None, None] * across
        try:
            change = method.correction(stiff.reshape(M.shape), C_q, violation)
        except np.linalg.LinAlgError:
            return None
        turns = _turns(change, q)
        if np.all(turns <= limit):
            return change
        if before is not None and np.array_equal(change, before):
            return None
        added = np.where(turns > limit, added + THRESHOLDS.stiffer * (moment + added) * turns / limit, added)
        before = change
    return None


def _turns(change: Array, q: Array) -> Array:
    """Return the turn of each body by a change of q, (n,), to first order: 2 |ΔΛ| across Λ."""
    Λ, ΔΛ = q.reshape(-1, 7)[:, 3:], change.reshape(-1, 7)[:, 3:]
    across = ΔΛ - np.sum(ΔΛ * Λ, axis=-1, keepdims=True) * Λ
    return np.asarray(2.0 * np.linalg.norm(across, axis=-1))


def _widest(change: Array, q: Array) -> float:
    return float(_turns(change, q).max())
