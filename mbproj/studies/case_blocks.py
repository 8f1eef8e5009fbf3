"""A block of cases whose scenes differ only in numbers: they are compiled, assembled and measured as one scene whose
numbers are arrays of cases. Each decision of the code must be the same for all; where it is not, CasesDiffer divides
the block."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np

from mbproj.analysis.expectations import measured
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.adjust import compile_system
from mbproj.dynamics.observe.recorded import Block, Observer
from mbproj.dynamics.observe.samples import block_samples
from mbproj.integrate.events.law_switches import switches_of
from mbproj.integrate.events.time_events import events_of
from mbproj.integrate.formulations.choice import choose, obstacle_to_kernel
from mbproj.integrate.formulations.compiled import Compiled
from mbproj.integrate.formulations.kinematic import settings_along
from mbproj.integrate.interruption import TimeIsUp, interruption, time_limit
from mbproj.integrate.kernel_run import RETURN_SECONDS
from mbproj.kernel import core
from mbproj.linear.equilibrium.started import start_state
from mbproj.registry import AUTOMATIC, EQUILIBRIUM
from mbproj.scene.read import Scene
from mbproj.scene.records import Expectation, Settings
from mbproj.scene.text.reading_cache import same_bits
from mbproj.studies.cases.array import CaseArray, CasesDiffer, KernelOfCases, OneCaseOnly, case_of, stacked
from mbproj.studies.measure.measured_samples import MeasuredSamples
from mbproj.studies.measure.mechanism import Mechanism

#: The number of samples, over all cases, that are observed at once: their arrays fit into the processor's cache.
CASE_SAMPLES = 5000
#: The number of runs that the kernel advances in one call. Each call returns after RETURN_SECONDS, with samples of all.
RUNS = 20
#: The arrays of the kernel's samples, without counters.
OF_SAMPLES = ("t", "y", "acceleration", "angles", "multipliers", "step_size")


def values_of(cases: Sequence[Sequence[float | str]]) -> list[Any]:
    """The values of B cases, (B, k), as k values of one scene. Numbers that differ become arrays of cases, as 0.0 and
    -0.0 do. Raises OneCaseOnly where texts differ."""
    columns = []
    for column in zip(*cases, strict=True):
        if all(same_bits(each, column[0]) for each in column):
            columns.append(column[0])
        elif all(isinstance(each, float) for each in column):
            columns.append(CaseArray(np.array(column)))
        else:
            raise OneCaseOnly("texts of several cases differ")
    return columns


def as_one(records: Sequence[Any]) -> Any:
    """One record for several that differ in numbers alone, which become arrays of cases. Raises CasesDiffer where they
    differ in other things."""
    first = records[0]
    if all(each is first for each in records):
        return first
    if len({type(each) for each in records}) > 1:
        raise CasesDiffer([type(each) for each in records])
    if is_dataclass(first) and not isinstance(first, type):
        names = [
            each.name
            for each in fields(first)
            if any(getattr(one, each.name) is not getattr(first, each.name) for one in records)
        ]
        return replace(first, **{name: as_one([getattr(each, name) for each in records]) for name in names})
    if isinstance(first, Mapping):
        return {key: as_one([each[key] for each in records]) for key in first}
    if isinstance(first, tuple):
        return tuple(as_one(each) for each in zip(*records, strict=True))
    return first if all(same_bits(each, first) for each in records) else stacked(records)


@dataclass(frozen=True, eq=False)
class CaseBlock:
    """The mechanism, settings and formulation of `count` cases, with their numbers as arrays of cases."""

    mechanism: Mechanism
    settings: Settings
    compiled: Compiled
    count: int

    @classmethod
    def of(cls, scene: Scene, settings: Settings, count: int) -> CaseBlock:
        """The block of the cases whose numbers a scene has. Raises CasesDiffer where a decision differs between cases,
        and OneCaseOnly where arrays cannot compute the run."""
        if settings.start == EQUILIBRIUM or settings.integrator == AUTOMATIC or settings.formulation == "full":
            raise OneCaseOnly("the settings are for single runs")
        system = compile_system(scene)
        if system.has_contacts or switches_of(system) is not None or system.actions.size:
            raise OneCaseOnly("events depend on the state")
        if obstacle_to_kernel(system, settings):
            raise OneCaseOnly("the kernel cannot run it")
        state = start_state(scene, system)
        choice = choose(system, state, settings, KernelOfCases(core(), count))
        if choice.compiled is None:
            raise OneCaseOnly("the kernel cannot run it")
        own = settings_along(system, settings) if choice.kinematic else settings
        return cls(Mechanism(scene, system, state), own, choice.compiled, count)

    def measures(self, measures: Sequence[Expectation], timeout: float | None = None) -> list[tuple[float, ...] | None]:
        """Return the measures of each case; None for a case whose run does not come to its end, or takes longer than
        `timeout` in s."""
        samples, ended = self._measured_samples(measures, timeout)
        columns = [self._values(each, samples) for each in measures if any(ended)]
        return [tuple(column[at] for column in columns) if whole else None for at, whole in enumerate(ended)]

    def samples(self, measures: Sequence[Expectation]) -> list[CaseSamples | None]:
        """Return the samples that the measures read, for each case; None where `measures` returns None."""
        samples, ended = self._measured_samples(measures, None)
        return [CaseSamples(samples, at) if whole else None for at, whole in enumerate(ended)]

    def observed(self, timeout: float | None = None) -> tuple[Iterator[Block], list[bool]]:
        """Return the samples of all cases, part by part, and whether each case has come to its end within `timeout` in
        s. Cases that have not get the samples of one that has; where none has there are no samples."""
        runs = self._integrated(timeout)
        return self._blocks(runs), [each is not None for each in runs]

    def _blocks(self, runs: Sequence[Mapping[str, Any] | None]) -> Iterator[Block]:
        instead = next((each for each in runs if each), None)
        if instead is None:
            return
        block: dict[str, Any] = {name: stacked([(each or instead)[name] for each in runs]) for name in OF_SAMPLES}
        block["t"] = np.asarray(block["t"])
        observer = Observer(self.mechanism.system, self.mechanism.state)
        length = max(1, CASE_SAMPLES // len(runs))
        for first in range(0, len(block["t"]), length):
            part = {name: values[first : first + length] for name, values in block.items()}
            yield observer.at(self.compiled.samples(part, {}))

    def _measured_samples(
        self, measures: Sequence[Expectation], timeout: float | None
    ) -> tuple[MeasuredSamples, list[bool]]:
        """Return the samples of all cases that the measures read, and whether each case has come to its end."""
        samples = MeasuredSamples(self.mechanism, measures)
        blocks, ended = self.observed(timeout)
        for block in blocks:
            samples.write(block)
        samples.events(events_of(self.mechanism.system, self.mechanism.state.t, self.settings))
        return samples, ended

    def _integrated(self, timeout: float | None) -> list[Mapping[str, Any] | None]:
        """Return the samples of each run, or None where it has not come to its end. A `timeout` holds for each run."""
        runs: list[Any] = self.compiled.run(self.mechanism.state, self.settings).items
        parts: list[list[Mapping[str, Any]]] = [[] for _ in runs]
        size = RUNS if timeout is None else 1
        for first in range(0, len(runs), size):
            with suppress(TimeIsUp), time_limit(timeout):
                self._advance(runs[first : first + size], parts[first : first + size])
        finished = self.compiled.core.Status.finished
        pairs = zip(runs, parts, strict=True)
        return [_joined(samples) if run.outcome.status == finished else None for run, samples in pairs]

    def _advance(self, runs: Sequence[Any], parts: Sequence[list[Mapping[str, Any]]]) -> None:
        """Advance runs until none is left that runs on, and add their samples to their parts."""
        kernel, most = self.compiled.core, block_samples(self.compiled.system.bodies)
        left = list(zip(runs, parts, strict=True))
        with interruption() as asked:
            while left := [each for each in left if each[0].outcome.status == kernel.Status.running]:
                made = kernel.advance_runs([run for run, _ in left], most, RETURN_SECONDS)
                for (_, samples), block in zip(left, made, strict=True):
                    samples.append(block)
                asked.check()

    def _values(self, measure: Expectation, samples: MeasuredSamples) -> list[float]:
        """The first number of a measure for each case; NaN where it has none."""
        duration = self.settings.duration
        try:
            value = measured(measure, samples, duration)
        except (CasesDiffer, OneCaseOnly):
            own = [measured(measure, CaseSamples(samples, at), duration) for at in range(self.count)]
            return [np.nan if each is None else float(each.values[0]) for each in own]
        if value is None:
            return [np.nan] * self.count
        values: list[float] = np.broadcast_to(getattr(value.values[0], "values", value.values[0]), self.count).tolist()
        return values


def _joined(parts: Sequence[Mapping[str, Any]]) -> Mapping[str, Any]:
    """One block of samples for several in turn."""
    if len(parts) == 1:
        return parts[0]
    return {name: np.concatenate([part[name] for part in parts]) for name in OF_SAMPLES}


class CaseSamples:
    """The samples of one case of a block."""

    def __init__(self, samples: MeasuredSamples, at: int) -> None:
        self._samples, self._at, self.names, self.event_times = samples, at, samples.names, samples.event_times

    def __getitem__(self, path: str) -> Any:
        return case_of(self._samples[path], self._at)
