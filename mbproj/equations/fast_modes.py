"""Rates at which forces and states of elements change a mechanism: the eigenvalues of their linear part at a state.

Laws and bushings depend on coordinates s. Their forces F = -k δs - c δs' make δs'' = W F. An entry of W is the
acceleration along one coordinate by a unit force along another, with the joints closed: δs'' = -W (k δs + c δs'). k and
c are diagonal but for bushings, which couple their six coordinates. Gravity, spin, preloads and the change of W by the
bodies' motion are left out: stiff forces are faster than these effects. States have δx' = f_x δx.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers, cross, distinct_rows, may_overflow
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.derivatives import law_slopes
from mbproj.equations.forces import deflection, generalised, law_state, unit_pull, viscous
from mbproj.equations.instant import Instant
from mbproj.equations.kinematics import Pose, attached, slots_of
from mbproj.equations.of_motion import mass_matrix
from mbproj.equations.rank.row_space import scaled_jacobian
from mbproj.model.forces import COORDINATES, Bushings, Forces
from mbproj.model.system import System


@dataclass(frozen=True, eq=False)
class ForceSlopes:
    """-∂F/∂s and -∂F/∂s' along each of the F coordinates of forces, (F,), in N/m or N m/rad, and N s/m or N m s/rad.

    Slopes of laws come first, and then the diagonals of `bushings`, whose damping is the one at this pose."""

    stiffness: Array
    damping: Array
    bushings: Bushings

    @property
    def acting(self) -> Integers:
        """The coordinates whose force depends on them or their rates."""
        return np.flatnonzero((self.stiffness != 0.0) | (self.damping != 0.0))

    def matrices(self, chosen: Integers) -> tuple[Array, Array]:
        """Return k and c along the `chosen` coordinates, (e, e)."""
        k, c = np.diag(self.stiffness[chosen]), np.diag(self.damping[chosen])
        bushing, component = np.divmod(chosen - (len(self.stiffness) - self.bushings.preload.size), len(COORDINATES))
        row, column = np.nonzero((bushing[:, None] == bushing) & (bushing >= 0))
        for matrix, blocks in ((k, self.bushings.stiffness), (c, self.bushings.damping)):
            matrix[row, column] = blocks[bushing[row], component[row], component[column]]
        return k, c

    @property
    def rows(self) -> tuple[Array, Array]:
        """The sums of |k| and |c| over each row, (F,)."""
        sums = []
        for diagonal, blocks in ((self.stiffness, self.bushings.stiffness), (self.damping, self.bushings.damping)):
            laws = np.abs(diagonal[: len(diagonal) - self.bushings.preload.size])
            sums.append(np.concatenate([laws, np.abs(blocks).sum(axis=-1).ravel()]))
        return sums[0], sums[1]


@dataclass(frozen=True, eq=False)
class Mode:
    """An eigenvalue λ in 1/s with its eigenvector's `force` along the chosen coordinates, (e,). `shares` (F + K,): the
    part of each coordinate's force in the mode's energy. Where states of elements dominate the mode, it is the
    participation of each state (Pérez-Arriaga et al. 1982)."""

    eigenvalue: complex
    shares: Array
    force: Numbers

    @property
    def moves_bodies(self) -> bool:
        """Whether forces take part in the mode."""
        return bool(np.abs(self.force).max(initial=0.0) > 0.0)


def slopes(system: System, state: State) -> ForceSlopes:
    """Return the forces' slopes at a state; 0 where a function has no finite slope (at the root of its √, say)."""
    return slopes_at(state.instant(system))


def slopes_at(instant: Instant) -> ForceSlopes:
    """Return the forces' slopes at an instant; 0 where a function has no finite slope."""
    laws, bushings = law_state(instant), instant.system.forces.bushings
    if laws.bent is not None:
        bushings = replace(bushings, damping=viscous(bushings, laws.bent))
    stiffness, damping = (
        np.concatenate([np.nan_to_num(-slope, nan=0.0, posinf=0.0, neginf=0.0), bushings.on_diagonal(matrices)])
        for slope, matrices in zip(law_slopes(instant, laws), (bushings.stiffness, bushings.damping), strict=True)
    )
    return ForceSlopes(stiffness, damping, bushings)


