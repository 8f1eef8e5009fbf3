"""Rank of C_q and of Eq. 20: degrees of freedom, redundant joints, massless motions. None depends on units or size."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.constraints import HARDLY_ANY, has_light_bodies
from mbproj.equations.kinematics import Pose, pose_of
from mbproj.equations.of_motion import tangent_gradients
from mbproj.equations.rank.components import Component, component_rows, loops_of
from mbproj.equations.rank.row_space import direction, independent, unit_rows
from mbproj.model.system import System

# --- Motions without kinetic energy, null(M) ∩ null(C_q) --------------------------------------------------------------
# Eq. 20 rules them out; motions with hardly any energy are told in the same words.


#: The most motions that a message shows.
SHOWN = 3


@dataclass(frozen=True)
class MasslessMotion:
    """A motion without kinetic energy: the motion of each body, by name, as "turns about z"."""

    bodies: tuple[tuple[str, str], ...]

    def __str__(self) -> str:
        return ", ".join(f"'{name}' {what}" for name, what in self.bodies)


@dataclass(frozen=True, eq=False)
class LightMotion:
    """A motion (6n,) of (δr / length, δθ), of size 1, that the joints allow. `inertia`: the inertia of this motion
    divided by the largest one of a single body."""

    inertia: float
    motion: Array
    words: str

    def __str__(self) -> str:
        return self.words


def least_inertia(system: System, pose: Pose) -> LightMotion | None:
    """Return the motion that moves the least inertia; None where the joints leave no freedom."""
    bodies = np.arange(system.bodies)
    component = Component(np.arange(system.constraints - system.bodies), bodies)
    free = _null_space(unit_rows(component_rows(system, pose, [component])[0]))
    if not len(free):
        return None
    M = np.zeros((system.bodies, 6, 6))
    M[:, :3, :3], M[:, 3:, 3:] = system.mass[:, None, None] * system.length**2 * np.eye(3), system.inertia
    moved = np.einsum("nij,knj->kni", M, free.reshape(-1, system.bodies, 6)).reshape(len(free), -1) @ free.T
    rows = tangent_gradients(system.reflected, pose)[:, :-1] * ([system.length] * 3 + [1.0] * 3)
    turned = free @ rows.reshape(system.reflected.size, 6 * system.bodies).T
    moved += (turned * system.reflected.inertia) @ turned.T
    values, vectors = np.linalg.eigh(moved)
    motion = vectors[:, 0] @ free
    words = ", ".join(f"'{name}' {what}" for name, what in _motion_words(system, pose, bodies, motion.reshape(-1, 6)))
    return LightMotion(float(values[0]) / float(np.abs(M).max()), motion, words)


def massless_motions(system: System, pose: Pose) -> tuple[MasslessMotion, ...]:
    """Return a basis of null(M) ∩ null(C_q), each motion with few nonzeros; none where Eq. 20 holds.

    M enters by its null space alone, so ratios of masses do not matter.
    """
    return _motions(system, pose, _weightless(system, 0.0))


def swamped_motions(system: System, pose: Pose) -> tuple[MasslessMotion, ...]:
    """Return motions that the joints of loops leave to bodies with hardly any mass or inertia beside the others.

    Forces of heavy bodies pass through such a body, and their sum is known to ε times the ratio of masses only. In
    trees this does no harm."""
    if not has_light_bodies(system):
        return ()
    in_loops = np.zeros(system.bodies, dtype=bool)
    for loop in loops_of(system):
        in_loops[loop.bodies] = True
    weightless = _weightless(system, HARDLY_ANY) * in_loops[:, None, None]
    return _motions(system, pose, weightless, HARDLY_ANY)


def _motions(system: System, pose: Pose, weightless: Array, below: float = 0.0) -> tuple[MasslessMotion, ...]:
    """Return combinations of `weightless` directions (n, 6, 6) of each body that no row resists. A reflected inertia
    counts as a resistance where it exceeds `below` times the largest inertia of a body."""
    light = np.flatnonzero(weightless.any(axis=(1, 2)))
    if not len(light):
        return ()
    body, direction_of = np.nonzero(weightless[light].any(axis=2))
    by_body = np.zeros((len(light), 6, len(body)))
    by_body[body, :, np.arange(len(body))] = weightless[light][body, direction_of]
    columns = by_body.reshape(-1, len(body))
    component = Component(_rows_on(system, light), light)
    rows = np.concatenate([component_rows(system, pose, [component])[0], _reflected(system, pose, light, below)])
    held = unit_rows(rows @ columns)
    motions = _simple(_null_space(held), direction_of >= 3) @ columns.T
    return tuple(MasslessMotion(tuple(_motion_words(system, pose, light, motion.reshape(-1, 6)))) for motion in motions)


def massless_problem(system: System, motions: tuple[MasslessMotion, ...]) -> Problem:
    """Return the problem of a mechanism with these motions, at the first body that moves in one."""
    ((name, _), *_) = motions[0].bodies
    shown = "; ".join(str(motion) for motion in motions[:SHOWN])
    more = f"; and {len(motions) - SHOWN} more" if len(motions) > SHOWN else ""
    what = "a motion that moves" if len(motions) == 1 else f"{len(motions)} motions that move"
    return Problem(
        f"the joints leave {what} no mass (Eq. 20 does not hold): {shown}{more}",
        system.body_places[system.names.carriers.index(name)],
        "give the bodies that move mass and inertia, or joints that hold it",
    )


def _weightless(system: System, below: float) -> Array:
    """Return directions (n, 6, 6) of (δr, δθ in body axes) of each body without kinetic energy, or with at most `below`
    times the largest one. Other directions are 0."""
    projections = np.zeros((system.bodies, 6, 6))
    heaviest, widest = system.mass.max(initial=0.0), np.abs(system.inertia).max(initial=0.0)
    for body in range(system.bodies):
        projections[body, :3, :3] = np.eye(3) * float(system.mass[body] <= below * heaviest)
        moments, axes = np.linalg.eigh(system.inertia[body])
        is_light = moments <= max(np.finfo(float).eps * max(moments[-1], np.finfo(float).tiny), below * widest)
        projections[body, 3:, 3:] = axes.T * is_light[:, None]
    return projections


def _reflected(system: System, pose: Pose, bodies: Integers, below: float) -> Array:
    """Return the gradients of coordinates with a reflected inertia, in (δr / length, δθ) of these bodies, (k, 6b), in
    units of the length or rad. A motion that changes such a coordinate moves mass."""
    reflected, is_length = system.reflected, system.reflected.rows.is_length
    largest = np.where(is_length, system.mass.max(initial=0.0), np.abs(system.inertia).max(initial=0.0))
    rows = tangent_gradients(reflected, pose)[:, bodies] * ([system.length] * 3 + [1.0] * 3)
    rows /= np.where(is_length, system.length, 1.0)[:, None, None]
    counts = np.flatnonzero(reflected.inertia > below * largest)
    return rows[counts].reshape(len(counts), 6 * len(bodies))


def _rows_on(system: System, bodies: Integers) -> Integers:
    """Return the rows that hold any of these bodies."""
    bound = system.rows
    return np.unique(bound.entry_row[np.isin(bound.body[bound.entry_slot], bodies)])


def _null_space(rows: Array) -> Array:
    """Return an orthonormal basis (d, z) of the directions that no row resists."""
    if not len(rows):
        return np.eye(rows.shape[1])
    _, values, vectors = np.linalg.svd(np.linalg.qr(rows, mode="r"), full_matrices=True)
    return np.asarray(vectors[np.count_nonzero(values > THRESHOLDS.dependent) :], dtype=float)


def _simple(basis: Array, turns: npt.NDArray[np.bool_]) -> Array:
    """Return a basis of the same space with few nonzeros, by Gauss-Jordan elimination with the largest pivots, turns
    first. The motions of a body about a point are then turns about axes through it."""
    rows, weight = basis.copy(), np.where(turns, 1.0, THRESHOLDS.no_motion)
    for index in range(len(rows)):
        row, column = np.unravel_index(np.argmax(np.abs(rows[index:]) * weight), rows[index:].shape)
        rows[[index, index + row]] = rows[[index + row, index]]
        rows[index] /= rows[index, column]
        others = np.arange(len(rows)) != index
        rows[others] -= np.outer(rows[others, column], rows[index])
    return np.where(np.abs(rows) > THRESHOLDS.no_motion, rows, 0.0)


def _motion_words(system: System, pose: Pose, bodies: Integers, motion: Array) -> Iterator[tuple[str, str]]:
    """The motion of each body that moves, in words, from (δr / length, δθ) (b, 6)."""
    largest = np.abs(motion).max()
    for body, part in zip(bodies, motion, strict=True):
        shift, turn = part[:3], pose.rotation[body] @ part[3:]
        if np.abs(part).max() > THRESHOLDS.no_motion * largest:
            yield system.names.carriers[body], _motion(system.length, pose.position[body], shift, turn)


def _motion(length: float, centre: Array, shift: Array, turn: Array) -> str:
    """Return, in words, the motion of a body that turns while its centre of mass shifts by `shift`, in parts of the
    length."""
    rate = float(np.linalg.norm(turn))
    if rate <= THRESHOLDS.no_motion * np.linalg.norm(shift):
        return f"shifts along {direction(shift)}"
    to_axis = np.cross(turn, shift) / rate**2
    along = abs(turn @ shift) / rate**2
    where = "its centre of mass"
    if np.linalg.norm(to_axis) > THRESHOLDS.no_motion:
        point = centre + length * to_axis
        point[np.abs(point) < THRESHOLDS.no_motion * length] = 0.0
        where = "[" + ", ".join(f"{part:.4g}" for part in point) + "] m"
    slides = " and shifts along it" if along > THRESHOLDS.no_motion else ""
    return f"turns about {direction(turn)} through {where}{slides}"


# --- Rank of C_q and of Eq. 20: degrees of freedom, redundant joints, massless motions --------------------------------
# None depends on units or size.


@dataclass(frozen=True)
class Mobility:
    """Ranks at one pose.

    `redundant`: the number of dependent rows by joint name, each row against the joints before it. `locked`: the
    motions whose coordinates follow from the joints and the motions before them. `massless_motions`: those without
    kinetic energy; none where Eq. 20 holds. `rolling`: the part of the rank that belongs to rows at velocity level."""

    coordinates: int
    constraints: int
    rank: int
    redundant: dict[str, int]
    massless_motions: tuple[MasslessMotion, ...]
    locked: tuple[str, ...] = ()
    rolling: int = 0

    @property
    def degrees_of_freedom(self) -> int:
        """7n - rank(C_q), the degrees of freedom of velocities."""
        return self.coordinates - self.rank

    @property
    def positions(self) -> int:
        """The degrees of freedom of poses, which rows at position level alone limit; those of velocities without
        rolling."""
        return self.degrees_of_freedom + self.rolling

    @property
    def massless(self) -> tuple[str, ...]:
        """The bodies that can move without kinetic energy."""
        return tuple(dict.fromkeys(name for motion in self.massless_motions for name, _ in motion.bodies))


def mobility(system: System, at: Pose | State) -> Mobility:
    """Return the ranks of C_q and of Eq. 20 at a pose, or at that of a state. Norm rows are independent of all
    others."""
    pose = pose_of(at.q) if isinstance(at, State) else at
    free = independent(system, pose)[system.bodies :]
    dependent = np.flatnonzero(~free)
    owners = [system.names.joints[owner] for owner in system.joints.owner[dependent[dependent < system.joints.size]]]
    locked = dependent[dependent >= system.joints.size] - system.joints.size
    return Mobility(
        coordinates=7 * system.bodies,
        constraints=system.constraints,
        rank=system.constraints - len(dependent),
        redundant={name: owners.count(name) for name in dict.fromkeys(owners)},
        massless_motions=massless_motions(system, pose),
        locked=tuple(system.names.motions[row] for row in locked),
        rolling=int(np.count_nonzero(free & system.is_velocity[system.bodies :])),
    )


def unsolvable(system: System, ranks: Mobility) -> list[Problem]:
    """Return the causes for which Eq. 14 has no unique solution at this pose: redundant joints, or motions without
    mass."""
    problems = []
    for name, rows in ranks.redundant.items():
        place = system.joint_places[system.names.joints.index(name)]
        problems.append(
            Problem(
                f"joint '{name}' is redundant: {rows} of its constraints already follow from the joints before it",
                place,
                "let a joint of its loop constrain less (a planar loop closes as revolute, spherical, universal, "
                "revolute), or start from a pose that is not stretched or folded",
            )
        )
    for name in ranks.locked:
        problems.append(
            Problem(
                f"motion '{name}' locks the mechanism: the coordinate that it drives already follows from the joints "
                "and the motions before it",
                system.motions.places[system.names.motions.index(name)],
                "drive no more coordinates than there are degrees of freedom, and none at a dead centre",
            )
        )
    if ranks.massless_motions:
        problems.append(massless_problem(system, ranks.massless_motions))
    return problems


def refuse_unsolvable(system: System, ranks: Mobility) -> None:
    """Raise InputError with the problems of `unsolvable`."""
    problems = unsolvable(system, ranks)
    if problems:
        raise InputError(problems)
