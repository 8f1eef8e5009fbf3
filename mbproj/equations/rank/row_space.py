"""Linear dependence of rows: which rows depend on which, and the distance of the others from dependence.

`dependences` decides for everything that asks. It does not depend on axes: a rotation of the mechanism, or of a joint's
own frame, mixes the rows of one joint in m, and those in rad, by orthogonal matrices. So these rows have one scale, the
rank is that of singular values, and rows are taken joint by joint: a joint gives the combinations of its rows that the
joints before it do not imply. A walk row by row in global axes would take the wrong row where a plane leans: one whose
distance from the rows before it is the lean.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache

import numpy as np

from mbproj.base.arrays import Array, Flags, Integers, cross
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State, scaled_residual, scaled_rows
from mbproj.equations.assembly.gauss_newton import moved
from mbproj.equations.constraints import EPSILON, gamma, jacobian, set_velocity, time_derivative
from mbproj.equations.kinematics import Pose, Twist, attached, body_rates, pose_of, slots_of, twist_of
from mbproj.equations.motions import NO_DRIVE, Drive, drive_at
from mbproj.equations.rank.components import Component, component_rows, loops_of
from mbproj.model.channels import NO_MOTIONS
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import Conditions, System

# --- Redundant or nearly singular -------------------------------------------------------------------------------------
# Tells a redundancy that a mechanism has along its motion from a pose that is nearly singular.
# Rows that depend on each other along the whole motion do so exactly only where the mechanism's numbers are exact.
# With numbers of ten digits their distance from dependence is some 1e-10, with an axis that is tilted by 1e-8 rad
# some 1e-8. A pose near a singular one has such distances too. The motion tells them apart: leave the combinations in
# doubt out, and move. Those of a redundancy stay closed, and near to dependence. Those of a nearly singular pose
# leave it.
# Runs in the kernel ask the same where there are rows in doubt (`mbproj.motion.formulations.redundant_rows`).


#: The number of random directions that are tried, and their seed.
TRIALS, SEED = 3, 0
NO_CONDITIONS = Conditions(np.zeros(0, dtype=np.intp), np.zeros(0))


def floor_at(system: System, pose: Pose) -> float:
    """Return the largest distance from dependence at which rows count as dependent at a closed pose: `dependent`, or
    `in_doubt` where rows beyond round-off, up to it, depend on the others along the motion."""
    loops = loops_of(system)
    if not loops or system.bodies > THRESHOLDS.large:
        return THRESHOLDS.dependent
    return _floor(system, np.concatenate([pose.position, pose.orientation], axis=-1)[:-1].tobytes())


@lru_cache(maxsize=16)
def _floor(system: System, coordinates: bytes) -> float:
    """Return the result of `floor_at` at a pose q; one pose is asked for by many."""
    free, q, rng = replace(system, motions=NO_MOTIONS), np.frombuffer(coordinates), np.random.default_rng(SEED)
    small = _small_distances(free, q)
    if not len(small):
        return THRESHOLDS.dependent
    is_in_doubt = bool(small.max() > THRESHOLDS.rounding)
    for _ in range(TRIALS):
        there, left = _moved_on(free, q, rng)
        then = _small_distances(free, there)
        is_in_doubt = is_in_doubt or bool(then.max(initial=0.0) > THRESHOLDS.rounding)
        lasts = len(then) >= len(small) and np.abs(left).max(initial=0.0) <= THRESHOLDS.dependent
        if not (lasts and is_in_doubt):
            return THRESHOLDS.dependent
    return THRESHOLDS.in_doubt


def _small_distances(system: System, q: Array) -> Array:
    """Return the singular values of the joints' rows that may be those of dependent ones."""
    rows = component_rows(system, pose_of(q), loops_of(system))
    values = [np.linalg.svd(each, compute_uv=False) for each in rows if len(each)]
    return np.concatenate([each[each <= THRESHOLDS.in_doubt] for each in values] or [np.zeros(0)])


def _moved_on(system: System, q: Array, rng: np.random.Generator) -> tuple[Array, Array]:
    """Return the pose some way along a random direction, and what is open there, while rows in doubt are not held."""
    _, values, V = np.linalg.svd(scaled_rows(system, pose_of(q), NO_CONDITIONS).dense())
    free = V[int(np.count_nonzero(values > THRESHOLDS.in_doubt)) :]
    way: Array = np.asarray((free @ rng.normal(size=V.shape[1])) @ free, dtype=float)
    size = float(np.abs(way).max(initial=0.0))
    if size < THRESHOLDS.no_motion:
        return q, np.zeros(0)  # no motion is possible
    return closed(system.at_positions, moved(system, q, way * (THRESHOLDS.long_way / size)))


