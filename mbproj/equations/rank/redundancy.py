"""Redundant rows of C_q: the smallest sets of rows of joints and motions that depend on each other. They may do so
along the whole motion or at one pose only, and with a contradiction or without.

A set is a circuit: leave one row out, and the others are independent. The basis is the earliest rows that are
independent at the start, and further rows that are independent at poses nearby. A row outside the basis depends on it
permanently. A further row depends on the earliest rows, at the start only. So a set is permanent as a whole, or not at
all.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.rank.components import loops_of
from mbproj.dynamics.rank.nearby import Nearby, nearby
from mbproj.dynamics.rank.right_hand_sides import RightHandSides, right_hand_sides
from mbproj.dynamics.rank.row_space import Dependence, dependence_at, dependences, shares, unit_rows
from mbproj.dynamics.rank.row_words import NamedRow, name_rows
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


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
    found = [part for part in dependences(system, pose) if len(part.dependent)]
    if not found:
        return Redundancy((), left_out=left_out)
    around = nearby(system, state.q) if system.bodies <= THRESHOLDS.large else None
    sides, names = right_hand_sides(system, state), name_rows(system, pose)
    sets = [
        _dependent_set(system, part, members, permanent, known, names)
        for part, known in [(part, sides.with_doubt(part)) for part in found]
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
