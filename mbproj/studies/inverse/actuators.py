"""Actuators, selected by name: joint coordinates, motions, forces of the scene, components of forces on bodies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.derivatives.linear_equations import MotionAtTime
from mbproj.dynamics.equations.forces import given_components, law_state
from mbproj.errors import InputError, Place, Problem, choose_from
from mbproj.linear.state_space.inputs import forces_known
from mbproj.model.system import System


@dataclass(frozen=True, eq=False)
class Actuators:
    """The k actuators of a system whose motions are removed. `entries` are the names of the forces or coordinates that
    they act on ("A.angle" for a motion of it). `units` are N or N m. `weights` (k,) multiply the squares of their
    forces."""

    system: System
    names: tuple[str, ...]
    entries: tuple[str, ...]
    units: tuple[str, ...]
    weights: Array

    def columns(self, motion: MotionAtTime) -> tuple[Array, Array]:
        """Return B (6n, k), the generalised force of a unit force of each actuator, and the force (k,) that the scene
        already applies through each."""
        known = forces_known(self.system, motion)
        B = np.stack([known[entry][1]() for entry in self.entries], axis=1)
        return B, self._own_forces(motion)

    def _own_forces(self, motion: MotionAtTime) -> Array:
        forces, instant = self.system.forces, motion.instant(self.system)
        given, by_name = forces.on_bodies, dict[str, float]()
        if forces.laws.size:
            by_name |= dict(zip(forces.law_owners, law_state(instant).force.tolist(), strict=False))
        if given.size:
            programs, values = given.program.ravel().tolist(), given_components(instant).ravel().tolist()
            names = [f"{forces.program_owners[p]}.{'xyz'[row % 3]}" for row, p in enumerate(programs)]
            by_name |= dict(zip(names, values, strict=True))
        return np.array([by_name.get(entry, 0.0) for entry in self.entries])


def actuators(
    system: System, free: System, motion: MotionAtTime, names: Sequence[str], weights: Mapping[str, float]
) -> Actuators:
    """The actuators with these names. `system` is that of the scene, `free` the same without motions. Raises InputError
    for an unknown name, for two actuators on one coordinate, and for a weight without an actuator."""
    known, driven = (
        forces_known(free, motion),
        dict(zip(system.names.motions, system.motions.joint_coordinate, strict=True)),
    )
    entries, problems = [], []
    for name in names:
        if name not in known and name not in driven:
            hint = choose_from(name, [*driven, *known])
            problems.append(Problem(f"there is no actuator '{name}'", Place("--actuator"), hint))
            continue
        entries.append(system.names.coordinates[driven[name]] if name in driven else name)
    twice = next((entry for entry in entries if entries.count(entry) > 1), None)
    if twice is not None:
        problems.append(Problem(f"two actuators act along '{twice}'", Place("--actuator"), "name one of them"))
    for name in weights:
        if name not in names:
            problems.append(Problem(f"'{name}' is no actuator here", Place("--weight"), choose_from(name, names)))
    if problems:
        raise InputError(problems)
    units = tuple(known[entry][0] for entry in entries)
    return Actuators(free, tuple(names), tuple(entries), units, np.array([weights.get(name, 1.0) for name in names]))