def closed(system: System, q: Array) -> tuple[Array, Array]:
    """Return the closed pose next to q (7n,), and the violation left there, in rad and parts of the length. The system
    has rows at position level alone, and no motions.

    Combinations of rows in doubt do not count for the steps: divided by their distance, the last digits of a violation
    would move the mechanism."""
    left = scaled_residual(system, pose_of(q), NO_CONDITIONS, NO_DRIVE)
    for _ in range(THRESHOLDS.most_passes):
        if not np.abs(left).max(initial=0.0) > THRESHOLDS.no_digits:
            break
        R = scaled_rows(system, pose_of(q), NO_CONDITIONS).dense()
        step = np.asarray(np.linalg.lstsq(R, -left, rcond=THRESHOLDS.in_doubt)[0], dtype=float)
        trial = moved(system, q, step)
        trial_left = scaled_residual(system, pose_of(trial), NO_CONDITIONS, NO_DRIVE)
        if not np.linalg.norm(trial_left) < np.linalg.norm(left):
            break
        q, left = trial, trial_left
    return q, left


# --- Linear dependence of rows ----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Dependence:
    """The rows of a component at a pose, (k, 6b), in one scale for each joint and unit.

    `basis` are the places in the component of as many rows as the rank, and `dependent` those of the others. `held`
    (r, 6b) are independent combinations of the rows, joint by joint, and `owners` (r,) their joints and motions as
    `system.rows` counts them. `scale` (k,) are the factors that scaled the rows. `floor` is the largest distance that
    counts as dependent."""

    component: Component
    rows: Array
    scale: Array
    basis: Integers
    dependent: Integers
    held: Array
    owners: Integers
    floor: float

    @property
    def unscaled(self) -> Array:
        """The rows in units of the length or rad, as `component_rows` gives them."""
        return self.rows / np.where(self.scale > 0.0, self.scale, 1.0)[:, None]


def dependences(system: System, pose: Pose) -> list[Dependence]:
    """Return the dependence in each component of at most `large` bodies."""
    components = [component for component in loops_of(system) if len(component.bodies) <= THRESHOLDS.large]
    if not components:
        return []
    floor = floor_at(system, pose)
    return [
        _dependence(system, component, rows, floor)
        for component, rows in zip(components, component_rows(system, pose, components), strict=True)
    ]


def independent(system: System, pose: Pose) -> Flags:
    """Return which rows of C are independent of the others, (m,): norm rows, and the basis of each component of at most
    `large` bodies. Rows of larger ones count as independent."""
    free = np.ones(system.constraints, dtype=bool)
    for part in dependences(system, pose):
        free[system.bodies + part.component.rows[part.dependent]] = False
    return free


def dependence_at(system: System, known: Dependence, pose: Pose) -> Dependence:
    """Return the dependence in a component at another pose, with the rows of the `known` basis before all others."""
    (rows,) = component_rows(system, pose, [known.component])
    return _dependence(system, known.component, rows, known.floor, known.basis)


def _dependence(
    system: System, component: Component, rows: Array, floor: float, first: Integers | None = None
) -> Dependence:
    bound, of = system.rows, component.rows
    level = system.is_velocity[system.bodies :][of]
    blocks = _blocks(bound.owner[of], bound.is_length[of])
    scale = np.zeros(len(of))
    for block in blocks:
        size = float(np.linalg.norm(rows[block])) / np.sqrt(len(block))
        scale[block] = 1.0 / size if size > THRESHOLDS.dependent else 0.0
    scaled = rows * scale[:, None]
    owners = bound.owner[of]
    rank = int(np.count_nonzero(np.linalg.svd(scaled, compute_uv=False) > floor))
    every = np.arange(len(of))
    if rank == len(of):
        return Dependence(component, scaled, scale, every, every[:0], scaled, owners, floor)
    # Rows at velocity level come last: a dependent row at position level then depends on rows at position level alone,
    # so that leaving it out opens no joint.
    joints = _blocks(level, owners)
    if first is not None:
        joints = [first, *(rest for joint in joints if len(rest := np.setdiff1d(joint, first)))]
    parts = _taken(scaled, joints, rank)
    basis = np.sort(
        np.concatenate([every[:0], *(joint[chosen] for joint, (chosen, _) in zip(joints, parts, strict=True))])
    )
    held = np.concatenate([scaled[:0], *(combinations for _, combinations in parts)])
    counts = [len(chosen) for chosen, _ in parts]
    of_held = np.repeat([owners[joint[0]] for joint in joints], counts)
    return Dependence(component, scaled, scale, basis, np.setdiff1d(every, basis), held, of_held, floor)


