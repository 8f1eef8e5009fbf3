"""A recorder of the datasets that the measures of a study read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj.analysis.observed import datasets
from mbproj.dynamics.observe.recorded import Block
from mbproj.integrate.events.time_events import Event
from mbproj.integrate.simulate import EventRecorder, Recorder
from mbproj.scene.records import Expectation
from mbproj.studies.measure.mechanism import Mechanism


class MeasuredSamples:
    """A recorder of the datasets that `measures` read. It passes each block on to `recorder`, which records
    everything."""

    def __init__(self, mechanism: Mechanism, measures: Sequence[Expectation], recorder: Recorder | None = None) -> None:
        self._names: Mapping[str, tuple[str, ...]] = mechanism.system.names.as_mapping()
        wanted = (path for each in measures for path in datasets(each, self.names("coordinates")))
        self._parts: dict[str, list[npt.NDArray[Any]]] = {path: [] for path in ("time", *wanted)}
        self._recorder = recorder
        self.event_times = np.zeros(0)

    def names(self, kind: str) -> tuple[str, ...]:
        """The names of the columns of a kind, for example of "markers"."""
        return self._names[kind]

    def write(self, block: Block) -> None:
        """Record a block of T samples."""
        for path, parts in self._parts.items():
            parts.append(block[path])
        if self._recorder is not None:
            self._recorder.write(block)

    def events(self, events: Sequence[Event]) -> None:
        """Record the times of the run's events in `event_times` (n,), s."""
        self.event_times = np.array([event.time for event in events])
        if isinstance(self._recorder, EventRecorder):
            self._recorder.events(events)

    def __getitem__(self, path: str) -> npt.NDArray[Any]:
        return np.concatenate(self._parts[path])
