"""What fixed steps pass over: switches of laws that change their branch between two steps, not at the end of one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, replace
from typing import Any

import numpy as np

from mbproj.integrate.events.law_switches import LawSwitches
from mbproj.integrate.loop.run import Run
from mbproj.integrate.outcome.tally import Passed
from mbproj.integrate.point import Point


class Passes:
    """Scratch of a run: the branches at the last step's end, as far as they are told, and what was passed over."""

    def __init__(self, run: Run, switches: LawSwitches) -> None:
        self._run, self._switches = run, switches
        self._branches = switches.free
        self._passed: dict[int, Passed] = {}

    def watch(self, point: Point) -> None:
        """Takes note of the branches at a point."""
        switches, free = self._switches, self._switches.free
        now = switches.settled(free, self._run.inside.arguments(switches, free, point.t, point.y))
        for k, at in enumerate(switches.at):
            before, after = self._branches[at], now[at]
            if before != after and not np.isnan(before) and not np.isnan(after):
                found = self._passed.get(k, Passed(switches.owner(k), switches.what(k), point.t, 0))
                self._passed[k] = replace(found, times=found.times + 1)
        self._branches = np.where(np.isnan(now), self._branches, now)
        self._run.tally.passed = list(self._passed.values())

    def save(self) -> dict[str, Any]:
        """All that the next call depends on, as plain data."""
        passed = {str(k): list(astuple(each)) for k, each in self._passed.items()}
        return {"branches": self._branches.tolist(), "passed": passed}

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Goes on from what was saved."""
        self._branches = np.array(saved["branches"], dtype=float)
        self._passed = {int(k): Passed(*each) for k, each in saved["passed"].items()}
