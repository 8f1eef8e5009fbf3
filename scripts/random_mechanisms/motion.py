"""A mechanism run in one formulation with a step and with half of it, its states kept as coordinates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from mbproj import State, System
from mbproj.base.arrays import Array, Integers
from mbproj.base.settings import Settings
from mbproj.equations.assembly.assemble import coordinate_values
from mbproj.equations.kinematics import pose_of
from mbproj.equations.recorded import Block, Observer
from mbproj.equations.samples import Samples, join, stack
from mbproj.motion.formulations.choice import Choice, choose
from mbproj.motion.formulations.full import Accelerations, FullFormulation
from mbproj.motion.kernel_run import march_in_kernel
from mbproj.motion.numpy_loop import march
from mbproj.motion.report import Tally


@dataclass(frozen=True, eq=False)
class Motion:
    """A run: what chose its formulation, its samples, what a results file would hold of them, and its peaks; and the
    same run with half the step."""

    choice: Choice
    samples: Samples
    block: Block
    tally: Tally
    finer: Motion | None


def run(system: System, state: State, settings: Settings) -> Motion:
    """Raises InputError or SimulationError where a run is refused or fails."""
    assert settings.step is not None
    finer = _run(system, state, replace(settings, step=settings.step / 2), None)
    return _run(system, state, settings, finer)


def _run(system: System, state: State, settings: Settings, finer: Motion | None) -> Motion:
    choice, tally = choose(system, state, settings), Tally()
    if choice.compiled is not None:
        samples = join([part for part in march_in_kernel(choice.compiled, state, settings, tally) if part is not None])
    else:
        samples = stack(list(march(FullFormulation.of(system, state, settings, choice.redundant), state, tally)))
    return Motion(choice, samples, Observer(system, state).at(samples), tally, finer)


def full_equations(
    system: System, full: FullFormulation, t: float, turns: Integers
) -> Callable[[Array, Array], Accelerations]:
    """(q, v) -> q'' and λ of the full formulation at a time, joints having made these turns."""

    def solve(q: Array, v: Array) -> Accelerations:
        pose = pose_of(q)
        coordinate = coordinate_values(system, pose) + 2.0 * np.pi * turns
        return full.accelerations(t, full.layout.vector_of({"positions": q, "velocities": v}), coordinate)

    return solve
