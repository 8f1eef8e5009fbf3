"""The modes of a mechanism's forces and its elements' states at a state of its run, compared with the step."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Integers, may_overflow
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.derivatives.law_derivatives import state_slopes
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.fast_modes import Mode, fast_modes, leading, slopes, speeds_of_free_bodies
from mbproj.errors import shortened
from mbproj.integrate.formulations.choice import Choice
from mbproj.integrate.reporting.stiff_words import Stiffness
from mbproj.integrate.steppers.stability_region import amplification, reach
from mbproj.integrate.steppers.tableau import tableau_of
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

#: The most coordinates of forces that are considered: those that would be fastest on free bodies.
LAWS = 100
#: The most forces or states that a message names.
MOST_NAMED = 3


def modes_at(choice: Choice, system: System, state: State, step: float = np.inf) -> tuple[Integers, list[Mode]]:
    """Return the coordinates of forces that are considered, (e,), and the modes at a state, the fastest first. There
    are no modes where all are slow compared with the step."""
    with may_overflow():  # the state may be the last one of a run that is lost
        slope, of_states = slopes(system, state), _state_slopes(system, state)
    bound = speeds_of_free_bodies(system, pose_of(state.q), slope)
    fastest = max(bound.max(initial=0.0), np.abs(np.linalg.eigvals(of_states)).max(initial=0.0))
    laws = np.sort(np.argsort(-bound)[:LAWS])
    laws = laws[bound[laws] > 0.0]
    if fastest == 0.0 or step * fastest < THRESHOLDS.stiff_for_step:
        return laws, []
    W = choice.responses(system, state, laws) if len(laws) else np.zeros((0, 0))
    if W is None:
        laws, W = laws[:0], np.zeros((0, 0))
    return laws, fast_modes(W, laws, slope, of_states)


def _state_slopes(system: System, state: State) -> Array:
    return state_slopes(state.instant(system))


def can_be_fast(system: System) -> bool:
    """Return whether there are forces along coordinates, or states of elements."""
    return system.states.size > 0 or system.forces.size > 0


@dataclass(frozen=True, eq=False)
class Owners:
    """The causes of a mode, the one with the largest part first: `forces`, or `states` of elements."""

    forces: tuple[str, ...] = ()
    states: tuple[str, ...] = ()

    @classmethod
    def of(cls, system: System, mode: Mode) -> Owners:
        """Return the causes of a mode of a system."""
        count = len(system.names.states)
        along = len(mode.shares) - count
        if mode.shares[along:].any():
            return cls(states=leading(system.names.states, mode.shares[along:]))
        return cls(forces=leading(system.forces.owners, mode.shares[:along]))

    @property
    def words(self) -> str:
        """The causes in words: "forces 'a', 'b'"."""
        kind, names = ("state", self.states) if self.states else ("force", self.forces)
        return f"{kind}{'s' * (len(names) > 1)} " + shortened([f"'{name}'" for name in names], MOST_NAMED)


@dataclass(frozen=True, eq=False)
class FastModes:
    """The fast modes of the forces and states of a system, in the chosen formulation."""

    choice: Choice
    system: System

    def at(self, state: State, step: float) -> list[Mode]:
        """Return the modes at a state, the fastest first; none where all are slow compared with the step."""
        return modes_at(self.choice, self.system, state, step)[1]

    def fastest(self, state: State, step: float) -> tuple[str, complex] | None:
        """Return the cause of the fastest mode, and its eigenvalue; None where all are slow compared with the step."""
        mode = next(iter(self.at(state, step)), None)
        return None if mode is None else (self.causes(mode), mode.eigenvalue)

    def causes(self, mode: Mode) -> str:
        """Return the causes of a mode in words, the one with the largest part first."""
        return Owners.of(self.system, mode).words


def against(integrator: str, step: float, where: str, eigenvalue: complex) -> Stiffness:
    """Return a mode's |hλ| and growth in a step of an integrator, with the integrator's limit of stability."""
    size, tableau = abs(eigenvalue), tableau_of(integrator)
    direction = complex(round(min(eigenvalue.real, 0.0) / size, 3), round(abs(eigenvalue.imag) / size, 3))
    z = step * eigenvalue
    return Stiffness(
        where=where,
        omega_h=step * size,
        limit=reach(tableau, direction),
        growth=amplification(tableau, z) / np.exp(max(z.real, 0.0)),
        step=step,
        direction=direction,
        integrator=integrator,
    )
