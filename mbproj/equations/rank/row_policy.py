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

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.constraints import constraint, jacobian, time_derivative
from mbproj.equations.kinematics import Pose
from mbproj.equations.motions import Drive
from mbproj.equations.of_motion import HeldRows
from mbproj.equations.rank.row_space import row_distances
from mbproj.model.system import System

# --- Combinations of the rows of C_q that are held at a pose, as a function of a `RowSet` -----------------------------
# All rows are held where they are independent. Where some follow from the others, as many combinations are held as
# there are independent rows. Near a singular pose, those are held that still have a gradient. A `RowSet` is constant
# within a step: equal input gives equal bits in any order of calls. The `RowPolicy` chooses the set of a step.
# Near a singular pose a combination at the distance σ from dependence closes σ w + ½ κ w² = -c for the violation c.
# Newton's method finds the root on the motion's own branch only where c is small against σ² (Kantorovich). An
# acceleration that divides a stage's violation by σ errs without bound. Its multiplier stays finite where the motion
# goes on, so that leaving the combination out causes an error of σ at most.


@dataclass(frozen=True, eq=False)
class RowSet:
    """The data that decide which rows a step holds: the number of `redundant` rows, and whether singular poses are
    looked for (`watching`). `largest`: the largest distances from dependence so far, (m,), or (1,) with redundant rows.
    `multipliers` (m,): those of the last pose far from singular ones; rows that are left out keep theirs."""

    system: System
    redundant: int
    watching: bool
    largest: Array
    multipliers: Array

    @classmethod
    def regular(cls, system: System, redundant: int = 0) -> RowSet:
        """Return the set that holds all independent rows and does not look for singular poses."""
        largest = np.full(system.constraints if not redundant else 1, THRESHOLDS.dependent)
        return cls(system, redundant, False, largest, np.zeros(system.constraints))

    def to_close(self, pose: Pose, C: Array) -> HeldRows:
        """Return the rows that correct a position whose violation is C."""
        C_q = jacobian(self.system, pose)
        return self._held_rows(C_q, lambda sigma, weights: sigma**2 < THRESHOLDS.apart * abs(float(weights @ C)))

    def to_move(self, pose: Pose, drive: Drive, v: Array | None = None) -> HeldRows:
        """Return the rows that velocities meet at a pose; with the velocity v, those that accelerations meet."""
        C_q = jacobian(self.system, pose)
        C = rates = np.zeros(self.system.constraints)
        if self.watching:
            C = constraint(self.system, pose, drive)
        if self.watching and v is not None:
            speed = float(np.linalg.norm(in_lengths(self.system, v)))
            rates = (C_q @ v + time_derivative(self.system, drive)) / max(speed, np.finfo(float).tiny)

        def is_blind(sigma: float, weights: Array) -> bool:
            return sigma**3 < max(abs(float(weights @ C)) + abs(float(weights @ rates)), THRESHOLDS.least_violation)

        return self._held_rows(C_q, is_blind)

    def distances(self, C_q: Array) -> Array:
        """Return the distance of each row from the span of those before it, (m,); with redundant rows, of all together,
        (1,)."""
        rows, _ = self._scaled(C_q)
        if not self.redundant:
            return row_distances(rows)
        rank = len(rows) - self.redundant
        return np.asarray(np.linalg.svd(rows, compute_uv=False)[rank - 1 : rank])

    def part(self, distances: Array) -> tuple[float, float]:
        """Return the smallest distance as a part of the largest, and that largest."""
        parts = distances / self.largest
        row = int(np.argmin(parts))
        return float(parts[row]), float(self.largest[row])

    def _held_rows(self, C_q: Array, is_blind: Callable[[float, Array], bool]) -> HeldRows:
        """Return all rows where they are independent, else combinations of them."""
        if not self.redundant and not self.watching:
            return HeldRows(C_q)
        rows, factors = self._scaled(C_q)
        part, largest = 1.0, 1.0
        if not self.redundant:
            part, largest = self.part(row_distances(rows))
            if part >= THRESHOLDS.near_singular:
                return HeldRows(C_q, nearness=part)
        return self._combined(C_q, rows, factors, part, largest, is_blind)

    def _combined(
        self,
        C_q: Array,
        rows: Array,
        factors: Array,
        part: float,
        largest: float,
        is_blind: Callable[[float, Array], bool],
    ) -> HeldRows:
        """Return combinations by singular values. Near a singular pose the combinations for which `is_blind` holds are
        left out."""
        if self.redundant and self.system.rolls:
            return self._by_level(C_q, rows, factors)
        U, sigma, _ = np.linalg.svd(rows)
        rank, weights = len(rows) - self.redundant, factors[:, None] * U
        if self.redundant:
            part, largest = self.part(sigma[rank - 1 : rank])
            weights = self._smallest(weights, weights[:, rank:])
        count = rank
        while part < THRESHOLDS.near_singular and count and sigma[count - 1] < THRESHOLDS.near_singular * largest:
            if not is_blind(float(sigma[count - 1]), weights[:, count - 1]):
                break
            count -= 1
        if count == len(rows):
            return HeldRows(C_q, nearness=part)
        held = weights[:, :count] / np.median(factors)
        if count == rank:
            return HeldRows(held.T @ C_q, held, nearness=part)
        out = weights[:, count:rank]
        return HeldRows(held.T @ C_q, held, out, U[:, count:rank] / factors[:, None], out.T @ C_q, nearness=part)

    def _by_level(self, C_q: Array, rows: Array, factors: Array) -> HeldRows:
        """Return combinations of the rows at position level, and then the part of the rows at velocity level beyond
        these. A combination of both levels would leave a part of a joint open."""
        held, slow = ~self.system.is_velocity, self.system.is_velocity
        U, sigma, V = np.linalg.svd(rows[held])
        first = int(np.count_nonzero(sigma > THRESHOLDS.dependent))
        last = len(rows) - self.redundant - first
        V, inverse = V[:first], U[:, :first] / sigma[:first]
        along = rows[slow] @ V.T
        beyond = np.linalg.svd(rows[slow] - along @ V)[0]
        weights, idle = np.zeros((len(rows), first + last)), np.zeros((len(rows), self.redundant))
        back = -inverse @ along.T @ beyond
        weights[held, :first], idle[held, : U.shape[1] - first] = U[:, :first], U[:, first:]
        weights[held, first:], idle[held, U.shape[1] - first :] = back[:, :last], back[:, last:]
        weights[slow, first:], idle[slow, U.shape[1] - first :] = beyond[:, :last], beyond[:, last:]
        weights = factors[:, None] * weights / np.median(factors)
        shares = self._smallest(weights, factors[:, None] * idle)
        return HeldRows(weights.T @ C_q, weights, nearness=self.part(self.distances(C_q))[0], shares=shares)

    def _smallest(self, weights: Array, idle: Array) -> Array:
        """Return combinations (m, r) with the smallest λ of joints and motions, forces times the mechanism's length.
        The part along `idle` (m, d), which exerts no force on any body, is subtracted."""
        n = self.system.bodies
        weighed, weighed_idle = (self.system.row_scale[n:, None] * part[n:] for part in (weights, idle))
        return np.asarray(weights - idle @ np.linalg.lstsq(weighed_idle, weighed, rcond=None)[0])

    def _scaled(self, C_q: Array) -> tuple[Array, Array]:
        """Return rows of unit length, in units of the mechanism's length, and the factors that scale them."""
        rows = C_q * lengths(self.system)
        length = np.linalg.norm(rows, axis=1)
        counts = length > THRESHOLDS.dependent * self.system.row_scale
        factors = np.where(counts, 1.0 / np.maximum(length, np.finfo(float).tiny), 0.0)
        return rows * factors[:, None], factors


def lengths(system: System) -> Array:
    """Return the units of a change of q, (7n,): the mechanism's length for r, 1 for Λ."""
    return np.tile([system.length] * 3 + [1.0] * 4, system.bodies)


def in_lengths(system: System, v: Array) -> Array:
    """Return a change of q in units of the mechanism's length: r / length and Λ."""
    return v / lengths(system)


# --- The policy that chooses, from the poses passed, which rows the next step holds -----------------------------------


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