def speeds_of_free_bodies(system: System, pose: Pose, slopes: ForceSlopes) -> Array:
    """Return, for each coordinate, a bound of its part in |λ|, (F,), 1/s.

    It is √(k w) + c w for bodies without joints, each with its mass divided among the forces on it (Irons & Treharne
    1971)."""
    n = system.bodies
    law, body, force, torque = _pulls(system.forces, pose)
    moves = body < n
    law, body, force, torque = law[moves], body[moves], force[moves], torque[moves]
    on_body = np.bincount(body, minlength=n)[body]
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # a body without mass has infinite w
        turned = np.sum(torque * (np.linalg.pinv(system.inertia[body]) @ torque[..., None])[..., 0], axis=1)
        gives = on_body * (np.sum(force * force, axis=1) / system.mass[body] + turned)
    w = np.bincount(law, np.nan_to_num(gives, nan=np.inf), minlength=len(slopes.stiffness))
    k, c = slopes.rows
    with may_overflow():
        return np.nan_to_num(np.sqrt(k * w) + c * w, posinf=np.inf)


def _pulls(forces: Forces, pose: Pose) -> tuple[Integers, Integers, Array, Array]:
    """Return unit forces along each coordinate on each body: the coordinate and the body (p,), the force (p, 3) in
    global axes, and the torque (p, 3) in body axes."""
    bound = forces.laws.coordinates
    gradient = bound.gradient_entries(attached(pose, *slots_of(bound)))
    body = bound.body[bound.entry_slot]
    pairs, pair = distinct_rows(np.stack([bound.entry_row, body], axis=1))
    force, torque = np.zeros((len(pairs), 3)), np.zeros((len(pairs), 3))
    np.add.at(force, pair, bound.is_point[bound.entry_slot, None] * gradient)
    local = (gradient[:, None, :] @ pose.rotation[body])[:, 0, :]
    np.add.at(torque, pair, cross(bound.local[bound.entry_slot], local))
    of_laws = pairs[:, 0], pairs[:, 1], force, torque
    if not forces.bushings.size:
        return of_laws
    unit = deflection(forces.bushings, pose).gradient  # (B, 2, 6, 6), rows are the wrenches of unit forces
    ends, count = forces.bushings.body, len(COORDINATES)
    turned = unit[..., 3:] @ pose.rotation[ends]
    number = forces.laws.size + count * np.arange(len(ends))[:, None, None] + np.arange(count)
    more = (
        np.broadcast_to(number, unit.shape[:3]).ravel(),
        np.repeat(ends.ravel(), count),
        unit[..., :3].reshape(-1, 3),
        turned.reshape(-1, 3),
    )
    law, body, force, torque = (np.concatenate(pair) for pair in zip(of_laws, more, strict=True))
    return law, body, force, torque


def responses(system: System, pose: Pose, laws: Integers) -> Array:
    """Return W, (e, e), along these coordinates, m or rad per s² and N or N m. With N a basis of the velocities that
    joints allow it is Jᵀ N (NᵀMN)⁻¹ Nᵀ J. Raises LinAlgError where some of these move no mass."""
    pulls = unit_pulls(system, pose, laws)
    return np.asarray(pulls @ _accelerations(system, pose, pulls.T))


def moved_bodies(system: System, pose: Pose, laws: Integers, mode: Mode) -> Array | None:
    """Return the kinetic energy of each carrier in a mode, (n,), in an arbitrary unit; None where massless bodies can
    move. `laws` are the coordinates chosen for the mode."""
    try:
        motion = _accelerations(system, pose, unit_pulls(system, pose, laws).T @ mode.force)
    except np.linalg.LinAlgError:
        return None
    each = motion.reshape(-1, 7)
    spin = 2.0 * (pose.L[:-1] @ each[:, 3:, None])[..., 0]
    turning = np.sum(spin.conj() * (system.inertia @ spin[..., None])[..., 0], axis=-1).real
    return np.asarray(system.mass * np.sum(np.abs(each[:, :3]) ** 2, axis=-1) + turning)


