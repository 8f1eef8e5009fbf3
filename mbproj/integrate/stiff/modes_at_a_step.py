"""The modes of a mechanism's forces at a state of its run, as fast as they are beside the step."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import may_overflow
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.fast_modes import Mode, fast_modes, leading, slopes, speeds_of_free_bodies
from mbproj.integrate.formulations.choice import Choice
from mbproj.integrate.outcome.stiff_words import Stiffness
from mbproj.integrate.steppers.methods import tableau_of
from mbproj.integrate.steppers.stability_region import amplification, reach
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

#: Laws that are looked at, at most: those that would be fastest on free bodies.
LAWS = 100
#: So many forces are named at most.
MOST_NAMED = 3


@dataclass(frozen=True, eq=False)
class FastModes:
    """Of the forces of a system, in the formulation that was chosen."""

    choice: Choice
    system: System

    def at(self, state: State, step: float) -> list[Mode]:
        """The modes at a state, the fastest first; none where all are slow beside the step."""
        if self.system.forces is None or not self.system.forces.size:
            return []
        with may_overflow():  # the state may be the last one of a run that is lost
            slope = slopes(self.system, state)
        bound = speeds_of_free_bodies(self.system, pose_of(state.q), slope)
        laws = np.sort(np.argsort(-bound)[:LAWS])
        laws = laws[bound[laws] > 0.0]
        if not len(laws) or step * bound.max() < THRESHOLDS.slow_mode:
            return []
        W = self.choice.responses(self.system, state, laws)
        return [] if W is None else fast_modes(W, laws, slope)

    def fastest(self, state: State, step: float) -> tuple[str, complex] | None:
        """What makes the fastest mode, and its eigenvalue; None where all are slow beside the step."""
        mode = next(iter(self.at(state, step)), None)
        return None if mode is None else (self.named(mode), mode.eigenvalue)

    def named(self, mode: Mode) -> str:
        """The forces that make a mode, the one with the largest part first."""
        assert self.system.forces is not None
        names = leading(self.system.forces.owners, mode.shares)
        more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
        return f"force{'s' * (len(names) > 1)} " + ", ".join(f"'{name}'" for name in names[:MOST_NAMED]) + more


def against(integrator: str, step: float, where: str, eigenvalue: complex) -> Stiffness:
    """A mode against what the integrator does to it in a step."""
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
