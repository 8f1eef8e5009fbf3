"""The policy that chooses, from the poses passed, which rows the next step holds. It also judges whether a pose is near
a singular one.

The loop owns one policy. Within a step its `rows` do not change; it only records how near the poses of the step are to
singular ones (`see`). Between steps `advance` sets the rows of the next step. `save` and `restore` carry the policy
from one run to the next.

This is the reference. The kernel's policy of the same name decides by pivots of S: squares of distances in the metric
of the masses. It leaves out single rows; this one leaves out combinations. Near a singular pose both err by the
distance σ of the rows or combinations left out, so that they may differ by σ. The kernel chooses single rows, and
chooses others where a step fails. Combinations leave no such choice.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.rank.row_set import RowSet
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


class RowPolicy:
    """The policy of one run. Without redundant rows, and away from singular poses, it costs one QR decomposition a
    step."""

    def __init__(self, system: System, redundant: int = 0) -> None:
        self.rows = replace(RowSet.regular(system, redundant), watching=True)
        #: The smallest distance of the poses of the current step, as a part of the largest.
        self.nearest = 1.0
        self._before: float | None = None

    def begin(self) -> None:
        """Begin a step from the last accepted state: poses of a rejected step do not count."""
        self.nearest = 1.0 if self._before is None else self._before

    def see(self, nearness: float) -> None:
        """Record the distance of a pose of the current step."""
        self.nearest = min(self.nearest, nearness)

    def advance(self, C_q: Array) -> float:
        """Set the rows of the next step after one that was accepted at a pose with this C_q. Return the smallest
        distance in the step, as a part of the largest."""
        distances = self.rows.distances(C_q)
        rows = replace(self.rows, largest=np.maximum(self.rows.largest, distances))
        here = rows.part(distances)[0]
        fall = 0.0 if self._before is None else abs(here - self._before)
        passed, self.nearest, self._before = min(self.nearest, here), here, here
        self.rows = replace(rows, watching=here - fall < THRESHOLDS.near_singular)
        return passed

    def keep(self, multipliers: Array) -> None:
        """Keep λ (m,) of the accepted state for rows that are left out later, unless the state is near a singular
        pose."""
        if self.nearest >= THRESHOLDS.close_to_singular:
            self.rows = replace(self.rows, multipliers=multipliers)

    def save(self) -> dict[str, Any]:
        """Return the state of the policy as plain data."""
        return {
            "redundant": self.rows.redundant,
            "watching": self.rows.watching,
            "largest": self.rows.largest.tolist(),
            "multipliers": self.rows.multipliers.tolist(),
            "before": self._before,
        }

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Continue from the state that was saved between two steps."""
        self.rows = RowSet(
            self.rows.system,
            int(saved["redundant"]),
            bool(saved["watching"]),
            np.array(saved["largest"], dtype=float),
            np.array(saved["multipliers"], dtype=float),
        )
        self._before = None if saved["before"] is None else float(saved["before"])
        self.begin()