def _blocks(*keys: Integers | Flags) -> list[Integers]:
    """Return the places of equal keys (k,), in the order of the keys; the first key counts most."""
    table = np.stack([np.asarray(key, dtype=np.intp) for key in keys], axis=1)
    _, number = np.unique(table, axis=0, return_inverse=True)
    number = number.ravel()
    return [np.flatnonzero(number == each) for each in range(int(number.max(initial=-1)) + 1)]


def _taken(rows: Array, joints: list[Integers], rank: int) -> list[tuple[Integers, Array]]:
    """Return for each joint the rows, by their places in it, and the combinations that it adds to the span of the
    joints before it; `rank` of them in all.

    What is clearly independent comes first. A mechanism near a singular pose has too few of these, and a smaller
    distance then counts."""
    least = THRESHOLDS.rounded
    while True:
        parts = _added(rows, joints, least)
        count = sum(len(chosen) for chosen, _ in parts)
        if count >= rank or least < EPSILON:
            return parts
        least *= 0.1


def _added(rows: Array, joints: list[Integers], least: float) -> list[tuple[Integers, Array]]:
    """Return what `_taken` does, with the combinations at a distance of more than `least` from the joints before."""
    span = np.zeros((min(rows.shape), rows.shape[1]))
    size, parts = 0, []
    for joint in joints:
        rest = rows[joint]
        for _ in range(2):  # two passes are enough (Kahan)
            rest = rest - (rest @ span[:size].T) @ span[:size]
        U, values, V = np.linalg.svd(rest, full_matrices=False)
        count = min(int(np.count_nonzero(values > least)), len(span) - size)
        span[size : size + count] = V[:count]
        size += count
        parts.append((_farthest(rest, count), U[:, :count].T @ rows[joint]))
    return parts


def _farthest(rest: Array, count: int) -> Integers:
    """Return the numbers of `count` rows, each the farthest from the span of those before it; of equals the first."""
    taken = np.zeros(len(rest), dtype=bool)
    for _ in range(count):
        distance = np.where(taken, -1.0, np.linalg.norm(rest, axis=1))
        row = int(np.argmax(distance >= THRESHOLDS.tied * distance.max()))
        taken[row] = True
        unit = rest[row] / distance[row]
        for _ in range(2):
            rest = rest - np.outer(rest @ unit, unit)
    return np.flatnonzero(taken)


def scaled_jacobian(system: System, pose: Pose) -> Array:
    """Return C_q with lengths in units of the system's length and each row of unit length, (m, 7n)."""
    C_q = jacobian(system, pose).reshape(system.constraints, -1, 7)
    C_q[..., :3] *= system.length
    return unit_rows(C_q.reshape(system.constraints, -1) / system.row_scale[:, None])


def unit_rows(rows: Array) -> Array:
    """Return the rows, which are of the order of 1, scaled to unit length; rows of zero length become 0."""
    length = np.linalg.norm(rows, axis=1, keepdims=True)
    return np.asarray(
        np.where(length > THRESHOLDS.dependent, rows / np.maximum(length, THRESHOLDS.dependent), 0.0), dtype=float
    )


def row_distances(rows: Array) -> Array:
    """Return the distance of each row from the span of the rows before it, (m,): the diagonal of R in QR of the
    transpose.

    A row beyond the number of columns has the distance 0.
    """
    count, columns = rows.shape
    distances = np.zeros(count)
    R = np.linalg.qr(rows.T, mode="r")
    distances[: min(count, columns)] = np.abs(np.diag(R))
    if np.all(distances[: min(count, columns)] > THRESHOLDS.dependent):
        return distances
    return _distances_by_elimination(rows)


def _distances_by_elimination(rows: Array) -> Array:
    """Return the distances where rows are dependent. The diagonal of R would spread the defect over independent rows,
    too."""
    basis, size = np.zeros((min(rows.shape), rows.shape[1])), 0
    distances = np.zeros(len(rows))
    for index, row in enumerate(rows):
        rest = row
        for _ in range(2):  # two passes are enough (Kahan)
            rest = rest - (basis[:size] @ rest) @ basis[:size]
        distances[index] = np.linalg.norm(rest)
        if distances[index] > THRESHOLDS.dependent:
            basis[size] = rest / distances[index]
            size += 1
    return distances


