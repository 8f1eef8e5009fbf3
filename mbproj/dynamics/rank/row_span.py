"""Which combinations of the rows of C_q a run holds: all rows where they are independent, as many combinations as there
are independent rows where some follow from the others, and near a singular pose those that still have a gradient.

Near such a pose a combination at the distance σ from dependence closes σ w + ½ κ w² = -c for the violation c: Newton's
method finds the root of the branch that the motion is on only where c is small against σ² (Kantorovich), and an
acceleration that divides what a stage violates by σ errs without bound. Its multiplier stays finite where the motion
goes on, so that leaving the combination out errs by σ at most.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.equations.constraint_equations import constraint, jacobian, time_derivative
from mbproj.dynamics.equations.held_rows import Held
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.dynamics.equations.motions import Drive
from mbproj.dynamics.rank.row_space import row_distances
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


class RowSpan:
    """Scratch of a run: how many rows are redundant, the largest distances so far, and whether the pose is near to a
    singular one. Without redundant rows, and away from singular poses, it costs nothing but one QR a step."""

    def __init__(self, system: System, redundant: int = 0, watching: bool = True) -> None:
        self.system, self.redundant = system, redundant
        self.watching = watching
        #: The smallest distance since the last point, as a part of the largest.
        self.nearest = 1.0
        self._largest = np.full(system.constraints if not redundant else 1, THRESHOLDS.dependent)
        self._before: float | None = None
        #: λ of the last pose that was not near to a singular one.
        self.multipliers = np.zeros(system.constraints)
        lengths = np.tile([system.length] * 3 + [1.0] * 4, system.bodies)
        self._lengths, self._row_scale = lengths, system.row_scale

    def arrive(self, C_q: Array) -> float:
        """Takes note of an accepted state, and whether the next step is to be looked at closely; the smallest distance
        since the last one, as a part of the largest."""
        distances = self._distances(*self._scaled(C_q))
        self._largest = np.maximum(self._largest, distances)
        here = self._part(distances)[0]
        fall = 0.0 if self._before is None else THRESHOLDS.look_ahead * abs(here - self._before)
        passed, self.nearest, self._before = min(self.nearest, here), here, here
        self.watching = here - fall < THRESHOLDS.near_singular
        return passed

    def to_close(self, pose: Pose, C: Array) -> Held:
        """The rows that correct a position which violates them by C."""
        C_q = jacobian(self.system, pose)
        return self._held(C_q, lambda sigma, weights: sigma**2 < THRESHOLDS.apart * abs(float(weights @ C)))

    def to_move(self, pose: Pose, drive: Drive | None, v: Array | None = None) -> Held:
        """The rows that velocities are to meet at a pose, or accelerations, where the velocity v counts as well."""
        C_q = jacobian(self.system, pose)
        C = rates = np.zeros(self.system.constraints)
        if self.watching:
            C = constraint(self.system, pose, drive)
        if self.watching and v is not None:
            speed = float(np.linalg.norm(self.in_lengths(v)))
            rates = (C_q @ v + time_derivative(self.system, drive)) / max(speed, np.finfo(float).tiny)

        def is_blind(sigma: float, weights: Array) -> bool:
            return sigma**3 < max(abs(float(weights @ C)) + abs(float(weights @ rates)), THRESHOLDS.least_violation)

        return self._held(C_q, is_blind)

    def _held(self, C_q: Array, is_blind: Callable[[float, Array], bool]) -> Held:
        """All rows where they are independent, or combinations by singular values, of which those are left out near a
        singular pose that are blind."""
        if not self.redundant and not self.watching:
            return Held(C_q)
        rows, factors = self._scaled(C_q)
        if not self.redundant:
            part, largest = self._part(row_distances(rows))
            self.nearest = min(self.nearest, part)
            if part >= THRESHOLDS.near_singular:
                return Held(C_q)
        U, sigma, _ = np.linalg.svd(rows)
        rank, weights = len(rows) - self.redundant, factors[:, None] * U
        if self.redundant:
            part, largest = self._part(sigma[rank - 1 : rank])
            self.nearest = min(self.nearest, part)
            # The smallest λ of joints and motions, forces times the mechanism's length: less what acts on no body.
            n, idle = self.system.bodies, weights[:, rank:]
            weighed = self._row_scale[n:, None] * weights[n:]
            weights = weights - idle @ np.linalg.lstsq(weighed[:, rank:], weighed, rcond=None)[0]
        kept = rank
        while part < THRESHOLDS.near_singular and kept and sigma[kept - 1] < THRESHOLDS.near_singular * largest:
            if not is_blind(float(sigma[kept - 1]), weights[:, kept - 1]):
                break
            kept -= 1
        if kept == len(rows):
            return Held(C_q)
        held = weights[:, :kept] / np.median(factors)
        if kept == rank:
            return Held(held.T @ C_q, held)
        out = weights[:, kept:rank]
        return Held(held.T @ C_q, held, out, U[:, kept:rank] / factors[:, None], out.T @ C_q)

    def in_lengths(self, v: Array) -> Array:
        """A change of q with the mechanism's own lengths as unit: r / length and Λ."""
        return v / self._lengths

    def _scaled(self, C_q: Array) -> tuple[Array, Array]:
        """Rows of unit length, and the factors that make them so."""
        rows = C_q * self._lengths
        length = np.linalg.norm(rows, axis=1)
        factors = np.where(
            length > THRESHOLDS.dependent * self._row_scale, 1.0 / np.maximum(length, np.finfo(float).tiny), 0.0
        )
        return rows * factors[:, None], factors

    def _distances(self, rows: Array, factors: Array) -> Array:
        if not self.redundant:
            return row_distances(rows)
        rank = len(rows) - self.redundant
        return np.asarray(np.linalg.svd(rows, compute_uv=False)[rank - 1 : rank])

    def _part(self, distances: Array) -> tuple[float, float]:
        """The smallest distance, as a part of the largest, and that."""
        parts = distances / self._largest
        row = int(np.argmin(parts))
        return float(parts[row]), float(self._largest[row])
