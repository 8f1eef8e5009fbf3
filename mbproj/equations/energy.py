"""The energy T + V of a state (Eq. 16), and the work and losses since the start."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import final

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers, dot, total
from mbproj.equations.assembly.assemble import State
from mbproj.equations.forces import LawState, law_state
from mbproj.equations.instant import Instant
from mbproj.equations.kinematics import Pose, Twist, body_rates
from mbproj.equations.motions import Drive, drive_at
from mbproj.model.system import System


def kinetic_energy(system: System, pose: Pose, twist: Twist) -> Numbers:
    """Return T = ½ Σ m r'² + ½ Σ ωᵀJω in J, and ½ Σ I s'² of reflected inertias, shape (...)."""
    velocity, omega = twist.velocity[..., :-1, :], body_rates(pose, twist)[..., :-1, :]
    turned = [dot(system.inertia[:, axis], omega) for axis in range(3)]
    rotation = sum(omega[..., axis] * turned[axis] for axis in range(3))
    energy: Numbers = 0.5 * total(system.mass * dot(velocity, velocity) + rotation)
    if not system.reflected.size:
        return energy
    from mbproj.equations.of_motion import added_energy

    return energy + added_energy(system.reflected, pose, twist)


def potential_energy(system: System, pose: Pose) -> Numbers:
    """Return V = -Σ m g·r in J, shape (...): zero with all centres of mass at the origin."""
    energy: Numbers = -total(system.mass * dot(system.gravity, pose.position[..., :-1, :]))
    return energy


@final
class EnergyAtStart:
    """The values at the start from which a run counts, each computed on first use."""

    def __init__(self, system: System, state: State) -> None:
        self._system, self._state = system, state

    @cached_property
    def energy(self) -> float:
        """T + V in J."""
        system, state = self._system, self._state
        return system.cached("energy", (state.t, state.y), lambda: total_energy(system, state))

    @cached_property
    def of_elements(self) -> tuple[Numbers, Numbers]:
        """The energies in J that elements store, and have lost."""
        return of_elements(self._state.instant(self._system))

    @cached_property
    def sums(self) -> Array:
        """The whole teeth of each gear and screw, (k,)."""
        from mbproj.equations.turning import sums_at_start

        at = self._state.instant(self._system)
        return sums_at_start(self._system, at.pose, at.expected)

    def drive(self, t: Numbers, coordinate: Numbers) -> Drive:
        """Return the values that motions prescribe at times t (T,), with the teeth in mesh at the joints' coordinates
        (T, nc)."""
        if not self._system.couplings.size:
            return drive_at(self._system, t)
        from mbproj.equations.turning import Teeth

        return drive_at(self._system, t, Teeth(self.sums, coordinate))


def total_energy(system: System, state: State) -> float:
    """Return T + V of one state, in J."""
    at = state.instant(system)
    energy = kinetic_energy(system, at.pose, at.twist)
    energy = energy + potential(at, law_state(at))
    if system.stops is not None:
        from mbproj.equations.contacts import stored_energy
        from mbproj.equations.gaps import gaps

        energy = energy + stored_energy(system.stops, gaps(system.stops, at.pose, state.turns))
    total: float = energy.item()
    return total


def potential(instant: Instant, laws: LawState) -> Numbers:
    """Return V in J of gravity, springs and the stores of elements."""
    return potential_energy(instant.system, instant.pose) + laws.stored + of_elements(instant)[0]


def stored(instant: Instant, laws: LawState, turns: Callable[[], Integers]) -> Numbers:
    """Return V in J of gravity, springs, elements and compliant stops; `turns` gives those of the joints' angles."""
    V, stops = potential(instant, laws), instant.system.stops
    if stops is None:
        return V
    from mbproj.equations.contacts import stored_energy
    from mbproj.equations.gaps import gaps

    return V + stored_energy(stops, gaps(stops, instant.pose, turns()))


def of_elements(instant: Instant) -> tuple[Numbers, Numbers]:
    """Return the energies in J that elements store, and have lost since they began, (...)."""
    energies = instant.system.energies
    if not (energies.stored.size or energies.lost.size):
        none = np.zeros(instant.pose.position.shape[:-2])
        return none, none
    from mbproj.functions.values import values

    variables = instant.values()
    stores, lost = (
        sum(values(programs, range(programs.size), variables), np.zeros(instant.pose.position.shape[:-2]))
        for programs in (energies.stored, energies.lost)
    )
    return stores, lost


def account(instant: Instant, at_start: tuple[Numbers, Numbers], work: Array) -> tuple[Numbers, Numbers]:
    """Return W and D since the start, (T,), with the `work` (T, 2 + ...) of all forces. Elements may store and lose
    more energy than their forces take from the mechanism; this energy counts as work W from outside."""
    stores, lost = (now - then for now, then in zip(of_elements(instant), at_start, strict=True))
    return work[:, 0] + stores + lost, work[:, 1] + lost
