"""Of each peer and each error asked for, the cheapest setting whose measured error is below it, timed side by side."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from statistics import median

from peers.peer import NotConverged, Observation, Peer, Setting
from peers.problem import Mechanism

#: Runs shorter than this are repeated within a repetition, s.
SHORTEST = 2e-3
#: A sweep ends after a run of so many seconds, or when so many settings in a row did not lower the error by a tenth.
LONGEST, PLATEAU = 20.0, 8
#: Settings are timed in full whose first timing was within this factor of the quickest that is accurate enough.
NEAR = 1.5


@dataclass
class Trial:
    """A setting of a peer with its measured error (m), opening (m), and seconds of each repetition."""

    peer: Peer
    setting: Setting
    error: float
    opening: float | None
    pilot: float
    seconds: list[float] = field(default_factory=list)

    @property
    def time(self) -> float:
        """The median of the repetitions, s."""
        return median(self.seconds) if self.seconds else self.pilot


def sweep(peer: Peer, mechanism: Mechanism, errors: Sequence[float], longest: float = LONGEST) -> list[Trial]:
    """The settings of a peer from coarse to fine, each run once with outputs and once timed, until the smallest of
    `errors` is met, or the sweep is exhausted, slow or at its plateau."""
    trials: list[Trial] = []
    best, stuck = float("inf"), 0
    for setting in peer.settings(mechanism):
        try:
            seen = setting.observe()
            trial = Trial(peer, setting, mechanism.error(seen.points), seen.opening, setting.integrate())
        except NotConverged:
            continue
        trials.append(trial)
        stuck = 0 if trial.error < 0.9 * best else stuck + 1
        best = min(best, trial.error)
        if best <= min(errors) or trial.pilot > longest or (stuck >= PLATEAU and best < 0.1 * max(errors)):
            break
    return trials


def candidates(trials: Iterable[Trial], errors: Sequence[float]) -> list[Trial]:
    """The trials that may be the quickest for one of the errors."""
    chosen: list[Trial] = []
    for error in errors:
        able = [trial for trial in trials if trial.error <= error]
        quickest = min((trial.pilot for trial in able), default=0.0)
        chosen += [trial for trial in able if trial.pilot <= NEAR * quickest and trial not in chosen]
    return chosen


def interleave(trials: Sequence[Trial], repetitions: int) -> None:
    """Times all trials in turn, `repetitions` times over, so that a slow spell of the machine meets all of them."""
    for _ in range(repetitions):
        for trial in trials:
            count = max(1, round(SHORTEST / max(trial.pilot, 1e-6)))
            trial.seconds.append(median(trial.setting.integrate() for _ in range(count)))


def cheapest(trials: Iterable[Trial], error: float) -> Trial | None:
    """The quickest trial whose error is at most `error`."""
    return min((trial for trial in trials if trial.error <= error), key=lambda trial: trial.time, default=None)


def warm(setting: Setting) -> tuple[float, Observation]:
    """Seconds of a first run, with all that is built only once, and what it gave."""
    seen = setting.observe()
    return setting.integrate(), seen