def shares(rows: Array, basis: Integers, dependent: Integers) -> Array:
    """Return the coefficients (d, b) of the `dependent` rows in the independent rows `basis`; round-off is set to 0.

    A dependent row and the rows with a nonzero coefficient are a circuit: leave one out, and the others are
    independent.
    """
    if not len(dependent):
        return np.zeros((0, len(basis)))
    U, σ, V = np.linalg.svd(rows[basis].T, full_matrices=False)
    coefficients = (V.T / σ @ (U.T @ rows[dependent].T)).T
    largest = np.maximum(np.abs(coefficients).max(axis=1, initial=0.0, keepdims=True), 1.0)
    grain = THRESHOLDS.round_off_grains * EPSILON / σ.min(initial=1.0)
    return np.asarray(np.where(np.abs(coefficients) > grain * largest, coefficients, 0.0), dtype=float)


def self_stresses(system: System, pose: Pose) -> Array:
    """Return a basis of the multipliers λ (d, k) of joints and motions without a force on any body, Gᵀλ = 0. The basis
    has one vector for each redundant row, with torques of the order of 1 and forces of the order of 1 / length."""
    scale = system.row_scale[system.bodies :]
    stresses = [np.zeros((0, len(scale)))]
    for dependence in dependences(system, pose):
        dependent, basis = dependence.dependent, dependence.basis
        part = np.zeros((len(dependent), len(dependence.rows)))
        part[np.arange(len(dependent)), dependent] = 1.0
        part[:, basis] = -shares(dependence.rows, basis, dependent)
        stress = np.zeros((len(dependent), len(scale)))
        weight = np.where(dependence.scale > 0.0, dependence.scale, 1.0)
        stress[:, dependence.component.rows] = part * weight / np.abs(part).max(axis=1, initial=1.0, keepdims=True)
        stresses.append(stress / scale)
    return np.concatenate(stresses)


# --- Words for a row of C ---------------------------------------------------------------------------------------------
# Its owner, and the direction along or about which it acts on body 2.


@dataclass(frozen=True)
class NamedRow:
    """A row of a joint or of a motion: its owner's name, and the direction it holds, as "along x" or "about [0.6, 0,
    0.8]"."""

    kind: str
    name: str
    holds: str


def name_rows(system: System, pose: Pose) -> list[NamedRow]:
    """Return a name for every row of C but the norm rows, in their order; directions are global, at this pose."""
    joints = [
        NamedRow("joint", system.names.joints[owner], holds)
        for owner, holds in zip(system.joints.owner, _directions(system.joints, pose), strict=True)
    ]
    return [*joints, *(NamedRow("motion", name, "") for name in system.names.motions)]


def rows_in_words(rows: Iterable[NamedRow], most: int | None = None) -> str:
    """Return rows in words, gathered by owner: "joint 'A' (along y, about x), motion 'm'"; at most `most` owners."""
    gathered: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        gathered.setdefault((row.kind, row.name), []).append(row.holds)
    parts = [
        f"{kind} '{name}'" + (f" ({', '.join(held)})" if any(held) else "") for (kind, name), held in gathered.items()
    ]
    left = 0 if most is None else len(parts) - most
    return ", ".join(parts) if left <= 0 else ", ".join([*parts[:most], f"and {left} more"])


def direction(vector: Array) -> str:
    """Return a direction in words: x, y or z where it is one of these, else its components, regardless of sign."""
    unit = vector / np.linalg.norm(vector)
    for axis, name in enumerate("xyz"):
        if abs(unit[axis]) > 1.0 - THRESHOLDS.same_written:
            return name
    unit = unit * np.sign(unit[np.flatnonzero(np.abs(unit) > THRESHOLDS.rounded)[0]])
    return "[" + ", ".join(f"{round(part, 3) + 0.0:g}" for part in unit.tolist()) + "]"


def _directions(bound: PrimitiveSet, pose: Pose) -> list[str]:
    """Return, for each row, the direction along which body 2 would shift, or about which it would turn, to change
    it."""
    x = attached(pose, *slots_of(bound))
    gradient = bound.gradient_entries(x)
    on_body_2 = (bound.side[bound.entry_slot] == 2)[:, None]
    is_point = bound.is_point[bound.entry_slot, None]
    shift, turn = np.zeros((bound.size, 3)), np.zeros((bound.size, 3))
    np.add.at(shift, bound.entry_row, on_body_2 * is_point * gradient)
    np.add.at(turn, bound.entry_row, on_body_2 * (1.0 - is_point) * cross(x[bound.entry_slot], gradient))
    return [_direction_words(along, about) for along, about in zip(shift, turn, strict=True)]


