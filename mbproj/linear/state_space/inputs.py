"""Inputs of a linear model by their names: forces of the scene, forces along joint coordinates, motions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.derivatives.law_derivatives import given_rows
from mbproj.dynamics.derivatives.linear_equations import MotionAtTime
from mbproj.dynamics.derivatives.row_derivatives import rows_at
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.errors import InputError, Problem, choose_from
from mbproj.linear.reference import LinearReference
from mbproj.model.system import System


@dataclass(frozen=True, eq=False)
class Inputs:
    """p inputs with names and units. `force` (6n, p): the forces on the bodies by a unit of each input, torques in body
    axes. `motion` (p,): the number of the motion that each accelerates, -1 for forces."""

    names: tuple[str, ...]
    units: tuple[str, ...]
    force: Array
    motion: Integers


def inputs_named(reference: LinearReference, names: Sequence[str]) -> Inputs:
    """Return the inputs of these names. Raises InputError for a name that does not exist."""
    known = forces_known(reference.system, reference.motion)
    motions = reference.system.names.motions
    able = [*known, *motions]
    problems = [Problem(f"unknown input '{name}'", hint=choose_from(name, able)) for name in names if name not in able]
    if problems:
        raise InputError(problems)
    columns = [known[name][1]() if name in known else np.zeros(6 * reference.system.bodies) for name in names]
    return Inputs(
        tuple(names),
        tuple(known[name][0] if name in known else _motion_unit(reference.system, name) for name in names),
        np.array(columns).reshape(len(names), 6 * reference.system.bodies).T,
        np.array([motions.index(name) if name in motions else -1 for name in names], dtype=np.intp),
    )


def _motion_unit(system: System, name: str) -> str:
    return f"{system.names.motion_units[system.names.motions.index(name)]}/s^2"


#: The unit of an input, and the forces (6n,) on the bodies by a unit of it.
Entry = tuple[str, Callable[[], Array]]


def forces_known(system: System, motion: MotionAtTime) -> dict[str, Entry]:
    """Return every force by name: along joint coordinates "A.angle", along the coordinate of a force of the scene, and
    components of forces and torques on bodies, "push.x"."""
    pose, entries = motion.pose, dict[str, Entry]()
    laws = system.forces.laws.coordinates, system.forces.law_owners
    for bound, names in ((system.coordinates, system.names.coordinates), laws):
        rows = rows_at(bound, pose)
        for row, (name, unit) in enumerate(zip(names, bound.units, strict=True)):
            entries[name] = ("N" if unit == "m" else "N m", partial(rows.at, row))
    return entries | _on_bodies(system, pose)


def _on_bodies(system: System, pose: Pose) -> dict[str, Entry]:
    given, owners = system.forces.on_bodies, system.forces.program_owners
    rows = given_rows(system.forces, pose)
    return {
        f"{owners[int(program)]}.{'xyz'[row % 3]}": ("N m" if given.is_torque[row // 3] else "N", partial(rows.at, row))
        for row, program in enumerate(given.program.ravel())
        if given.body[row // 3] < system.bodies
    }
