"""What round-off may do at a state, from the equations' own condition: the tolerances of the comparison."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mbproj import System
from mbproj.base.arrays import Array, Integers
from mbproj.equations.constraints import gamma, jacobian
from mbproj.equations.kinematics import pose_of, twist_of
from mbproj.equations.of_motion import generalised_force, mass_matrix
from mbproj.motion.formulations.full import Accelerations

#: Roundings that add up in an entry of the equations and of their solution, as a relative error: some 450 ε.
ROUND_OFF = 1e-13
#: Singular values of the scaled equations below this part of the largest belong to redundant rows.
NONE = 1e-10
#: The relative change of a state whose effect is measured.
NUDGE = 1e-9


@dataclass(frozen=True, eq=False)
class RoundOff:
    """At a state: the errors that round-off may leave in q'' (7n,) and in λ (m,), those in C_qᵀλ (7n,), how far a
    violation of 1 in all rows moves the coordinates, at most (7n,), and the condition of the scaled equations."""

    acceleration: Array
    multipliers: Array
    load: Array
    moved: Array
    condition: float


def round_off(system: System, q: Array, v: Array, solve: Callable[[Array, Array], Accelerations]) -> RoundOff:
    """`solve(q, v)` are the full equations' solutions near the state.

    The solution x of K x = b, Eq. 14, is uncertain by ε |K⁻¹| (|K||x| + |b|), component by component (Skeel 1979), and
    by what coordinates that are known to ε of their size make of it, which is found by changing them. Components are
    taken together that a choice of axes mixes, and none is known to more than ε of the largest in the mechanism: what
    does not move at all has accelerations of free fall that reactions cancel.
    """
    pose = pose_of(q)
    twist = twist_of(pose, v)
    M, C_q, n = mass_matrix(system, pose), jacobian(system, pose), 7 * system.bodies
    K = np.block([[M, C_q.T], [C_q, np.zeros((len(C_q), len(C_q)))]])
    scale = _scale(system, M, C_q)
    scaled = K * scale[:, None] * scale
    values = np.linalg.svd(scaled, compute_uv=False)
    group = _vectors(system)
    K = _alike(_alike(K, group).T, group)
    inverse = _alike(_alike(np.linalg.pinv(scaled, rcond=NONE) * scale[:, None] * scale, group).T, group)
    found = solve(q, v)
    x = np.concatenate([found.acceleration, found.multipliers])
    b = np.concatenate([generalised_force(system, pose, twist), gamma(system, pose, twist)])
    error = inverse @ (K @ _alike(x, group) + _alike(b, group))
    error += _alike(_by_state(system, q, v, x, solve), group)
    largest = np.abs(found.multipliers * system.row_scale).max() / system.row_scale
    error += np.concatenate([_cancelled(system, M, C_q, x, b), largest])
    kept = values[values > NONE * values[0]]
    return RoundOff(
        ROUND_OFF * error[:n],
        ROUND_OFF * error[n + system.bodies :],
        ROUND_OFF * (K[:n, n:] @ error[n:] + K[:n, :n] @ error[:n]),
        inverse[:n, n:].sum(axis=1),
        float(values[0] / kept[-1]),
    )


def _cancelled(system: System, M: Array, C_q: Array, x: Array, b: Array) -> Array:
    """The accelerations that forces and reactions would give a body by themselves, which cancel in q'', (7n,): those of
    the body, and of the rest what the largest force would give it, at most the largest acceleration."""
    n, L = 7 * system.bodies, system.length
    units = np.r_[[L] * 3, [1.0] * 4]
    pull = (np.abs(b[:n]) + np.abs(C_q.T) @ np.abs(x[n:])).reshape(-1, 7) * units
    own = np.array([M[at : at + 7, at : at + 7] for at in range(0, n, 7)])
    smallest = np.linalg.eigvalsh(own[:, 3:, 3:])[:, 1]  # the one before is zero, that of the length of Λ
    inertia = np.minimum(own[:, 0, 0] * L**2, smallest)
    by_itself = np.maximum(pull.max(axis=1) / inertia, np.abs(x[:n].reshape(-1, 7) / units).max(axis=1))
    by_others = np.minimum(pull.max() / inertia, by_itself.max())
    return (np.maximum(by_itself, by_others)[:, None] * units).ravel()


def _vectors(system: System) -> Integers:
    """The number of the vector that each unknown belongs to, (7n + m,): r'' and Λ'' of bodies; the multipliers of norm
    rows one by one, those of a joint's rows by their unit."""
    bodies = np.repeat(np.arange(2 * system.bodies), np.tile([3, 4], system.bodies))
    norms = len(bodies) + np.arange(system.bodies)
    joints = norms[-1] + 1 + 2 * system.joints.owner + system.joints.is_length
    return np.unique(np.concatenate([bodies, norms, joints]), return_inverse=True)[1]


def _alike(values: Array, group: Integers) -> Array:
    """The magnitudes along the first axis, each that of the largest in its group."""
    largest = np.zeros((int(group.max()) + 1, *values.shape[1:]))
    np.maximum.at(largest, group, np.abs(values))
    return largest[group]


def _scale(system: System, M: Array, C_q: Array) -> Array:
    """Factors that make the mass matrix of the order of 1 and give rows unit length, (7n + m,)."""
    blocks = M.reshape(system.bodies, 7, system.bodies, 7)
    index = np.arange(system.bodies)
    own = blocks[index, :, index, :]
    coordinates = np.empty((system.bodies, 7))
    coordinates[:, :3] = own[:, :1, 0]
    coordinates[:, 3:] = np.trace(own[:, 3:, 3:], axis1=1, axis2=2)[:, None]
    across = 1.0 / np.sqrt(coordinates.ravel())
    return np.concatenate([across, 1.0 / np.linalg.norm(C_q * across, axis=1)])


def _by_state(system: System, q: Array, v: Array, x: Array, solve: Callable[[Array, Array], Accelerations]) -> Array:
    """The largest change of x for random changes of the state, over the relative size of these."""
    rng, largest = np.random.default_rng(3), np.zeros(len(x))
    place, rate = q.reshape(-1, 7), v.reshape(-1, 7)
    reach = np.abs(place[:, :3]).max() + system.length
    turning = max(np.abs(rate[:, 3:]).max(), np.abs(rate[:, :3]).max() / system.length)
    sizes = np.tile(np.r_[[reach] * 3, [1.0] * 4], system.bodies)
    speeds = np.tile(np.r_[[np.abs(rate[:, :3]).max() + turning * reach] * 3, [turning] * 4], system.bodies)
    for _ in range(3):
        change = NUDGE * rng.choice([-1.0, 1.0], size=(2, len(q)))
        near = solve(q + change[0] * sizes, v + change[1] * speeds)
        largest = np.maximum(largest, np.abs(np.concatenate([near.acceleration, near.multipliers]) - x))
    return np.asarray(largest / NUDGE, dtype=float)
