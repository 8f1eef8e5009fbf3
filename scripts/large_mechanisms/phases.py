"""Prints the processor time of each phase before and around a run of a scene, in s: see PHASES."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from mbproj import assemble, compile_system, initial_guess, read_scene
from mbproj.kernel import core
from mbproj.model.planar.reduction import planar_reduction
from mbproj.motion.formulations.reduced import Reduced
from mbproj.motion.formulations.redundant_rows import settle_rows

PHASES = ("read", "compile", "assemble", "planar test", "redundant rows", "a sample's reactions")
T = TypeVar("T")


def main(path: str) -> None:
    """The phases, one after another, in space."""
    import scipy.sparse.linalg  # noqa: F401  what it takes to import is no phase's

    seconds: list[float] = []

    def timed(step: Callable[[], T]) -> T:
        begin = time.process_time()
        found = step()
        seconds.append(time.process_time() - begin)
        return found

    scene = timed(lambda: read_scene(path))
    system = timed(lambda: compile_system(scene))
    state = timed(lambda: assemble(system, initial_guess(scene, system)))
    timed(lambda: planar_reduction(system, state.q))
    space = Reduced(core(), system)
    timed(lambda: settle_rows(space, state))
    equations, y = space.equations(), space.state(state.q, state.v)
    found = equations.accelerations(y)
    assert found is not None
    equations.spread(y[None], np.zeros(1), found[1][None])
    timed(lambda: equations.spread(y[None], np.zeros(1), found[1][None]))
    print(*(f"{each:.6f}" for each in seconds))


if __name__ == "__main__":
    main(sys.argv[1])
