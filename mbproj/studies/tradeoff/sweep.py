"""The sweep of a ladder: its settings run from coarse to fine, until a finer one brings nothing more."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.studies.measure.accuracy import Yardstick
from mbproj.studies.measure.measurement import Measurement
from mbproj.studies.parallel.hand_out import Where
from mbproj.studies.parallel.progress import Tell
from mbproj.studies.parallel.resumable import resumable
from mbproj.studies.store import ValueCache
from mbproj.studies.tradeoff.grid import Ladder

#: A sweep ends when this many settings in a row have not brought the error below this part of the best error.
PATIENCE, FALLING = 3, 0.7


@dataclass(frozen=True)
class SweepSetup:
    """The common data of all sweeps: the yardstick, the error (m) at which a sweep may end, and the seconds of a run
    from which on no finer one is tried."""

    yardstick: Yardstick
    goal: float
    longest: float


def sweep(track: SweepSetup, ladder: Ladder) -> list[Measurement]:
    """Run a ladder's settings from coarse to fine and return their measurements."""
    trials: list[Measurement] = []
    best, stuck = float("inf"), 0
    for setting in ladder.sizes(track.yardstick.reference.times):
        trials.append(track.yardstick.measure(setting))
        reached = trials[-1].at()
        if reached < float("inf"):
            stuck = 0 if reached < FALLING * best else stuck + 1
            best = min(best, reached)
            if best <= track.goal or trials[-1].seconds > track.longest or stuck >= PATIENCE:
                break
    return trials


def _sweep(track: SweepSetup, ladder: Ladder) -> list[dict[str, Any]]:
    return [trial.as_json() for trial in sweep(track, ladder)]


def sweeps(
    track: SweepSetup, ladders: Sequence[Ladder], kept: ValueCache, processes: Where, phase: str, tell: Tell
) -> list[list[Measurement]]:
    """Run the sweeps of all ladders in parallel; return them in the order of `ladders`. Sweeps in the store `kept` are
    not run again."""
    keys = [f"sweep {ladder.base.command_line()}{' by tolerance' * ladder.by_tolerance}" for ladder in ladders]
    found = resumable(_sweep, track, dict(zip(keys, ladders, strict=True)), kept, processes, phase, tell)
    return [[Measurement.from_json(record) for record in found[key]] for key in keys]
