"""run_block(): the runs of all cases of a block, and their measures; samples_of_block(): their samples."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from mbproj.analysis.expectations import measured
from mbproj.dynamics.observe.recorded import Block, Observer
from mbproj.dynamics.observe.samples import block_samples
from mbproj.integrate.events.time_events import events_of
from mbproj.integrate.formulations.compiled import Compiled
from mbproj.integrate.loop.compiled_march import RETURN_SECONDS
from mbproj.integrate.loop.interruption import TimeIsUp, interruption, time_limit
from mbproj.lanes import Each, Parted, lane, restacked
from mbproj.scene.records import Expectation
from mbproj.studies.measure.measured_samples import MeasuredSamples
from mbproj.studies.together.signature import Signature

#: The number of samples, over all cases, that are observed at once: their arrays fit into the processor's cache.
CASE_SAMPLES = 5000
#: The arrays of the kernel's samples, without counters.
OF_SAMPLES = ("t", "y", "acceleration", "angles", "multipliers", "step_size")


def observed(signature: Signature, count: int, timeout: float | None = None) -> tuple[Iterator[Block], list[bool]]:
    """Return the samples of `count` cases, part by part, and whether each case has come to its end within `timeout` in
    s. Cases that have not get the samples of one that has; where none has there are no samples."""
    mechanism, compiled = signature.mechanism, signature.choice.compiled
    assert compiled is not None
    runs = _integrated(compiled, compiled.run(mechanism.state, signature.settings), count, timeout)
    return _blocks(signature, runs), [each is not None for each in runs]


def _blocks(signature: Signature, runs: Sequence[Mapping[str, Any] | None]) -> Iterator[Block]:
    mechanism, compiled = signature.mechanism, signature.choice.compiled
    instead = next((each for each in runs if each), None)
    if instead is None or compiled is None:
        return
    block: dict[str, Any] = {name: restacked([(each or instead)[name] for each in runs]) for name in OF_SAMPLES}
    block["t"] = np.asarray(block["t"])
    observer, length = Observer(mechanism.system, mechanism.state), max(1, CASE_SAMPLES // len(runs))
    for first in range(0, len(block["t"]), length):
        part = {name: values[first : first + length] for name, values in block.items()}
        yield observer.at(compiled.samples(part, {}))


def run_block(
    signature: Signature, measures: Sequence[Expectation], count: int, timeout: float | None = None
) -> list[tuple[float, ...] | None]:
    """Return the measures of each of `count` cases; None for a case whose run does not come to its end, or takes longer
    than `timeout` in s."""
    samples, ended = _measured_samples(signature, measures, count, timeout)
    columns = [_values(each, samples, signature.settings.duration, count) for each in measures if any(ended)]
    return [tuple(column[at] for column in columns) if whole else None for at, whole in enumerate(ended)]


def samples_of_block(signature: Signature, measures: Sequence[Expectation], count: int) -> list[OfLane | None]:
    """Return the samples that the measures read, for each of `count` cases; None where `run_block` returns None."""
    samples, ended = _measured_samples(signature, measures, count)
    return [OfLane(samples, at) if whole else None for at, whole in enumerate(ended)]


def _measured_samples(
    signature: Signature, measures: Sequence[Expectation], count: int, timeout: float | None = None
) -> tuple[MeasuredSamples, list[bool]]:
    """Return the samples of all cases that the measures read, and whether each case has come to its end."""
    mechanism = signature.mechanism
    samples = MeasuredSamples(mechanism, measures)
    blocks, ended = observed(signature, count, timeout)
    for block in blocks:
        samples.write(block)
    samples.events(events_of(mechanism.system, mechanism.state.t, signature.settings))
    return samples, ended


def _integrated(compiled: Compiled, run: Any, count: int, timeout: float | None) -> list[Mapping[str, Any] | None]:
    """Return the samples of each run, or None where it has not come to its end. A `timeout` holds for each run."""
    runs = list(run.items) if isinstance(run, Each) else [run]  # all cases have the same run
    parts: list[list[Mapping[str, Any]]] = [[] for _ in runs]
    if timeout is None:
        _advance(compiled, runs, parts)
    else:
        for own, samples in zip(runs, parts, strict=True):
            with suppress(TimeIsUp), time_limit(timeout):
                _advance(compiled, [own], [samples])
    finished = compiled.core.Status.finished
    ends = [
        _joined(samples) if run.outcome.status == finished else None for run, samples in zip(runs, parts, strict=True)
    ]
    return ends if len(ends) == count else ends * count


def _advance(compiled: Compiled, runs: list[Any], parts: list[list[Mapping[str, Any]]]) -> None:
    """Advance runs until none is left that runs on, and add their samples to their parts."""
    running, most = compiled.core.Status.running, block_samples(compiled.system.bodies)
    left = list(zip(runs, parts, strict=True))
    with interruption() as asked:
        while left := [each for each in left if each[0].outcome.status == running]:
            made = compiled.core.advance_runs([run for run, _ in left], most, RETURN_SECONDS)
            for (_, samples), block in zip(left, made, strict=True):
                samples.append(block)
            asked.check()


def _joined(parts: Sequence[Mapping[str, Any]]) -> Mapping[str, Any]:
    """One block of samples for several in turn."""
    return (
        parts[0] if len(parts) == 1 else {name: np.concatenate([part[name] for part in parts]) for name in OF_SAMPLES}
    )


def _values(measure: Expectation, samples: MeasuredSamples, duration: float | None, count: int) -> list[float]:
    """The first number of a measure for each case; NaN where it has none."""
    try:
        value = measured(measure, samples, duration)
    except (Parted, TypeError):
        own = [measured(measure, OfLane(samples, at), duration) for at in range(count)]
        return [np.nan if each is None else float(each.values[0]) for each in own]
    if value is None:
        return [np.nan] * count
    values: list[float] = np.broadcast_to(getattr(value.values[0], "values", value.values[0]), count).tolist()
    return values


class OfLane:
    """The samples of one case."""

    def __init__(self, samples: MeasuredSamples, at: int) -> None:
        self._samples, self._at, self.names, self.event_times = samples, at, samples.names, samples.event_times

    def __getitem__(self, path: str) -> Any:
        return lane(self._samples[path], self._at)
