"""Redundant rows of C_q: the smallest sets of rows of joints and motions that depend on each other. They may do so
along the whole motion or at one pose only, and with a contradiction or without.

A set is a circuit: leave one row out, and the others are independent. The basis is the earliest rows that are
independent at the start, and further rows that are independent at poses nearby. A row outside the basis depends on it
permanently. A further row depends on the earliest rows, at the start only. So a set is permanent as a whole, or not at
all.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import Place, Problem, shortened
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.constraints import jacobian
from mbproj.equations.kinematics import Pose, pose_of
from mbproj.equations.rank.components import Component, component_rows, loops_of
from mbproj.equations.rank.nearby import Nearby, nearby
from mbproj.equations.rank.row_space import (
    Dependence,
    NamedRow,
    RightHandSides,
    dependence_at,
    dependences,
    independent,
    name_rows,
    right_hand_sides,
    rows_in_words,
    scaled_jacobian,
    shares,
    unit_rows,
)
from mbproj.model.channels import NO_MOTIONS
from mbproj.model.system import System


@dataclass(frozen=True, eq=False)
class DependentSet:
    """Rows of C that depend on each other, in the `unit` m or rad.

    `rows` are counted without the norm rows; the one that depends on the others comes first. `held` describes each.
    `weights` are their coefficients in Σ weight · row = 0 of C_q at the start, 1 for the first.

    `permanent`: whether they depend on each other along the motion, or only at this pose; None where the permanence was
    not examined. `residual`: the contradictions of the velocities and the accelerations that they require at the start,
    in the unit per s and per s²; 0 where these are round-off."""

    rows: tuple[int, ...]
    unit: str
    held: tuple[NamedRow, ...]
    weights: Array
    permanent: bool | None
    residual: tuple[float, float]

    @property
    def contradictory(self) -> bool:
        """Whether no velocities or no accelerations meet all of the rows at the start."""
        return any(self.residual)

    @property
    def motions(self) -> tuple[str, ...]:
        """The motions among the rows: their coordinates follow from the joints and each other."""
        return tuple(row.name for row in self.held if row.kind == "motion")


@dataclass(frozen=True, eq=False)
class Redundancy:
    """The dependent sets of a mechanism, one for each redundant row.

    `freedom`: the number of directions that the joints leave at the start, to first order. `moves`: whether one of them
    leads to another pose. Both are None where no row is redundant, or the mechanism is too large for the search.
    `left_out`: the number of bodies of the largest component that is too large to be examined, 0 without one."""

    sets: tuple[DependentSet, ...]
    freedom: int | None = None
    moves: bool | None = None
    left_out: int = 0

    @property
    def is_constant(self) -> bool:
        """Whether all sets are of joints alone, permanent and without contradiction: rows can then be dropped without
        any effect on the motion."""
        return not self.left_out and all(
            entry.permanent and not entry.contradictory and not entry.motions for entry in self.sets
        )


def redundancy(system: System, state: State) -> Redundancy:
    """Return the redundant rows at a closed state. Components of more than `large` bodies are left out."""
    pose = pose_of(state.q)
    left_out = max(
        (bodies for component in loops_of(system) if (bodies := len(component.bodies)) > THRESHOLDS.large), default=0
    )
    dependent = [part for part in dependences(system, pose) if len(part.dependent)]
    if not dependent:
        return Redundancy((), left_out=left_out)
    around = nearby(system, state.q) if system.bodies <= THRESHOLDS.large else None
    sides, names = right_hand_sides(system, state), name_rows(system, pose)
    sets = [
        _dependent_set(system, part, members, permanent, known, names)
        for part, known in [(part, sides.with_doubt(part)) for part in dependent]
        for members, permanent in _circuits(system, part, around)
    ]
    return Redundancy(
        tuple(sorted(sets, key=lambda entry: entry.rows[0])),
        None if around is None else around.freedom,
        None if around is None else bool(around.poses),
        left_out,
    )


def _circuits(system: System, part: Dependence, around: Nearby | None) -> Iterator[tuple[list[int], bool | None]]:
    """The dependent sets of a component as lists of rows, the dependent one first, and whether each is permanent."""
    here = part.rows
    if around is None or not around.freedom:
        stays = None if around is None else True
        yield from ((members, stays) for members in _members(here, part.basis, part.dependent))
        return
    lasting = part.dependent if around.poses else part.dependent[:0]
    basis, rows = part.basis, here
    for pose in around.poses:
        there = dependence_at(system, part, pose)
        if len(there.dependent) <= len(lasting):
            basis, lasting, rows = there.basis, there.dependent, there.rows
    passing = np.setdiff1d(part.dependent, lasting)
    yield from ((members, True) for members in _members(rows, basis, lasting))
    yield from ((members, False) for members in _members(here, part.basis, passing))


def _members(rows: Array, basis: Integers, dependent: Integers) -> Iterator[list[int]]:
    for row, share in zip(dependent, shares(rows, basis, dependent), strict=True):
        yield [int(row), *np.sort(basis[share != 0.0]).tolist()]


def _dependent_set(
    system: System,
    part: Dependence,
    members: list[int],
    permanent: bool | None,
    sides: RightHandSides,
    names: list[NamedRow],
) -> DependentSet:
    first, others = part.unscaled[members[0]], part.unscaled[members[1:]]
    share = np.linalg.lstsq(unit_rows(others).T, first, rcond=None)[0] / np.linalg.norm(others, axis=1)
    weights = np.concatenate([[1.0], -share])
    rows = part.component.rows[members]
    drives = any(names[row].kind == "motion" for row in rows)
    velocity, acceleration = sides.disagreement(rows, weights, THRESHOLDS.dependent if drives else part.floor)
    scale = system.row_scale[system.bodies :][rows]
    return DependentSet(
        rows=tuple(rows.tolist()),
        unit=system.rows.units[int(rows[0])],
        held=tuple(names[row] for row in rows),
        weights=weights * scale[0] / scale,
        permanent=permanent,
        residual=(velocity * float(scale[0]), acceleration * float(scale[0])),
    )


# --- The distance of C_q from losing rank -----------------------------------------------------------------------------
# Condition numbers as written and scaled, and the joint that loses rows first.


@dataclass(frozen=True)
class Conditioning:
    """Condition numbers of C_q without redundant rows: `as_written`, in SI units, and `scaled`, with lengths in units
    of the system's length and rows of unit length; None for more than `large` bodies.

    `distance`: the smallest singular value of a loop's rows in (δr / length, δθ), those of a joint in one scale and
    without what follows from the joints before: the smallest change of the rows that makes them dependent (Eckart and
    Young 1936). It does not depend on axes. None without a loop, as the rows of a tree are independent at every pose.
    `owner`: the owner, as "joint 'A'", of the rows that this smallest change concerns most."""

    as_written: float | None
    scaled: float | None
    distance: float | None
    owner: str | None

    @property
    def words(self) -> str:
        """The distance of the pose from a singular one, in words."""
        if self.distance is None:
            return "no loops, and so no singular poses"
        if self.distance < THRESHOLDS.rounded:
            return "all but singular"
        return "near a singular pose" if self.distance < THRESHOLDS.passing else "far from singular poses"


def conditioning(system: System, pose: Pose) -> Conditioning:
    """Return the conditioning at a pose. Components of more than `large` bodies do not count for the distance."""
    distance, owner = None, None
    for part in dependences(system, pose):
        if not _has_joints(system, part.component):
            continue
        left, values, _ = np.linalg.svd(part.held, full_matrices=False)
        if distance is None or values[-1] < distance * (1.0 - THRESHOLDS.dependent):
            distance, owner = float(values[-1]), _largest_owner(system, part, left[:, -1])
    if system.bodies > THRESHOLDS.large:
        return Conditioning(None, None, distance, owner)
    rows = independent(system, pose)
    return Conditioning(
        _condition(jacobian(system, pose)[rows]),
        _condition(scaled_jacobian(system, pose)[rows]),
        distance,
        owner,
    )


def _has_joints(system: System, component: Component) -> bool:
    """Whether the component has several joints; a motion counts for the joint that it drives."""
    driven = system.coordinates.owner[system.motions.joint_coordinate]
    joints = np.concatenate([system.joints.owner, driven])[component.rows]
    return bool(np.any(joints != joints[0]))


def _condition(rows: Array) -> float:
    """Return the condition number of independent rows (m, 7n). For many rows it is the root of the condition number of
    C_q C_qᵀ, whose eigenvalues come from Lanczos' method."""
    if len(rows) <= 7 * THRESHOLDS.large:
        values = np.linalg.svd(rows, compute_uv=False)
        return float(values[0] / values[-1])
    from scipy.sparse import csc_matrix
    from scipy.sparse.linalg import eigsh

    sparse = csc_matrix(rows)
    products, first = (sparse @ sparse.T).tocsc(), np.ones(len(rows))
    (largest,) = eigsh(products, 1, v0=first, return_eigenvectors=False)
    (smallest,) = eigsh(products, 1, sigma=0.0, v0=first, return_eigenvectors=False)
    return float(np.sqrt(largest / abs(smallest)))


