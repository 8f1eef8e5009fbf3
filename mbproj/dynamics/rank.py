"""Rank of C_q and of Eq. 20: degrees of freedom, redundant joints, massless motions. None depends on units or size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.constraint_equations import jacobian
from mbproj.dynamics.kinematics import Pose
from mbproj.errors import InputError, Problem
from mbproj.model.system import System

#: A row of C_q whose distance from the span of the others is below this part of its length is taken as dependent.
DEPENDENT = 1e-9
#: Below this a running simulation stops: what is computed there has lost all but a few digits.
SINGULAR = 1e-11


@dataclass(frozen=True)
class Mobility:
    """Ranks at one pose. `redundant` counts dependent rows by joint name, each against the joints before it; `locked`
    names the motions whose coordinates follow from the joints and the motions before them; `massless` names the bodies
    that can move without kinetic energy (Eq. 20 fails) and is empty where Eq. 20 holds."""

    coordinates: int
    constraints: int
    rank: int
    redundant: dict[str, int]
    massless: tuple[str, ...]
    locked: tuple[str, ...] = ()

    @property
    def degrees_of_freedom(self) -> int:
        """7n - rank(C_q)."""
        return self.coordinates - self.rank


def full_rank(system: System) -> Mobility:
    """The ranks of a system whose rows are known to be independent."""
    return Mobility(7 * system.bodies, system.constraints, system.constraints, {}, ())


def mobility(system: System, pose: Pose) -> Mobility:
    """The ranks of C_q and of Eq. 20 at this pose."""
    C_q = scaled_jacobian(system, pose)
    distances = row_distances(C_q)
    dependent = np.flatnonzero(distances[system.bodies :] < DEPENDENT)
    owners = [system.names.joints[owner] for owner in system.joints.owner[dependent[dependent < system.joints.size]]]
    locked = dependent[dependent >= system.joints.size] - system.joints.size
    return Mobility(
        coordinates=C_q.shape[1],
        constraints=C_q.shape[0],
        rank=int(np.linalg.matrix_rank(C_q, tol=DEPENDENT)),
        redundant={name: owners.count(name) for name in dict.fromkeys(owners)},
        massless=_massless(system, pose, C_q),
        locked=tuple(system.names.motions[row] for row in locked),
    )


def unsolvable(system: System, ranks: Mobility) -> list[Problem]:
    """Why Eq. 14 has no unique solution at this pose: nothing, or redundant joints, or motions without mass."""
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
        assert system.motions is not None
        problems.append(
            Problem(
                f"motion '{name}' locks the mechanism: what it drives already follows from the joints and the motions "
                "before it",
                system.motions.places[system.names.motions.index(name)],
                "drive no more coordinates than there are degrees of freedom, and none at a dead centre",
            )
        )
    if ranks.massless:
        names = ", ".join(f"'{name}'" for name in ranks.massless)
        problems.append(
            Problem(
                f"the joints leave a motion that moves no mass (Eq. 20 does not hold), with bodies {names}",
                hint="give these bodies mass and inertia, or joints that hold them",
            )
        )
    return problems


def refuse_unsolvable(system: System, ranks: Mobility) -> None:
    """Raises InputError with what `unsolvable` finds."""
    problems = unsolvable(system, ranks)
    if problems:
        raise InputError(problems)


def scaled_jacobian(system: System, pose: Pose) -> Array:
    """C_q with lengths in units of the system's length and each row of unit length, (m, 7n)."""
    C_q = jacobian(system, pose).reshape(system.constraints, -1, 7)
    C_q[..., :3] *= system.length
    flat = C_q.reshape(system.constraints, -1)
    return flat / np.linalg.norm(flat, axis=1, keepdims=True)


def row_distances(rows: Array) -> Array:
    """The distance of each row from the span of the rows before it, (m,): the diagonal of R in QR of the transpose.

    A row beyond the number of columns has no distance left and gets 0.
    """
    count, columns = rows.shape
    distances = np.zeros(count)
    R = np.linalg.qr(rows.T, mode="r")
    distances[: min(count, columns)] = np.abs(np.diag(R))
    if np.all(distances[: min(count, columns)] > DEPENDENT):
        return distances
    return _distances_by_elimination(rows)


def _distances_by_elimination(rows: Array) -> Array:
    """The same where rows are dependent: R's diagonal would then pass the defect on to rows that are independent."""
    basis: list[Array] = []
    distances = np.zeros(len(rows))
    for index, row in enumerate(rows):
        rest = row
        for _ in range(2):  # twice is enough (Kahan)
            rest = rest - sum(((rest @ vector) * vector for vector in basis), np.zeros_like(row))
        distances[index] = np.linalg.norm(rest)
        if distances[index] > DEPENDENT:
            basis.append(rest / distances[index])
    return distances


def _massless(system: System, pose: Pose, C_q: Array) -> tuple[str, ...]:
    """Bodies that move in the null space of [M; C_q] (Eq. 20); M enters by its range, so mass ratios do not matter."""
    n = system.bodies
    with_mass = np.zeros((n, 6, n, 7))
    for body in range(n):
        with_mass[body, :3, body, :3] = np.eye(3) * float(system.mass[body] > 0.0)
        moments, axes = np.linalg.eigh(system.inertia[body])
        heavy = moments > np.finfo(float).eps * max(moments[-1], np.finfo(float).tiny)
        with_mass[body, 3:, body, 3:] = (axes * heavy).T @ pose.L[body]
    stacked = np.concatenate([with_mass.reshape(6 * n, 7 * n), C_q])
    _, values, vectors = np.linalg.svd(stacked, full_matrices=True)
    free = vectors[np.count_nonzero(values > DEPENDENT) :]
    moving = np.linalg.norm(free.reshape(-1, n, 7), axis=(0, 2)) > 1e-6
    return tuple(name for name, moves in zip(system.names.carriers, moving, strict=True) if moves)