def _direction_words(along: Array, about: Array) -> str:
    shifts, turns = (np.linalg.norm(vector) > THRESHOLDS.dependent for vector in (along, about))
    if shifts and turns:
        return f"along and about {direction(along)}"
    return f"along {direction(along)}" if shifts else f"about {direction(about)}" if turns else ""


# --- Right-hand sides, and contradictions -----------------------------------------------------------------------------
# Right-hand sides of the rows of C for velocities and accelerations, and contradictions between dependent rows.


TINY = float(np.finfo(float).tiny)


@dataclass(frozen=True, eq=False)
class RightHandSides:
    """-C_t and γ of Eqs. 5 and 7 for all rows but the norm rows, (k,) each, in units of the length or rad.

    `quadratic` is γ without -C_tt: it is quadratic in the bodies' velocities `moving`, (r' / length, ω), (n, 6).
    `speed` is the expected size of velocities, per s. `doubt` is the relative error of the velocities."""

    velocity: Array
    acceleration: Array
    quadratic: Array
    moving: Array
    speed: float
    doubt: float = 0.0

    def with_doubt(self, part: Dependence) -> RightHandSides:
        """Return the right-hand sides with the `doubt` of a component: the part of its velocities that its rows do not
        allow. The velocity of a component at rest is round-off, so that its doubt may be 1."""
        moving = self.moving[part.component.bodies].ravel()
        left = part.rows @ moving - self.velocity[part.component.rows] * part.scale
        wrong = np.abs(np.linalg.lstsq(part.rows, left, rcond=THRESHOLDS.dependent)[0]).max()
        return replace(self, doubt=float(wrong / max(np.abs(moving).max(), TINY)))

    def disagreement(self, rows: Integers, weights: Array, floor: float) -> tuple[float, float]:
        """Return Σ weight × right-hand side of rows with Σ weight × row = 0 in C_q, for velocity and acceleration;
        round-off counts as 0. Rows count as dependent up to the distance `floor`."""
        largest = float(np.abs(weights).max())
        quadratic = float(np.abs(weights * self.quadratic[rows]).sum()) + largest * self.speed**2
        return (
            _beyond_round_off(weights * self.velocity[rows], floor * largest * self.speed),
            _beyond_round_off(weights * self.acceleration[rows], (floor + 2.0 * self.doubt) * quadratic),
        )


def _beyond_round_off(parts: Array, round_off: float) -> float:
    """Return the size of a sum; 0 where it is round-off."""
    off = abs(float(parts.sum()))
    return off if off > round_off + THRESHOLDS.dependent * float(np.abs(parts).sum()) else 0.0


def right_hand_sides(system: System, state: State) -> RightHandSides:
    """Return the right-hand sides at a state."""
    pose, n = pose_of(state.q), system.bodies
    twist, drive = twist_of(pose, state.v), drive_at(system, state.t)
    scale = system.row_scale[n:]
    velocity = -time_derivative(system, drive)[n:] / scale
    moving = np.concatenate([twist.velocity / system.length, body_rates(pose, twist)], axis=1)[:n]
    steady = replace(drive, acceleration=np.zeros_like(drive.acceleration))
    return RightHandSides(
        velocity,
        acceleration=tangent_gamma(system, pose, twist, drive) / scale,
        quadratic=tangent_gamma(system, pose, twist, steady) / scale,
        moving=moving,
        speed=float(np.abs(np.concatenate([moving.ravel(), velocity])).max()),
    )


def tangent_gamma(system: System, pose: Pose, twist: Twist, drive: Drive) -> Array:
    """Return γ of all rows but the norm rows, (k,), for accelerations in (r'', ω'). The part of Λ'' that keeps |Λ|,
    which the norm rows require, is -|Λ'|² Λ."""
    of_norm = np.zeros((system.bodies, 7))
    of_norm[:, 3:] = -np.sum(twist.rate[:-1] ** 2, axis=1, keepdims=True) * pose.orientation[:-1]
    change = twist_of(pose, of_norm.ravel())
    right = gamma(system, pose, twist, drive)[system.bodies :] - set_velocity(system.rows, pose, change)
    return np.asarray(right, dtype=float)
