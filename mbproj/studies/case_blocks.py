"""A block of cases whose scenes differ only in numbers: they are compiled, assembled and measured as one scene whose
numbers are arrays of cases. Each decision of the code must be the same for all; where it is not, CasesDiffer divides
the block.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import fields, is_dataclass, replace
from traceback import extract_tb
from typing import Any, TypeVar

import numpy as np

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import MbprojError, warn_once
from mbproj.base.registry import AUTOMATIC, EQUILIBRIUM
from mbproj.base.settings import Settings
from mbproj.equations.assembly.compiled import compile_system
from mbproj.equations.recorded import Block, Observer
from mbproj.equations.samples import block_samples
from mbproj.kernel import core
from mbproj.linear.equilibrium.start import start_state
from mbproj.motion.formulations.choice import choose, obstacle_to_kernel, settings_along
from mbproj.motion.formulations.compiled import Compiled
from mbproj.motion.interruption import TimeIsUp, interruption, time_limit
from mbproj.motion.kernel_run import RETURN_SECONDS
from mbproj.motion.law_switches import switches_of
from mbproj.motion.time_events import events_of
from mbproj.results.analysis.expectations import measured
from mbproj.scene.changes import SIMULATION
from mbproj.scene.records import Expectation
from mbproj.scene.scene import Scene
from mbproj.scene.text.reading_cache import same_bits
from mbproj.studies.case_arrays import CaseArray, CasesDiffer, KernelOfCases, OneCaseOnly, case_of, stacked
from mbproj.studies.measure.solve import MeasuredSamples, Mechanism

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
        run_settings = settings_along(system, settings) if choice.kinematic else settings
        return cls(Mechanism(scene, system, state), run_settings, choice.compiled, count)

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
                blocks = kernel.advance_runs([run for run, _ in left], most, RETURN_SECONDS)
                for (_, samples), block in zip(left, blocks, strict=True):
                    samples.append(block)
                asked.check()

    def _values(self, measure: Expectation, samples: MeasuredSamples) -> list[float]:
        """The first number of a measure for each case; NaN where it has none."""
        duration = self.settings.duration
        try:
            value = measured(measure, samples, duration)
        except (CasesDiffer, OneCaseOnly):
            by_case = [measured(measure, CaseSamples(samples, at), duration) for at in range(self.count)]
            return [np.nan if each is None else float(each.values[0]) for each in by_case]
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


# --- by_arrays() ------------------------------------------------------------------------------------------------------
# Runs cases that differ in numbers alone in groups with the same decisions. The caller runs all other cases one by
# one.


Case = TypeVar("Case")
Result = TypeVar("Result")
#: The fewest cases of a group: in groups of 4, six-bars take 0.8 and five-bars 0.65 of the time of single runs.
FEWEST = 5


def by_arrays(
    cases: Sequence[Case],
    run: Callable[[list[Case]], Sequence[Result | None]],
    holds: Callable[[Case, Result], bool] = lambda case, result: True,
    apart: Callable[[Case], Hashable] = lambda case: None,
) -> dict[int, Result]:
    """Return the results of the cases that arrays can run to their end, by the cases' numbers.

    `run` returns the results of a group, None for a case that must run alone. Cases of a group have the same `apart`.
    `holds` compares the first result of a group with that of a single run; where they differ, the group's results are
    dropped. An error that is none of mbproj's own becomes a warning: the cases of the group run alone.
    """
    by_place: dict[int, Result] = {}
    groups: dict[Any, list[int]] = {}
    for at, case in enumerate(cases):
        groups.setdefault(apart(case), []).append(at)
    waiting = [*groups.values()]
    while waiting:
        group = waiting.pop()
        if len(group) < FEWEST:
            continue
        try:
            results = run([cases[at] for at in group])
        except CasesDiffer as differ:
            parts: dict[Any, list[int]] = {}
            for at, key in zip(group, differ.keys, strict=True):
                parts.setdefault(key, []).append(at)
            waiting += parts.values() if len(parts) > 1 else ()
            continue
        except (OneCaseOnly, MbprojError):  # single runs report the error of each case in words
            continue
        except Exception as error:
            warn_once(f"arrays are not used, which is a fault of mbproj: {_placed(error)}")
            continue
        ended = {at: result for at, result in zip(group, results, strict=True) if result is not None}
        first = next(iter(ended), None)
        if first is None or holds(cases[first], ended[first]):
            by_place |= ended
        else:
            warn_once("arrays have other bits than single cases have, which is a fault of mbproj: not used")
    return by_place


def _placed(error: Exception) -> str:
    """The type, message and place of an error."""
    place = extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} ({place.filename}:{place.lineno})"


def common_values(paths: Sequence[str], values: Sequence[float | str]) -> tuple[str, ...]:
    """Return the values that must be equal in all cases of a group: texts and settings of the run. They are returned as
    texts, which differ where a bit does."""
    pairs = zip(paths, values, strict=True)
    return tuple(repr(each) for path, each in pairs if isinstance(each, str) or path.startswith(f"{SIMULATION}."))
