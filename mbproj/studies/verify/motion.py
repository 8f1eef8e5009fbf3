"""Checks of the equations of motion: bordered, eliminated, reduced and planar give the same accelerations."""

from __future__ import annotations

import numpy as np

from mbproj.base.arrays import Array, cross
from mbproj.base.dataclass import dataclass
from mbproj.equations.constraints import set_jacobian, tangent_jacobian, time_derivative
from mbproj.equations.energy import kinetic_energy
from mbproj.equations.forces import applied
from mbproj.equations.kinematics import body_rates, pose_of, twist_of
from mbproj.equations.motions import drive_at
from mbproj.equations.of_motion import inertial_reaction, solve_bordered, solve_eliminated, tangent_mass_matrix
from mbproj.model.euler_parameters import matrix_L, rotation_matrix
from mbproj.studies.verify.case import Case, Found, difference, worse
from mbproj.studies.verify.equations import EPS, Rounded, concatenated, solve


def eliminated_is_bordered(case: Case) -> Found:
    """Compare q'' and λ of the eliminated equations (Eqs. 80-81) with those of the bordered equations (Eq. 14)."""
    known = case.equations
    terms = known.M.value, known.C_q.value, known.Q.value, known.gamma.value
    one, other = (np.concatenate(solver(*terms)) for solver in (solve_bordered, solve_eliminated))
    exact = known.taken_exactly()
    bound, n = exact.accelerations().error + exact.eliminated().error, 7 * case.system.bodies
    differences = [difference(other[:n], one[:n], bound[:n], np.tile([case.system.length] * 3 + [1.0] * 4, n // 7))]
    if len(one) > n:
        # Eq. 81 computes λ as a sum with γ. So its round-off is relative to the larger of the two.
        unit = 1.0 / case.system.row_scale[known.rows]
        largest = float(np.maximum(np.abs(one[n:]), np.abs(terms[3])).max())
        differences.append(difference(other[n:], one[n:], bound[n:], unit, largest))
    return worse(differences)


def reduced_is_bordered(case: Case) -> Found:
    """Compare r'', ω' and, where it is unique, λ of the kernel's reduced formulation with the solution of Eq. 14."""
    if isinstance(case.reduced, str):
        return case.reduced
    system, n = case.system, case.system.bodies
    y = case.reduced.state(case.state.q, case.state.v)
    solved = case.reduced.equations().accelerations(y, case.state.t, case.reference.tolist())
    if solved is None:
        return "in space the start is a singular pose"
    full, schur = tangent(case), _through_joints(case)
    length = np.tile([system.length] * 3 + [1.0] * 3, n)
    motion = difference(
        np.asarray(solved[0]).ravel(),
        full.acceleration.value,
        full.acceleration.error + schur.acceleration.error,
        length,
    )
    if case.redundant or not len(full.multipliers.value):
        return motion
    scale = 1.0 / system.row_scale[n:]
    bound = full.multipliers.error + schur.multipliers.error
    return worse([motion, difference(np.asarray(solved[1]), full.multipliers.value, bound, scale)])


def planar_is_bordered(case: Case) -> Found:
    """Compare x'', y'' and θ'' of the kernel's planar formulation with the solution of Eq. 14."""
    compiled = case.planar
    if isinstance(compiled, str):
        return compiled
    system, plane = case.system, compiled.plane
    assert plane is not None
    y, at = compiled.state(case.state.q, case.state.v), case.reference[plane.coordinates.source.source]
    solved = compiled.equations().accelerations(y, case.state.t, at.tolist())
    if solved is None:
        return "the start is a singular pose"
    full, schur = tangent(case), _through_joints(case)
    A = rotation_matrix(case.state.q.reshape(-1, 7)[:, 3:])
    value = _in_plane(full.acceleration.value, plane.axes, A)
    bound = _in_plane(full.acceleration.error + schur.acceleration.error, np.abs(plane.axes), np.abs(A))
    return difference(np.asarray(solved[0]), value, bound, np.array([system.length] * 2 + [1.0]))


@dataclass(frozen=True, eq=False)
class TangentSolution:
    """A solution in tangent coordinates: r'' (global axes) and ω' (body axes) of all bodies, (6n,), and the multipliers
    λ of the independent rows without the norm rows; each with its error bound."""

    acceleration: Rounded
    multipliers: Rounded


def tangent(case: Case) -> TangentSolution:
    """Return the solution of Eq. 14 in tangent coordinates. ω' = 2 L Λ'', because L' Λ' = 0."""
    n, solution = case.system.bodies, case.equations.accelerations()
    T = _to_tangent(case)
    return TangentSolution(Rounded.exact(T) @ solution[: 7 * n], solution[7 * n + n :])


def _to_tangent(case: Case) -> Array:
    """The matrix (6n, 7n) that maps (r'', Λ'') of each body to (r'', 2 L Λ'')."""
    n = case.system.bodies
    T = np.zeros((n, 6, n, 7))
    index = np.arange(n)
    T[index, :3, index, :3] = np.eye(3)
    T[index, 3:, index, 3:] = 2.0 * matrix_L(case.state.q.reshape(-1, 7)[:, 3:])
    return T.reshape(6 * n, 7 * n)


def _through_joints(case: Case) -> TangentSolution:
    """Solve with S = G W⁻¹ Gᵀ over the joints, as the kernel does, to bound the kernel's round-off. Where some body
    makes W singular, solve with A1 instead (Eqs. 80-81)."""
    system, n, known = case.system, case.system.bodies, case.equations
    if case.indefinite:
        solution = known.eliminated()
        return TangentSolution(Rounded.exact(_to_tangent(case)) @ solution[: 7 * n], solution[8 * n :])
    T = _to_tangent(case)
    back = np.asarray(np.linalg.pinv(T), dtype=float)  # δΛ = ½ Lᵀ δθ
    mass = Rounded.exact(tangent_mass_matrix(system, pose_of(case.state.q)))
    centripetal = np.zeros((n, 7))  # the part of Λ'' that does not depend on ω': it keeps |Λ| constant
    at, rate = case.state.q.reshape(-1, 7)[:, 3:], case.state.v.reshape(-1, 7)[:, 3:]
    centripetal[:, 3:] = -np.sum(rate**2, axis=1, keepdims=True) * at
    C_q, gamma = known.C_q[n:], known.gamma[n:] - known.C_q[n:] @ Rounded.exact(centripetal.ravel())
    G = C_q @ Rounded.exact(back)
    force = Rounded.exact(back.T) @ known.Q
    X, free = solve(mass, G.T), solve(mass, force)
    if not len(G.value):
        return TangentSolution(free, concatenated(gamma))
    multipliers = solve(G @ X, G @ free - gamma)
    return TangentSolution(free - X @ multipliers, multipliers)


def _in_plane(acceleration: Array, axes: Array, A: Array) -> Array:
    """Return x'', y'' and θ'' (n, 3) of the accelerations r'' and ω' (6n,) of all bodies. Given error bounds, and the
    absolute values of `axes` and `A`, return bounds."""
    parts = acceleration.reshape(-1, 6)
    turn = np.einsum("nij,nj->ni", A, parts[:, 3:])
    return np.column_stack([parts[:, :3] @ axes[:, :2], turn @ axes[:, 2]])


# --- Checks of the laws of mechanics at one state ---------------------------------------------------------------------
# Power, momentum, and that each joint's forces are in balance.


#: Operations behind one entry of the rows' gradients.
OPERATIONS = 8.0


def power(case: Case) -> Found:
    """Check that the kinetic energy changes at the power of gravity, forces and motions: joints do no work."""
    system, (force, torque), a = case.system, _loads(case), tangent(case).acceleration
    pose = pose_of(case.state.q)
    twist = twist_of(pose, case.state.v)
    v, omega = twist.velocity[:-1], body_rates(pose, twist)[:-1]
    motion, bound = a.value.reshape(-1, 6), a.error.reshape(-1, 6)
    inertial = np.concatenate([system.mass[:, None] * motion[:, :3], _spun(system.inertia, motion[:, 3:])], axis=1)
    speed = np.concatenate([v, omega], axis=1)
    acting = np.concatenate([force, torque], axis=1)
    drive, rows = drive_at(system, case.state.t), _motion_multipliers(case)
    if rows is None:
        return "redundant rows: the forces of motions are not unique"
    supplied = -float(rows[0] @ drive.rate)
    turning, turning_off, rate = _reflected(case)  # ½ Σ I s'² grows by Σ I s'' s'
    terms = np.concatenate([(inertial * speed).ravel(), (acting * speed).ravel(), turning * rate, [supplied]])
    off = np.concatenate([system.mass[:, None] * bound[:, :3], _spun(np.abs(system.inertia), bound[:, 3:])], axis=1)
    allowed = np.sum(np.abs(speed) * off) + turning_off @ np.abs(rate)
    allowed += len(terms) * EPS * np.abs(terms).sum() + _leak(case)
    allowed += float(rows[1] @ np.abs(drive.rate))
    total = float(np.sum(inertial * speed) - np.sum(acting * speed) + turning @ rate - supplied)
    size = max(float(np.abs(terms).max()), case.rate * float(kinetic_energy(system, pose, twist)))
    return difference(np.array([total]), np.zeros(1), np.array([allowed]), 1.0, size)


def _leak(case: Case) -> float:
    """Bound the power (W) of the reactions in joints that move apart by round-off: |λ| |C_q v + C_t|, both with their
    errors."""
    system, known, v = case.system, case.equations, Rounded.exact(case.state.v)
    apart = known.C_q @ v
    rate = time_derivative(system, drive_at(system, case.state.t))[known.rows]
    multipliers = known.accelerations()[7 * system.bodies :]
    return float((np.abs(multipliers.value) + multipliers.error) @ (np.abs(apart.value + rate) + apart.error))


def momentum(case: Case) -> Found:
    """Check that the linear momentum, and the angular momentum about the origin, change only by gravity, forces and
    reactions of the ground."""
    system, (force, torque), solution = case.system, _loads(case), tangent(case)
    n, pose = system.bodies, pose_of(case.state.q)
    A, position = pose.rotation[:-1], pose.position[:-1]
    motion, bound = (part.reshape(-1, 6) for part in (solution.acceleration.value, solution.acceleration.error))
    push = system.mass[:, None] * motion[:, :3] - force
    turn = np.einsum("nij,nj->ni", A, _spun(system.inertia, motion[:, 3:]) - torque)
    push_off = system.mass[:, None] * bound[:, :3] + EPS * np.abs(push)
    turn_off = np.einsum("nij,nj->ni", np.abs(A), _spun(np.abs(system.inertia), bound[:, 3:])) + EPS * np.abs(turn)
    turning, turning_off, _ = _reflected(case)
    pull = Rounded(np.append(solution.multipliers.value, turning), np.append(solution.multipliers.error, turning_off))
    rows = np.append(case.equations.rows[n:] - n, np.arange(len(turning)) + system.constraints - n)
    ground, ground_off = np.zeros(6), np.zeros(6)
    if len(rows):
        wrench = _wrenches(case)[rows, -1]  # forces and torques on the ground, about the origin
        ground = pull.value @ wrench
        ground_off = pull.error @ np.abs(wrench) + len(rows) * EPS * np.abs(pull.value) @ np.abs(wrench)
    total = np.concatenate([push.sum(axis=0), (turn + cross(position, push)).sum(axis=0)])
    arms = np.abs(position)
    lever = arms[:, [1, 2, 0]] * push_off[:, [2, 0, 1]] + arms[:, [2, 0, 1]] * push_off[:, [1, 2, 0]]
    allowed = np.concatenate([push_off.sum(axis=0), (turn_off + lever).sum(axis=0)]) + ground_off
    sizes = np.concatenate([np.abs(push).sum(axis=0), (np.abs(turn) + np.abs(cross(position, push))).sum(axis=0)])
    sizes += np.abs(ground)
    allowed += 6 * (n + 1) * EPS * sizes
    # The constraint forces on the bodies are -Gᵀλ; those on the ground are in balance with them.
    scale = np.array([1.0] * 3 + [system.length] * 3)
    weight = float(np.abs(system.mass).max() * max(np.abs(motion[:, :3]).max(), np.linalg.norm(system.gravity)))
    return difference(total, ground, allowed, scale, max(float((sizes / scale).max()), weight))


def action_is_reaction(case: Case) -> Found:
    """Check that the forces of each row of C, and of each reflected inertia, on all bodies and the ground sum to zero.
    So do their torques. Hence no row changes where the whole mechanism is shifted or turned."""
    if case.system.constraints == case.system.bodies:
        return "no joints"
    wrench = _wrenches(case)
    bound = OPERATIONS * (case.system.bodies + 1) * EPS * np.abs(_wrenches(case, sizes=True)).sum(axis=1)
    scale = np.array([1.0] * 3 + [case.system.length] * 3)
    return worse(
        [
            difference(row.sum(axis=0), np.zeros(6), allowed, scale, float(np.abs(row / scale).max()))
            for row, allowed in zip(wrench, bound, strict=True)
        ]
    )


def _loads(case: Case) -> tuple[Array, Array]:
    """The forces (n, 3) on the bodies from gravity and the scene, global axes, and the torques (n, 3) with the
    gyroscopic ones, body axes."""
    system, state = case.system, case.state
    pose = pose_of(state.q)
    twist = twist_of(pose, state.v)
    omega = body_rates(pose, twist)[:-1]
    force = system.mass[:, None] * system.gravity
    torque = -cross(omega, _spun(system.inertia, omega))
    loads = applied(state.instant(system))
    return force + loads.force[:-1], torque + loads.torque[:-1]


def _spun(inertia: Array, omega: Array) -> Array:
    """The product J ω of each body, (n, 3)."""
    return np.einsum("nij,nj->ni", inertia, omega)


def _motion_multipliers(case: Case) -> tuple[Array, Array] | None:
    """The multipliers λ of the rows of motions, and their error bounds; None where one of these rows depends on
    others."""
    driven, solution = case.system.driven, tangent(case).multipliers
    if not driven:
        return np.zeros(0), np.zeros(0)
    driven_rows = case.equations.rows >= case.system.constraints - driven
    if np.count_nonzero(driven_rows) < driven:
        return None
    return solution.value[-driven:], solution.error[-driven:]


def _reflected(case: Case) -> tuple[Array, Array, Array]:
    """The force I s'' of each reflected inertia, its error bound, and the rate s' of its coordinate; each (k,)."""
    reflected, n = case.system.reflected, case.system.bodies
    pose = pose_of(case.state.q)
    twist = twist_of(pose, case.state.v)
    change = case.equations.accelerations()[: 7 * n]
    reaction = inertial_reaction(reflected, pose, twist, twist_of(pose, change.value))
    terms = np.abs(set_jacobian(reflected.rows, pose))
    off = reflected.inertia * (terms @ (change.error + OPERATIONS * EPS * np.abs(change.value)))
    return -reaction.force, off, np.asarray(reaction.rate)


def _wrenches(case: Case, *, sizes: bool = False) -> Array:
    """The gradients of the rows without norm rows, then of the coordinates with a reflected inertia, as forces and
    torques. They act on each body and the ground, torques about the origin, global axes, (m, n+1, 6). `sizes`: return
    instead the size of the terms that each is the sum of."""
    pose = pose_of(case.state.q)
    sets = case.system.rows, case.system.reflected.rows
    G = np.concatenate([tangent_jacobian(bound, pose) for bound in sets])
    force, torque = G[..., :3], np.einsum("nij,mnj->mni", pose.rotation, G[..., 3:6])
    if sizes:
        longest = np.abs(pose.position).max(axis=-1)[:, None] + case.system.length
        whole = np.abs(force).max(axis=-1, keepdims=True)
        turned = np.abs(torque).max(axis=-1, keepdims=True) + longest * whole
        return np.concatenate([np.broadcast_to(whole, force.shape), np.broadcast_to(turned, force.shape)], axis=-1)
    return np.concatenate([force, torque + cross(pose.position, force)], axis=-1)
