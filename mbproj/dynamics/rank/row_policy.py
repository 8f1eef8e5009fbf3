"""Which rows the next step holds, and whether a pose is near a singular one: what a run remembers of the poses passed.

The loop owns one policy. Within a step its answer, the `rows`, does not change; it only takes note of how near the
poses of the step come to singular ones (`see`). Between steps `after` makes the next answer. `save` and `restore` carry
it from one run to the next.

This is the reference. The kernel's policy of the same name decides by pivots of S: squares of distances in the metric
of the masses. It leaves out single rows, this one combinations: near a singular pose both err by the distance σ of what
is left out, and so may differ by that. It chooses the rows it holds, and may choose others where a step cannot be made
with them; combinations need no choice.
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
    """State of a run. Without redundant rows, and away from singular poses, it costs one QR a step."""

    def __init__(self, system: System, redundant: int = 0) -> None:
        self.rows = replace(RowSet.regular(system, redundant), watching=True)
        #: The smallest distance of the poses of the step at hand, as a part of the largest.
        self.nearest = 1.0
        self._before: float | None = None

    def begin(self) -> None:
        """A step is tried from the last accepted state: what a rejected one has passed does not count."""
        self.nearest = 1.0 if self._before is None else self._before

    def see(self, nearness: float) -> None:
        """Takes note of a pose of the step at hand."""
        self.nearest = min(self.nearest, nearness)

    def after(self, C_q: Array) -> float:
        """The step is accepted at a pose with this C_q: makes the rows of the next one. The smallest distance on the
        way there, as a part of the largest."""
        distances = self.rows.distances(C_q)
        rows = replace(self.rows, largest=np.maximum(self.rows.largest, distances))
        here = rows.part(distances)[0]
        fall = 0.0 if self._before is None else THRESHOLDS.look_ahead * abs(here - self._before)
        passed, self.nearest, self._before = min(self.nearest, here), here, here
        self.rows = replace(rows, watching=here - fall < THRESHOLDS.near_singular)
        return passed

    def keep(self, multipliers: Array) -> None:
        """λ (m,) of the accepted state, which rows that are left out later keep, unless it is near a singular pose."""
        if self.nearest >= THRESHOLDS.close_to_singular:
            self.rows = replace(self.rows, multipliers=multipliers)

    def save(self) -> dict[str, Any]:
        """All that the next answers depend on, as plain data."""
        return {
            "redundant": self.rows.redundant,
            "watching": self.rows.watching,
            "largest": self.rows.largest.tolist(),
            "multipliers": self.rows.multipliers.tolist(),
            "before": self._before,
        }

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Goes on from what was saved between two steps."""
        self.rows = RowSet(
            self.rows.system,
            int(saved["redundant"]),
            bool(saved["watching"]),
            np.array(saved["largest"], dtype=float),
            np.array(saved["multipliers"], dtype=float),
        )
        self._before = None if saved["before"] is None else float(saved["before"])
        self.begin()
