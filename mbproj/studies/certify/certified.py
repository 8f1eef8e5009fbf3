"""A run with a certificate: the positions of its points are recorded, and judged when the run ends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol, overload

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics import State
from mbproj.dynamics.observe.recorded import Block
from mbproj.errors import SimulationError
from mbproj.integrate import Report, simulate
from mbproj.integrate.events.time_events import Event
from mbproj.integrate.formulations.choice import choose
from mbproj.integrate.reporting.report import words_on_shares
from mbproj.integrate.simulate import EventRecorder, Keep, Progress
from mbproj.model.system import System
from mbproj.results.trust import Trust
from mbproj.scene.records import Scene, Settings
from mbproj.studies.certify.horizon import LIMITS, certify
from mbproj.studies.certify.kinematic import certify_kinematic
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.parallel.progress import Tell, silent


class CertificateRecorder(Protocol):
    """A recorder of a run's blocks and then its certificate, e.g. `mbproj.results.ResultsWriter`."""

    def write(self, block: Block) -> None:
        """Records T consecutive samples by dataset path."""

    def trust(self, trust: Trust) -> None:
        """Records the certificate."""


@overload
def simulate_certified(
    system: System,
    state: State,
    settings: Settings,
    recorder: CertificateRecorder | None = None,
    progress: Progress | None = None,
    *,
    scene: Scene,
    limits: Sequence[float] = LIMITS,
    tell: Tell = silent,
    keep: Keep | None = None,
) -> tuple[Report, Trust]: ...
@overload
def simulate_certified(
    mechanism: Mechanism,
    settings: Settings,
    recorder: CertificateRecorder | None = None,
    progress: Progress | None = None,
    limits: Sequence[float] = LIMITS,
    tell: Tell = silent,
    keep: Keep | None = None,
) -> tuple[Report, Trust]: ...
def simulate_certified(*given: Any, scene: Scene | None = None, **named: Any) -> tuple[Report, Trust]:
    """Runs `simulate` with its arguments, and returns also how long the result can be trusted (see `certify`).

    It needs the `scene` of the system too, to compute better solutions; or a `Mechanism` in place of system, state and
    scene. A run that fails is certified up to its failure before SimulationError is raised; an interrupted one is not
    certified.
    """
    system = given[0] if given else named.get("system")
    if isinstance(system, System):
        if scene is None:
            raise TypeError("simulate_certified() lacks the argument 'scene': that of the system")
        words = ("system", "state")
        named |= dict(zip(words, given, strict=False))
        given = (Mechanism(scene, named.pop("system"), named.pop("state")), *given[2:])
    return _certified(*given, **named)


def _certified(
    mechanism: Mechanism,
    settings: Settings,
    recorder: CertificateRecorder | None = None,
    progress: Progress | None = None,
    limits: Sequence[float] = LIMITS,
    tell: Tell = silent,
    keep: Keep | None = None,
) -> tuple[Report, Trust]:
    paths = _PointRecorder(mechanism, recorder)
    kinematic = choose(mechanism.system, mechanism.state, settings).kinematic

    def judge() -> Trust:
        decided = words_on_shares(paths.met)
        refusal = f"no figure: the motion depends on how these share their load, {decided}" if decided else ""
        if kinematic and len(paths.arrays[0]) > 1:
            trust = certify_kinematic(mechanism, *paths.arrays, limits, tell)
        else:
            trust = certify(mechanism, settings, *paths.arrays, limits, tell, refusal)
        if recorder is not None:
            recorder.trust(trust)
        return trust

    try:
        report = simulate(mechanism.system, mechanism.state, settings, paths, progress, keep=keep)
    except SimulationError:
        judge()
        raise
    return report, judge()


class _PointRecorder:
    """A recorder of the points' positions, which passes everything on to another recorder."""

    def __init__(self, mechanism: Mechanism, recorder: CertificateRecorder | None) -> None:
        self._dataset, self._recorder = f"{mechanism.kind}/position", recorder
        self._times: list[Array] = []
        self._positions: list[Array] = []
        self.met: Sequence[Event] = ()

    def write(self, block: Block) -> None:
        """Record a block of T samples."""
        self._times.append(block["time"])
        self._positions.append(block[self._dataset])
        if self._recorder is not None:
            self._recorder.write(block)

    def events(self, events: Sequence[Event]) -> None:
        """Record the events of the run."""
        self.met = events
        if isinstance(self._recorder, EventRecorder):
            self._recorder.events(events)

    @property
    def arrays(self) -> tuple[Array, Array]:
        """The times (T,) and the positions (T, k, 3)."""
        return np.concatenate(self._times), np.concatenate(self._positions)
