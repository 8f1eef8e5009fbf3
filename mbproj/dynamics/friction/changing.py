"""The static and sliding forces of dry frictions at a state, where they are functions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import State
from mbproj.functions.series import run
from mbproj.model.frictions import Frictions
from mbproj.model.system import System


def frictions_at(system: System, state: State) -> Frictions:
    """The frictions of a system that has some, with their sliding and static forces at a state as numbers."""
    frictions = system.frictions
    assert frictions is not None
    if not frictions.varies:
        return frictions
    sliding, static = frictions.sliding.copy(), frictions.static.copy()
    forces, which = _forces(system, frictions, state), list(frictions.varies)
    sliding[which], static[which] = forces[:, 0], forces[:, 1]
    return replace(frictions, sliding=sliding, static=static)


def _forces(system: System, frictions: Frictions, state: State) -> Array:
    """The sliding and static forces of the k frictions that change, (k, 2)."""
    programs, variables = frictions.programs, state.instant(system).variables()
    return np.array([float(run(programs, at, variables)[0]) for at in range(programs.size)]).reshape(-1, 2)
