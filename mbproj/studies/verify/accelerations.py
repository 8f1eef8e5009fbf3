"""Checks of the equations of motion: bordered, eliminated, reduced and planar give the same accelerations."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.equations_of_motion import solve_bordered, solve_eliminated, tangent_mass_matrix
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.model.euler_parameters import matrix_L, rotation_matrix
from mbproj.studies.verify.case import Case
from mbproj.studies.verify.finding import Found, difference, worse
from mbproj.studies.verify.rounded import Rounded, concatenated, solve


def eliminated_is_bordered(case: Case) -> Found:
    """Compare q'' and λ of the eliminated equations (Eqs. 80-81) with those of the bordered equations (Eq. 14)."""
    if case.too_large:
        return case.too_large
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
    if case.too_large or isinstance(case.reduced, str):
        return case.too_large or str(case.reduced)
    system, n = case.system, case.system.bodies
    y = case.reduced.state(case.state.q, case.state.v)
    solved = case.reduced.equations().accelerations(y, case.state.t, case.reference.tolist())
    if solved is None:
        return "in space the start is a singular pose"
    full, own = tangent(case), _through_joints(case)
    length = np.tile([system.length] * 3 + [1.0] * 3, n)
    motion = difference(
        np.asarray(solved[0]).ravel(), full.acceleration.value, full.acceleration.error + own.acceleration.error, length
    )
    if case.redundant or not len(full.multipliers.value):
        return motion
    scale = 1.0 / system.row_scale[n:]
    bound = full.multipliers.error + own.multipliers.error
    return worse([motion, difference(np.asarray(solved[1]), full.multipliers.value, bound, scale)])


def planar_is_bordered(case: Case) -> Found:
    """Compare x'', y'' and θ'' of the kernel's planar formulation with the solution of Eq. 14."""
    compiled = case.planar
    if case.too_large or isinstance(compiled, str):
        return case.too_large or str(compiled)
    system, plane = case.system, compiled.plane
    assert plane is not None
    y, at = compiled.state(case.state.q, case.state.v), case.reference[plane.coordinates.source.source]
    solved = compiled.equations().accelerations(y, case.state.t, at.tolist())
    if solved is None:
        return "the start is a singular pose"
    full, own = tangent(case), _through_joints(case)
    A = rotation_matrix(case.state.q.reshape(-1, 7)[:, 3:])
    value = _in_plane(full.acceleration.value, plane.axes, A)
    bound = _in_plane(full.acceleration.error + own.acceleration.error, np.abs(plane.axes), np.abs(A))
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
    kept = np.zeros((n, 7))  # the part of Λ'' that does not depend on ω': it keeps |Λ| constant
    at, rate = case.state.q.reshape(-1, 7)[:, 3:], case.state.v.reshape(-1, 7)[:, 3:]
    kept[:, 3:] = -np.sum(rate**2, axis=1, keepdims=True) * at
    C_q, gamma = known.C_q[n:], known.gamma[n:] - known.C_q[n:] @ Rounded.exact(kept.ravel())
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
