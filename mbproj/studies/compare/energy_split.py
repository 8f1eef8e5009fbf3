"""The energy drift of a run, split into the part of the integrator and the work of the projection.

Each step is repeated from the state before it, once without projection and once with it, in the formulation of the run.
The change of E - W + D in the first is the integrator's part. The difference of the second from the first is the
projection's work. Their sum is the drift: with fixed steps to round-off, with error control to second order in the
violation. There the kernel projects with the factor of another stage.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics import State
from mbproj.dynamics.observe.recorded import Block
from mbproj.dynamics.observe.total_energy import total_energy
from mbproj.integrate import simulate
from mbproj.integrate.formulations.choice import Choice, choose
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.numpy_loop import march
from mbproj.integrate.reporting.marks import START, Mark
from mbproj.integrate.reporting.tally import Tally
from mbproj.registry import PROJECTIONS
from mbproj.scene.records import Settings
from mbproj.scene.sampling import whole_steps
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.measure.setting import Setting
from mbproj.studies.measure.solve import Solution

#: The first and the largest number of samples with which the steps of a run with error control are looked for.
SAMPLES, MOST_SAMPLES = 4000, 4_000_000


@dataclass(frozen=True, eq=False)
class EnergySplit:
    """The part of the integrator and the work of the projections in the energy drift, each cumulated up to `times`
    (T,), (T,) in J. Their sum is the drift."""

    times: Array
    integrator: Array
    projection: Array


class _StepEnd(NamedTuple):
    """The end of one step: its state, and W - D over the step in J. `carried` is for the next step: the mark of the
    run, and W - D at the mark."""

    state: State
    work: float
    carried: tuple[Mark, float] = (START, 0.0)


def energy_split(mechanism: Mechanism, solution: Solution) -> EnergySplit:
    """Split the energy drift of a solution at its times. Raises SimulationError where a repeated step fails."""
    setting, times = solution.setting, solution.times
    if not PROJECTIONS[setting.projection].corrects:
        return EnergySplit(times, solution.energy_balance, np.where(np.isnan(solution.energy_balance), np.nan, 0.0))
    ends = _step_ends(mechanism, setting, float(times[-1]))
    pairs = list(_steps(mechanism, setting, ends))
    start = _energies(mechanism, [mechanism.state])
    free, closed = (_energies(mechanism, [pair[which].state for pair in pairs]) for which in (0, 1))
    work = np.array([pair[0].work for pair in pairs])
    integrator = free - np.concatenate([start, closed[:-1]]) - work
    # A sample time inside a step has the sums up to the step before.
    row = np.searchsorted(ends, times * (1.0 + 1e-12), side="right") - 1
    return EnergySplit(times, _cumulated(integrator)[row], _cumulated(closed - free)[row])


def _cumulated(changes: Array) -> Array:
    return np.concatenate([np.zeros(1), np.cumsum(changes)])


def _energies(mechanism: Mechanism, states: list[State]) -> Array:
    return np.array([total_energy(mechanism.system, state) for state in states])


def _steps(mechanism: Mechanism, setting: Setting, ends: Array) -> Iterator[tuple[_StepEnd, _StepEnd]]:
    """Repeat all steps; yield the end of each without and with projection. The next step starts from the second."""
    settings = mechanism.settings(setting, float(ends[-1]), float(ends[-1]))
    every, state = settings.projection.every, mechanism.state
    choice, carried = choose(mechanism.system, state, settings), (START, 0.0)
    kept: Mark = START
    always = replace(settings, projection=replace(settings.projection, every=1))
    never = replace(settings, projection=replace(settings.projection, method="none", energy=False, momentum=False))
    for number, (begin, end) in enumerate(pairwise(ends.tolist()), start=1):
        free = _one_step(mechanism, choice, never, state, end - begin, carried)
        closed = free
        if number % every == 0 or number == 1:  # the energy row's balance begins with the first step
            made = _one_step(mechanism, choice, always, state, end - begin, carried)
            kept = {name: value for name, value in made.carried[0].items() if name == "kept"}
            closed = made if number % every == 0 else free
        yield free, closed
        mark, work = closed.carried
        state, carried = replace(closed.state, t=end), ({**mark, **kept}, work)


def _one_step(
    mechanism: Mechanism, choice: Choice, settings: Settings, state: State, h: float, carried: tuple[Mark, float]
) -> _StepEnd:
    """Make one step of size h (s) from a state and the data `carried` to it. Raises SimulationError where it fails."""
    single = replace(settings, step=h, duration=h, tolerance=None, output_step=None)
    if choice.compiled is None:
        full = FullFormulation.of(mechanism.system, state, single, choice.redundant)
        *_, last = march(full, state, Tally())
        return _StepEnd(last.state, float(last.work[0] - last.work[1]))
    run, (mark, before) = choice.compiled.run(state, single), carried
    if mark:
        own = mark if run.kept else {name: value for name, value in mark.items() if name != "kept"}
        run.resume({**own, "t": state.t, "h": h, "grid": 0})
    block = run.advance(2, np.inf)
    failure = choice.compiled.failure(run, settings)
    if failure is not None:
        raise failure
    samples = choice.compiled.samples({name: values[-1:] for name, values in block.items()}, {})
    work = float(samples.work[0, 0] - samples.work[0, 1])
    return _StepEnd(samples.state(0), work - before, (run.here(), work))


class _StepSizes:
    """A recorder of the number and the size of the step that each sample lies in."""

    def __init__(self) -> None:
        self.number: list[Integers] = []
        self.size: list[Array] = []

    def write(self, block: Block) -> None:
        """Record a block of T samples."""
        self.number.append(block["diagnostics/steps"])
        self.size.append(block["diagnostics/step_size"])


def _step_ends(mechanism: Mechanism, setting: Setting, until: float) -> Array:
    """The start time and the times at which the steps of a run end, (N + 1,) in s."""
    if setting.step is not None:
        count = whole_steps(setting.settings(until, until))
        return np.append(setting.step * np.arange(count), until)
    samples = SAMPLES
    while samples <= MOST_SAMPLES:
        kept = _StepSizes()
        simulate(mechanism.system, mechanism.state, mechanism.settings(setting, until, until / samples), kept)
        number, size = np.concatenate(kept.number)[1:], np.concatenate(kept.size)[1:]
        steps, first = np.unique(number, return_index=True)
        if len(steps) == steps[-1]:  # every step has a sample
            return np.append(np.concatenate([[0.0], np.cumsum(size[first][:-1])]), until)
        samples *= 8
    raise ValueError("the steps are too small to be found one by one")