def _largest_owner(system: System, part: Dependence, share: Array) -> str:
    """Return the joint or motion with the largest part of a vector over the combinations held."""
    sizes = np.bincount(part.owners, share**2)
    owner = int(np.argmax(sizes > sizes.max() * (1.0 - THRESHOLDS.rounded)))
    row = part.component.rows[np.argmax(system.rows.owner[part.component.rows] == owner)]
    return system.row_owner(int(row) + system.bodies)


# --- Problems that the rows of a mechanism cause in a run, with their places ------------------------------------------
# Dependent rows, wheels that jam.


#: The most dependent sets, and joints of each, that a message names.
MOST_SETS, MOST_JOINTS = 3, 6


def problems_of(system: System, redundancy: Redundancy, *, runs: bool) -> list[Problem]:
    """Return the problems of dependent sets, for which a mechanism cannot run. Where its equations can be solved
    (`runs`), only sets whose rows contradict each other are problems.

    Rows of joints that depend on each other along the whole motion, without contradiction, are no problem. A set that
    was not examined counts as such.
    """
    sets = [entry for entry in redundancy.sets if entry.contradictory or not runs]
    joints = [entry for entry in sets if not entry.motions]
    passing = [entry for entry in joints if entry.permanent is False]
    lasting = [entry for entry in joints if entry.permanent is not False and entry.contradictory]
    problems = [_locked(system, entry) for entry in sets if entry.motions]
    if passing:
        elsewhere = "elsewhere they do not" if redundancy.moves else "no motion away from it was found"
        what = f"at it rows of joints depend on each other, and {elsewhere}"
        hint = "start from a pose that is not stretched or folded"
        message = f"the pose is singular: {what}: {_sets_in_words(passing)}"
        problems.append(Problem(message, _place(system, passing[0]), hint))
    if lasting:
        message = f"rows of joints depend on each other: {_sets_in_words(lasting)}"
        problems.append(Problem(message, _place(system, lasting[0]), "let one of these joints constrain less"))
    return problems


