"""Passes of fixed steps over switches from which the motion is pushed back, at which no step can end."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj.integrate.events.law_switches import LawSwitches
from mbproj.integrate.loop.run import Run
from mbproj.integrate.point import Point
from mbproj.integrate.reporting.tally import Passed


class Passes:
    """Scratch of a run: the switches that are passed over, and their branches at the end of the last step, as far as
    they are known."""

    def __init__(self, run: Run, switches: LawSwitches) -> None:
        self._run, self._switches = run, switches
        self._branches = switches.free
        self._passed: dict[int, Passed] = {}

    @property
    def which(self) -> npt.NDArray[np.bool_]:
        """Whether each switch is passed over, (K,)."""
        return np.isin(np.arange(self._switches.size), list(self._passed))

    def give_up(self, k: int, t: float) -> None:
        """Pass over a switch from a time on."""
        self._passed[k] = Passed(self._switches.owner(k), self._switches.what(k), t, 1)
        self._run.tally.passed = list(self._passed.values())

    def watch(self, point: Point) -> None:
        """Record the branches at a point."""
        if not self._passed:
            return
        switches, free = self._switches, self._switches.free
        now = switches.settled(free, self._run.inside.arguments(switches, free, point.t, point.y))
        for k, found in self._passed.items():
            before, after = self._branches[switches.at[k]], now[switches.at[k]]
            if before != after and not np.isnan(before) and not np.isnan(after):
                self._passed[k] = replace(found, times=found.times + 1)
        self._branches = np.where(np.isnan(now), self._branches, now)
        self._run.tally.passed = list(self._passed.values())

    def save(self) -> dict[str, Any]:
        """Return the data on which the next call depends, as plain data."""
        passed = {str(k): list(astuple(each)) for k, each in self._passed.items()}
        return {"branches": self._branches.tolist(), "passed": passed}

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Continue from saved data."""
        self._branches = np.array(saved["branches"], dtype=float)
        self._passed = {int(k): Passed(*each) for k, each in saved["passed"].items()}
