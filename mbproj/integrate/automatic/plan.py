"""Which method makes the steps, since when, and when that is looked at again: plain data, saved with a run's marks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Any, NamedTuple

import numpy as np

from mbproj.arrays import Array, Flags
from mbproj.dataclass import dataclass
from mbproj.integrate.events.time_events import Event
from mbproj.integrate.outcome.tally import Tally
from mbproj.registry import WHERE_SMOOTH, WHERE_STIFF
from mbproj.thresholds import THRESHOLDS

#: Whose the events are at which another method goes on.
OWNER = "integrator"
#: So many changes of the method are told.
MOST_TOLD = 4


class Switch(NamedTuple):
    """From `time` on (s) the steps are made by `method`: because `where` ("force 'bush'") made |hλ| `omega_h` of an
    explicit step; "" and 0 where nothing holds explicit steps up any more."""

    time: float
    method: str
    where: str = ""
    omega_h: float = 0.0

    @property
    def event(self) -> Event:
        """What the results file records."""
        why = f", for {self.where} (ω h = {self.omega_h:.3g})" if self.where else ""
        return Event(self.time, OWNER, f"{self.method} goes on{why}")


class Since(NamedTuple):
    """Where the last look was: the time (s), and what was counted until then; less than 0 in a leg before."""

    time: float = 0.0
    steps: int = 0
    evaluations: int = 0


@dataclass
class Plan:
    """Scratch of a run. Steps and evaluations are counted from the start of the leg at hand. `due`: the steps tried at
    which the next look is; `trial`: those from which on a trial is due at the latest; `best`: the highest speed since
    the last trial, in s for an evaluation; `failed`: trials in a row that did not pay; `trials` and `tried`: all
    trials, and the evaluations that they took; `spent`: the run's own in the legs before."""

    method: str = WHERE_SMOOTH
    due: int = THRESHOLDS.look_steps
    trial: int = 0
    best: float = 0.0
    failed: int = 0
    trials: int = 0
    tried: int = 0
    spent: int = 0
    since: Since = field(default_factory=Since)
    switches: list[Switch] = field(default_factory=list)

    @property
    def is_stiff(self) -> bool:
        """Whether the implicit method makes the steps."""
        return self.method == WHERE_STIFF

    def is_due(self, speed: float, attempts: int, evaluations: int) -> bool:
        """Whether a run at this speed, in s for an evaluation, tries the other method: it has slowed down, or has not
        tried for long; and trials have not taken much."""
        self.best = max(self.best, speed)
        affordable = self.trials < 2 or self.tried < THRESHOLDS.trial_part * (self.spent + evaluations)
        return affordable and (attempts >= self.trial or speed < THRESHOLDS.slowed * self.best)

    def take(self, switch: Switch) -> None:
        """Another method makes the steps from here on."""
        self.method, self.failed = switch.method, -1
        self.switches.append(switch)

    def begin(self, speed: float, attempts: int) -> None:
        """A trial has ended, after steps that got on so fast."""
        self.failed += 1
        self.best = 0.0 if self.failed == 0 else speed
        self.trial = attempts + THRESHOLDS.look_steps * 2 ** min(self.failed, THRESHOLDS.longest_wait)

    def end_leg(self, counted: Tally) -> None:
        """Counts from here on, where a leg has ended that has counted so much."""
        self.due -= counted.steps + counted.rejected_steps
        self.trial -= counted.steps + counted.rejected_steps
        self.spent += counted.evaluations
        time, steps, evaluations = self.since
        self.since = Since(time, steps - counted.steps, evaluations - counted.evaluations)

    def implicit_at(self, times: Array) -> Flags:
        """Whether the implicit method made the steps there, (T,)."""
        starts = np.array([switch.time for switch in self.switches])
        stiff = np.array([False, *(switch.method == WHERE_STIFF for switch in self.switches)])
        return np.asarray(stiff[np.searchsorted(starts, times, side="left")])

    def save(self) -> dict[str, Any]:
        """As plain data."""
        return {
            "method": self.method,
            "due": self.due,
            "trial": self.trial,
            "best": self.best,
            "failed": self.failed,
            "trials": self.trials,
            "tried": self.tried,
            "spent": self.spent,
            "since": list(self.since),
            "switches": [list(switch) for switch in self.switches],
        }

    @classmethod
    def restore(cls, saved: Mapping[str, Any]) -> Plan:
        """From what was saved. Raises ValueError where it is none."""
        method = str(saved["method"])
        if method not in (WHERE_SMOOTH, WHERE_STIFF):
            raise ValueError(f"{method!r} is no part of it")
        time, steps, evaluations = saved["since"]
        switches = [Switch(float(t), str(name), str(where), float(size)) for t, name, where, size in saved["switches"]]
        return cls(
            method=method,
            due=int(saved["due"]),
            trial=int(saved["trial"]),
            best=float(saved["best"]),
            failed=int(saved["failed"]),
            trials=int(saved["trials"]),
            tried=int(saved["tried"]),
            spent=int(saved["spent"]),
            since=Since(float(time), int(steps), int(evaluations)),
            switches=switches,
        )


def told(plan: Plan) -> tuple[str, ...]:
    """Which method made the steps, line by line, and what it cost to find out."""
    why = f"{WHERE_STIFF} was not quicker" if plan.trials else "no force is stiff"
    lines = [_told(switch) for switch in plan.switches[:MOST_TOLD]] or [f"{plan.method} throughout: {why}"]
    more = len(plan.switches) - MOST_TOLD
    if more > 0:
        lines.append(f"{more} more change{'s' * (more > 1)} of the method; {plan.method} at the end")
    if plan.trials:
        lines.append(f"{plan.trials} trial{'s' * (plan.trials > 1)} of the other method: {plan.tried} evaluations more")
    return tuple(lines)


def _told(switch: Switch) -> str:
    why = f"stiff: {switch.where} (ω h = {switch.omega_h:.3g}); " if switch.where else ""
    return f"{why}{switch.method} from t = {switch.time:.4g} s on"