def _locked(system: System, entry: DependentSet) -> Problem:
    """Return the problem of a motion whose coordinate follows from joints and other motions."""
    names = " and ".join(f"'{name}'" for name in entry.motions)
    what = f"motion {names} locks the mechanism: the coordinate that it drives already follows from the joints"
    if len(entry.motions) > 1:
        what = f"motions {names} lock each other: the coordinate that one drives already follows from the others"
    return Problem(
        f"{what}: {_sets_in_words([entry])}",
        _place(system, entry),
        "drive no more coordinates than there are degrees of freedom, and none at a dead centre",
    )


def _sets_in_words(sets: list[DependentSet]) -> str:
    more = f"; and {len(sets) - MOST_SETS} more" if len(sets) > MOST_SETS else ""
    return "; ".join(f"{rows_in_words(entry.held, MOST_JOINTS)}{_odds(entry)}" for entry in sets[:MOST_SETS]) + more


def _odds(entry: DependentSet) -> str:
    """Return, in words, the residual by which the rows contradict each other."""
    for kind, residual, per in zip(("velocities", "accelerations"), entry.residual, ("s", "s^2"), strict=True):
        if residual:
            return f" in contradiction, as the {kind} that they ask for differ by {residual:.3g} {entry.unit}/{per}"
    return ""


def _place(system: System, entry: DependentSet) -> Place | None:
    """Return the place of the row that depends on the others: that of the motion, where there is one."""
    if entry.motions:
        return system.motions.places[system.names.motions.index(entry.motions[-1])]
    return system.joint_places[system.names.joints.index(entry.held[0].name)]


def jammed_wheels(system: System, pose: Pose) -> list[Problem]:
    """Return a note that names rolling joints which block each other, where there are any. Motions are ignored."""
    if not system.rolls or system.bodies > THRESHOLDS.large:
        return []
    free = replace(system, motions=NO_MOTIONS)
    rolling = np.unique(system.joints.owner[system.joints.is_velocity])
    moved = [_point_motion(system, pose, rolling, _motions(each, pose)) for each in (free.at_positions, free)]
    stuck = rolling[(moved[0] > THRESHOLDS.no_motion) & (moved[1] <= THRESHOLDS.no_motion)]
    if not len(stuck):
        return []
    names = shortened([f"'{system.names.joints[joint]}'" for joint in stuck], MOST_JOINTS)
    said = f"joints {names} jam: no motion without slip moves their bodies"
    hint = "wheels roll together where their axles meet in one point, or are parallel"
    return [Problem(said, system.joint_places[stuck[0]], hint)]


def _motions(system: System, pose: Pose) -> Array:
    """Return an orthonormal basis (f, 6n) of the motions of (δr / length, δθ) that all rows allow."""
    every = Component(np.arange(system.constraints - system.bodies), np.arange(system.bodies))
    _, values, vectors = np.linalg.svd(unit_rows(component_rows(system, pose, [every])[0]), full_matrices=True)
    return np.asarray(vectors[np.count_nonzero(values > THRESHOLDS.dependent) :], dtype=float)


def _point_motion(system: System, pose: Pose, joints: Integers, motions: Array) -> Array:
    """Return how far the motions (f, 6n) move the joint's point on body 2, (k,) for these joints, in parts of the
    length."""
    parts = motions.reshape(len(motions), system.bodies, 6)
    bodies = []
    for joint in joints.tolist():
        body, local = int(system.reaction_body[joint]), system.reaction_local[joint]
        if body == system.bodies:
            bodies.append(0.0)
            continue
        turned = np.cross(parts[:, body, 3:], local) @ pose.rotation[body].T / system.length
        bodies.append(float(np.linalg.norm(parts[:, body, :3] + turned)))
    return np.array(bodies)
