"""simulate(): runs a system from a state with given settings and hands what it observes to a recorder."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import perf_counter
from typing import Protocol

import numpy as np

from mbproj.dynamics.assembly import State
from mbproj.dynamics.kinematics import pose_of
from mbproj.dynamics.observe import Block, observe, total_energy
from mbproj.dynamics.rank import mobility, refuse_unsolvable
from mbproj.dynamics.samples import Sample, Samples, stack
from mbproj.integrate.full import FullFormulation
from mbproj.integrate.interruption import Interruption, interruption
from mbproj.integrate.march import march
from mbproj.integrate.report import EnergyWatch, Report, worst, worst_joint
from mbproj.integrate.tally import Tally
from mbproj.model.system import System
from mbproj.scene.records import Settings

#: A block is handed on when it has this many samples or is this old, in s.
BLOCK_SAMPLES, BLOCK_SECONDS = 200, 0.5


class Recorder(Protocol):
    """What takes the observed blocks of a run, e.g. `mbproj.results.ResultsWriter`."""

    def write(self, block: Block) -> None:
        """Takes T consecutive samples by dataset path."""


#: Called after every block with the simulated time reached, in s.
Progress = Callable[[float], None]


def simulate(
    system: System,
    state: State,
    settings: Settings,
    recorder: Recorder | None = None,
    progress: Progress | None = None,
) -> Report:
    """Integrates from `state` over `settings.duration`, and reports.

    Raises InputError where the settings do not fit the system or its equations have no unique solution, SimulationError
    where the run cannot go on, and KeyboardInterrupt after SIGINT or SIGTERM; the last two after everything computed so
    far was recorded.
    """
    formulation = FullFormulation.of(system, state, settings)
    ranks = mobility(system, pose_of(state.q))
    refuse_unsolvable(system, ranks)
    tally, energy = Tally(), EnergyWatch()
    initial_energy = total_energy(system, state)
    started = perf_counter()
    with interruption() as asked:
        for samples in _blocks(march(formulation, state, tally), asked):
            block = observe(system, samples, initial_energy)
            potential = block["diagnostics/potential_energy"]
            energy.take(
                float(np.abs(block["diagnostics/energy_balance"]).max()),
                float(block["diagnostics/kinetic_energy"].max()),
                float(potential.min()),
                float(potential.max()),
            )
            if recorder is not None:
                recorder.write(block)
            if progress is not None:
                progress(float(samples.t[-1]))
    return Report(
        formulation="full",
        settings=settings,
        degrees_of_freedom=ranks.degrees_of_freedom,
        counters=tally.counters(),
        position_violation=worst(system, tally.position_peak),
        velocity_violation=worst(system, tally.velocity_peak),
        worst_joint=worst_joint(system, tally.joint_peak),
        energy_drift=energy.drift,
        energy_drift_relative=energy.relative,
        integration_seconds=perf_counter() - started,
    )


def _blocks(run: Iterator[Sample], asked: Interruption) -> Iterator[Samples]:
    """The samples in blocks; when the run fails or is interrupted, first what it had computed."""
    pending: list[Sample] = []
    opened = perf_counter()
    try:
        for sample in run:
            pending.append(sample)
            asked.check()
            if len(pending) >= BLOCK_SAMPLES or perf_counter() - opened > BLOCK_SECONDS:
                block, pending = stack(pending), []
                yield block
                opened = perf_counter()
    except BaseException:
        if pending:
            yield stack(pending)
        raise
    if pending:
        yield stack(pending)
