"""The energy T + V of states: gravity's, and that of springs."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers, Numbers
from mbproj.dynamics.assembly.assemble import State, coordinate_values
from mbproj.dynamics.equations.energy import kinetic_energy, potential_energy
from mbproj.dynamics.equations.forces import LawState, law_state
from mbproj.dynamics.equations.gaps import gaps, stored_energy
from mbproj.dynamics.equations.kinematics import Pose, Twist, pose_of, twist_of
from mbproj.model.system import System


def total_energy(system: System, state: State) -> float:
    """T + V in J of one state."""
    return float(total_energies(system, np.array(state.t), state.q, state.v, state.turns))


def total_energies(system: System, t: Array, q: Array, v: Array, turns: Integers) -> Numbers:
    """T + V in J, (...), of states: times (...), coordinates and velocities (..., 7n), whole turns (..., nc)."""
    pose = pose_of(q)
    twist = twist_of(pose, v)
    laws = None
    if system.forces is not None:
        laws = laws_at(system, pose, twist, t, coordinate_values(system, pose) + 2.0 * np.pi * turns)
    total = kinetic_energy(system, pose, twist) + potential(system, pose, laws)
    return total if system.stops is None else total + stored_energy(system.stops, gaps(system.stops, pose, turns))


def laws_at(
    system: System, pose: Pose, twist: Twist, t: Numbers | float, coordinate: Numbers, carried: Numbers | None = None
) -> LawState | None:
    """What the laws of forces are at; None without forces. `coordinate` are the joints', turns counted; `carried` as
    `law_state` has it."""
    return None if system.forces is None else law_state(system.forces, pose, twist, t, coordinate, None, carried)


def potential(system: System, pose: Pose, laws: LawState | None) -> Numbers:
    """V in J of gravity and of springs."""
    of_gravity = potential_energy(system, pose)
    return of_gravity if laws is None else of_gravity + laws.stored
