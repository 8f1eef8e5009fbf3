"""Rank of C_q and of Eq. 20: degrees of freedom, redundant joints, massless motions. None depends on units or size."""

from __future__ import annotations

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.kinematics import Pose, pose_of
from mbproj.dynamics.rank.massless import MasslessMotion, massless_motions, massless_problem
from mbproj.dynamics.rank.row_space import independent
from mbproj.errors import InputError, Problem
from mbproj.model.system import System

__all__ = [
    "Mobility",
    "mobility",
    "refuse_unsolvable",
    "unsolvable",
]


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
