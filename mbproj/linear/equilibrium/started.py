"""The initial state of a run: the assembled start, or the equilibrium that the scene asks for."""

from __future__ import annotations

from dataclasses import replace

from mbproj.dynamics.assembly.assemble import State, assemble
from mbproj.model import initial_guess
from mbproj.model.compile.guess import Guess
from mbproj.model.system import System
from mbproj.registry import EQUILIBRIUM
from mbproj.scene.read import Scene


def assembled_start(scene: Scene, system: System) -> State:
    """Return the assembled start of the scene, from which an equilibrium is sought."""
    return assemble(system, initial_guess(scene, system))


def start_state(scene: Scene, system: System) -> State:
    """Return the initial state of runs of the scene. Raises NoEquilibrium where the scene asks for one and there is
    none."""
    state = assembled_start(scene, system)
    if scene.settings.start != EQUILIBRIUM:
        return state
    from mbproj.linear.equilibrium.find import equilibrium

    return equilibrium(system, state, state.t).state


def beside(scene: Scene, system: System, guess: Guess) -> State:
    """Return the consistent start nearest to a guess. Conditions on joints at the scene's own start apply only
    there."""
    return consistent(system, guess) if scene.settings.start == EQUILIBRIUM else assemble(system, guess)


def consistent(system: System, guess: Guess) -> State:
    """Return the consistent state nearest to a guess, without the scene's conditions on its own start."""
    from mbproj.dynamics.rank.lasting import NO_CONDITIONS

    return assemble(system, replace(guess, start=NO_CONDITIONS, speed=NO_CONDITIONS))
