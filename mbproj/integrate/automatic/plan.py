"""The plan of `integrator: auto`: the method in use, since when, and the next look. It is saved with a run's marks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from typing import Any, NamedTuple

import numpy as np

from mbproj.arrays import Array, Flags
from mbproj.dataclass import dataclass
from mbproj.integrate.events.time_events import Event
from mbproj.registry import WHERE_SMOOTH, WHERE_STIFF
from mbproj.thresholds import THRESHOLDS

#: The owner of events at which the method changes.
OWNER = "integrator"
#: The most changes of the method that the report lists.
MOST_TOLD = 4


class Switch(NamedTuple):
    """A change: from `time` on (s) `method` makes the steps. For a change to the implicit method, `where` ("force
    'bush'") is the cause, with |hλ| = `omega_h` for an explicit step; else they are "" and 0."""

    time: float
    method: str
    where: str = ""
    omega_h: float = 0.0

    @property
    def event(self) -> Event:
        """The event for the results file."""
        why = f", for {self.where} (ω h = {self.omega_h:.3g})" if self.where else ""
        return Event(self.time, OWNER, f"{self.method} goes on{why}")


class Since(NamedTuple):
    """The time (s) of the last look, and the counts at it."""

    time: float = 0.0
    steps: int = 0
    evaluations: int = 0


@dataclass
class Plan:
    """The plan of one run, which changes as the run goes on.

    `due`: the number of attempted steps at the next look. `trial`: the number at which a trial is due at the latest.
    `best`: the highest speed since the last trial, in simulated s per evaluation. `failed`: the number of failed trials
    in a row. `trials` and `tried`: the number of all trials, and of their evaluations."""

    method: str = WHERE_SMOOTH
    due: int = THRESHOLDS.look_steps
    trial: int = 0
    best: float = 0.0
    failed: int = 0
    trials: int = 0
    tried: int = 0
    since: Since = field(default_factory=Since)
    switches: list[Switch] = field(default_factory=list)

    @property
    def is_stiff(self) -> bool:
        """Whether the implicit method makes the steps."""
        return self.method == WHERE_STIFF

    def is_due(self, speed: float, attempts: int, evaluations: int) -> bool:
        """Whether a run at this speed, in simulated s per evaluation, should try the other method. It should where it
        has slowed down or the last trial is long ago, unless trials have taken too much of the work."""
        self.best = max(self.best, speed)
        affordable = self.trials < 2 or self.tried < THRESHOLDS.trial_part * evaluations
        return affordable and (attempts >= self.trial or speed < THRESHOLDS.slowed * self.best)

    def take(self, switch: Switch) -> None:
        """Change to the method of `switch`."""
        self.method, self.failed = switch.method, -1
        self.switches.append(switch)

    def begin(self, speed: float, attempts: int) -> None:
        """Record the end of a trial. `speed`: the run's speed before it, in simulated s per evaluation."""
        self.failed += 1
        self.best = 0.0 if self.failed == 0 else speed
        self.trial = attempts + THRESHOLDS.look_steps * 2 ** min(self.failed, THRESHOLDS.longest_wait)

    def implicit_at(self, times: Array) -> Flags:
        """Whether the implicit method made the steps at these times, (T,)."""
        starts = np.array([switch.time for switch in self.switches])
        stiff = np.array([False, *(switch.method == WHERE_STIFF for switch in self.switches)])
        return np.asarray(stiff[np.searchsorted(starts, times, side="left")])

    def save(self) -> dict[str, Any]:
        """Return the plan as plain data."""
        return {
            "method": self.method,
            "due": self.due,
            "trial": self.trial,
            "best": self.best,
            "failed": self.failed,
            "trials": self.trials,
            "tried": self.tried,
            "since": list(self.since),
            "switches": [list(switch) for switch in self.switches],
        }

    @classmethod
    def restore(cls, saved: Mapping[str, Any]) -> Plan:
        """Return the plan that was saved. Raises ValueError for data that are no plan."""
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
            since=Since(float(time), int(steps), int(evaluations)),
            switches=switches,
        )


def methods_taken(plan: Plan) -> tuple[str, ...]:
    """Return lines on the methods that made the steps, and on the cost of trials."""
    why = f"{WHERE_STIFF} was not quicker" if plan.trials else "no force is stiff"
    lines = [_switch_line(switch) for switch in plan.switches[:MOST_TOLD]] or [f"{plan.method} throughout: {why}"]
    more = len(plan.switches) - MOST_TOLD
    if more > 0:
        lines.append(f"{more} more change{'s' * (more > 1)} of the method; {plan.method} at the end")
    if plan.trials:
        lines.append(f"{plan.trials} trial{'s' * (plan.trials > 1)} of the other method: {plan.tried} evaluations more")
    return tuple(lines)


def _switch_line(switch: Switch) -> str:
    why = f"stiff: {switch.where} (ω h = {switch.omega_h:.3g}); " if switch.where else ""
    return f"{why}{switch.method} from t = {switch.time:.4g} s on"
