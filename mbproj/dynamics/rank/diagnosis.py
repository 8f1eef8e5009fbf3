"""Problems that the rows of a mechanism cause in a run, with their places: dependent rows, wheels that jam."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.dynamics.rank.components import Component, component_rows
from mbproj.dynamics.rank.redundancy import DependentSet, Redundancy
from mbproj.dynamics.rank.row_space import unit_rows
from mbproj.dynamics.rank.row_words import rows_in_words
from mbproj.errors import Place, Problem, shortened
from mbproj.model.channels import NO_MOTIONS
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

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