def unit_pulls(system: System, pose: Pose, laws: Integers) -> Array:
    """Return the generalised forces Q (e, 7n) of unit forces along coordinates."""
    return np.array([generalised(pose, *unit_pull(system.forces, pose, int(law))) for law in laws])


def _accelerations(system: System, pose: Pose, pulls: Numbers) -> Numbers:
    """Return the accelerations q'' (7n, ...) by generalised forces (7n, ...), joints closed and at rest."""
    _, sigma, directions = np.linalg.svd(scaled_jacobian(system, pose))
    lengths = np.tile([system.length] * 3 + [1.0] * 4, system.bodies)
    free = directions[int(np.count_nonzero(sigma > THRESHOLDS.dependent)) :] * lengths
    response: Numbers = free.T @ np.linalg.solve(free @ mass_matrix(system, pose) @ free.T, free @ pulls)
    return response


def leading(names: Sequence[str], parts: Array) -> tuple[str, ...]:
    """Return the names with the largest parts, the largest first; parts of one name add up."""
    total: dict[str, float] = {}
    for name, part in zip(names, parts.tolist(), strict=True):
        total[name] = total.get(name, 0.0) + part
    most = max(total.values())
    return tuple(
        name for name in sorted(total, key=lambda name: -total[name]) if total[name] >= THRESHOLDS.named * most
    )


def fast_modes(W: Array, laws: Integers, slopes: ForceSlopes, f_x: Array) -> list[Mode]:
    """Return the modes, the fastest first, one of each conjugate pair. Modes that grow by more than `growing` of their
    |λ| are left out. `f_x` (K, K): the matrix of the states of elements."""
    count, (k, c) = len(laws), slopes.matrices(laws)
    matrix = np.zeros((2 * count + len(f_x),) * 2)
    matrix[:count, count : 2 * count] = np.eye(count)
    matrix[count : 2 * count, :count], matrix[count : 2 * count, count : 2 * count] = -W @ k, -W @ c
    matrix[2 * count :, 2 * count :] = f_x
    if not len(matrix) or not np.all(np.isfinite(matrix)):
        return []
    values, vectors = np.linalg.eig(matrix)
    size = np.abs(values)
    speed = np.where((values.real <= THRESHOLDS.hardly_damped * size) & (values.imag >= 0.0), size, 0.0)
    order = np.argsort(-speed, kind="stable")
    part = _participation(vectors)[2 * count :]
    return [_mode(values[at], vectors[:, at], part[:, at], laws, slopes) for at in order[speed[order] > 0.0]]


def _participation(vectors: Numbers) -> Array:
    """Return the participation of each number in each mode, a column: its eigenvector times the left eigenvector."""
    factors = np.abs(vectors * np.linalg.pinv(vectors).T)
    return np.asarray(factors / factors.sum(axis=0))


def _mode(value: complex, vector: Numbers, part: Array, laws: Integers, slopes: ForceSlopes) -> Mode:
    """Return the mode of an eigenvector (2e + K,): displacements and rates along the chosen coordinates, and states,
    with participations `part` (K,)."""
    count, (k, c) = len(laws), slopes.matrices(laws)
    moved, rate = vector[:count], vector[count : 2 * count]
    energy = np.abs(moved * (k @ moved)) + np.abs(rate * (c @ rate)) / abs(value)
    shares = np.zeros(len(slopes.stiffness) + len(part))
    if part.sum() > 0.5:
        shares[len(slopes.stiffness) :] = part / part.sum()
    else:
        shares[laws] = energy / max(float(energy.sum()), np.finfo(float).tiny)
    return Mode(complex(value), shares, -(k @ moved + c @ rate))
