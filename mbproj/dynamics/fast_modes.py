"""How fast the forces of a scene alone move a mechanism: the eigenvalues of their linear part at a state.

Along the coordinates s of the laws that depend on them, forces F = -k δs - c δs' make δs'' = W F, with W what a unit
force on one coordinate makes of the acceleration along another, joints closed: δs'' = -W (k δs + c δs'). Gravity,
spin, and what the bodies' motion changes in W are left out: a stiff force is faster than those.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbproj.arrays import Array, Integers, cross, distinct_rows
from mbproj.dynamics.assembly.assemble import State, coordinate_values
from mbproj.dynamics.derivatives.law_derivatives import law_slopes
from mbproj.dynamics.equations.equations_of_motion import mass_matrix
from mbproj.dynamics.equations.forces import generalised, law_state, unit_pull
from mbproj.dynamics.equations.kinematics import Pose, attached, pose_of, slots_of, twist_of
from mbproj.dynamics.rank.row_space import scaled_jacobian
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class Slopes:
    """-∂F/∂s and -∂F/∂s' of each law at a state, (E,), in N/m or N m/rad, and N s/m or N m s/rad."""

    stiffness: Array
    damping: Array

    @property
    def acting(self) -> Integers:
        """The laws whose force depends on their coordinate or its rate."""
        return np.flatnonzero((self.stiffness != 0.0) | (self.damping != 0.0))


@dataclass(frozen=True, eq=False)
class Mode:
    """An eigenvalue λ in 1/s, and the part that each law has in its energy, (E,)."""

    eigenvalue: complex
    shares: Array


def slopes(system: System, state: State) -> Slopes:
    """The laws' slopes at a state; 0 where a function has no finite slope (at the root of its √, say)."""
    forces = system.forces
    assert forces is not None
    pose = pose_of(state.q)
    reference = coordinate_values(system, pose) + 2.0 * np.pi * state.turns
    laws = law_state(forces, pose, twist_of(pose, state.v), state.t, reference)
    found = (np.nan_to_num(-part, nan=0.0, posinf=0.0, neginf=0.0) for part in law_slopes(forces, laws, state.t))
    return Slopes(*found)


def speeds_of_free_bodies(system: System, pose: Pose, slopes: Slopes) -> Array:
    """Of each law what bounds its part in |λ|, (E,), 1/s: √(k w) + c w on bodies that nothing else holds, each with its
    mass divided among the laws on it (Irons & Treharne 1971)."""
    assert system.forces is not None
    bound, n = system.forces.laws.coordinates, system.bodies
    gradient = bound.gradient_entries(attached(pose, *slots_of(bound)))
    body = bound.body[bound.entry_slot]
    pairs, pair = distinct_rows(np.stack([bound.entry_row, body], axis=1))
    force, torque = np.zeros((len(pairs), 3)), np.zeros((len(pairs), 3))
    np.add.at(force, pair, bound.is_point[bound.entry_slot, None] * gradient)
    local = (gradient[:, None, :] @ pose.rotation[body])[:, 0, :]
    np.add.at(torque, pair, cross(bound.local[bound.entry_slot], local))
    moves = pairs[:, 1] < n
    law, body, force, torque = pairs[moves, 0], pairs[moves, 1], force[moves], torque[moves]
    on_body = np.bincount(body, minlength=n)[body]
    with np.errstate(divide="ignore", invalid="ignore"):  # a body without mass gives way at once
        turned = np.sum(torque * (np.linalg.pinv(system.inertia[body]) @ torque[..., None])[..., 0], axis=1)
        gives = on_body * (np.sum(force * force, axis=1) / system.mass[body] + turned)
    w = np.bincount(law, np.nan_to_num(gives, nan=np.inf), minlength=len(slopes.stiffness))
    with np.errstate(invalid="ignore"):
        return np.nan_to_num(np.sqrt(np.abs(slopes.stiffness) * w) + np.abs(slopes.damping) * w, posinf=np.inf)


def responses(system: System, pose: Pose, laws: Integers) -> Array:
    """W, (e, e), of these laws, m or rad per s² and N or N m: with N a basis of the velocities that the joints allow,
    Jᵀ N (NᵀMN)⁻¹ Nᵀ J. Raises LinAlgError where these move no mass."""
    forces = system.forces
    assert forces is not None
    pulls = np.array([generalised(pose, *unit_pull(forces, pose, int(law))) for law in laws])
    _, sigma, directions = np.linalg.svd(scaled_jacobian(system, pose))
    lengths = np.tile([system.length] * 3 + [1.0] * 4, system.bodies)
    free = directions[int(np.count_nonzero(sigma > THRESHOLDS.dependent)) :] * lengths
    along = free @ pulls.T
    return np.asarray(along.T @ np.linalg.solve(free @ mass_matrix(system, pose) @ free.T, along))


def fastest_mode(W: Array, laws: Integers, slopes: Slopes) -> Mode | None:
    """The fastest of the modes that do not grow by themselves by more than `growing` of their |λ|; None without any."""
    count, k, c = len(laws), slopes.stiffness[laws], slopes.damping[laws]
    matrix = np.zeros((2 * count, 2 * count))
    matrix[:count, count:] = np.eye(count)
    matrix[count:, :count], matrix[count:, count:] = -W * k, -W * c
    if not count or not np.all(np.isfinite(matrix)):
        return None
    values, vectors = np.linalg.eig(matrix)
    speed = np.where(values.real <= THRESHOLDS.growing * np.abs(values), np.abs(values), 0.0)
    at = int(np.argmax(speed))
    if not speed[at] > 0.0:
        return None
    energy = np.abs(k) * np.abs(vectors[:count, at]) ** 2 + np.abs(c) * np.abs(vectors[count:, at]) ** 2 / speed[at]
    shares = np.zeros(len(slopes.stiffness))
    shares[laws] = energy / max(float(energy.sum()), np.finfo(float).tiny)
    return Mode(complex(values[at]), shares)
