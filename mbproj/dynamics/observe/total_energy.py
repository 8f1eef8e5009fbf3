"""The energy T + V of a state: gravity's, and that of springs."""

from __future__ import annotations

from mbproj.arrays import Numbers
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.energy import kinetic_energy, potential_energy
from mbproj.dynamics.equations.forces import LawState, law_state
from mbproj.dynamics.equations.gaps import gaps, stored_energy
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.model.system import System


def total_energy(system: System, state: State) -> float:
    """T + V in J of one state."""
    at = state.instant(system)
    found = kinetic_energy(system, at.pose, at.twist)
    found = found + potential(system, at.pose, law_state(at))
    own = 0.0 if system.stops is None else stored_energy(system.stops, gaps(system.stops, at.pose, state.turns))
    return float(found + own)


def potential(system: System, pose: Pose, laws: LawState) -> Numbers:
    """V in J of gravity and of springs."""
    return potential_energy(system, pose) + laws.stored
