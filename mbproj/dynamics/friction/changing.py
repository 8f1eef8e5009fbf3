"""Dry friction at a state: what it is where it changes in a run, and how hard it resists sliding."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import State
from mbproj.functions.series import run
from mbproj.model.frictions import Frictions
from mbproj.model.system import System


def frictions_at(system: System, state: State) -> Frictions:
    """The frictions of a system that has some, with what slides and holds at a state as numbers."""
    found = system.frictions
    assert found is not None
    if not found.varies:
        return found
    sliding, static = found.sliding.copy(), found.static.copy()
    sizes, which = _sizes(system, found, state), list(found.varies)
    sliding[which], static[which] = sizes[:, 0], sizes[:, 1]
    return replace(found, sliding=sliding, static=static)


def sliding_forces(frictions: Frictions, speed: Array) -> Array:
    """How hard frictions resist sliding at these speeds, (..., K), before loads."""
    falls = np.exp(-((speed / np.where(frictions.stribeck > 0.0, frictions.stribeck, 1.0)) ** 2))
    more = np.where(frictions.stribeck > 0.0, falls, 0.0)
    return np.asarray(frictions.sliding + (frictions.static - frictions.sliding) * more)


def _sizes(system: System, frictions: Frictions, state: State) -> Array:
    """What slides and what holds of those that change, (k, 2)."""
    programs, variables = frictions.programs, state.instant(system).variables()
    found = [float(run(programs, at, variables)[0]) for at in range(programs.size)]
    return np.array(found).reshape(-1, 2)
