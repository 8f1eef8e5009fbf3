"""Independent combinations of the rows of C_q, in which the equations of motion and of every projection are solved."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass


@dataclass(frozen=True, eq=False)
class HeldRows:
    """Independent rows `C_q` (r, 7n): combinations of all rows by `weights` (m, r), or all rows themselves for None.

    Near a singular pose some combinations are not held. `left_out` (m, k) are the weights of these combinations and
    `weak` (k, 7n) their rows of C_q. `unseen` (m, k): for each of them a violation that the held rows cannot detect.
    `nearness`: the distance from dependence divided by the largest one in the run; 1 where it was not measured.
    `shares` (m, r): the part of the multiplier of a held row that each row bears, where that differs from `weights`."""

    C_q: Array
    weights: Array | None = None
    left_out: Array | None = None
    unseen: Array | None = None
    weak: Array | None = None
    nearness: float = 1.0
    shares: Array | None = None

    def combined(self, rows: Array) -> Array:
        """Return γ, C or C' of the held rows, (r,), from those of all rows (m,)."""
        return rows if self.weights is None else self.weights.T @ rows

    def multipliers(self, held: Array) -> Array:
        """Return λ (m,) of all rows from the multipliers of the held rows, (r,): the smallest λ where rows are
        redundant."""
        shares = self.weights if self.shares is None else self.shares
        return held if shares is None else shares @ held

    def lasting(self, multipliers: Array) -> tuple[Array, Array]:
        """Return the part of the multipliers λ (m,) that belongs to combinations left out, and its force -C_qᵀλ,
        (7n,)."""
        if self.left_out is None or self.unseen is None or self.weak is None:
            return np.zeros_like(multipliers), np.zeros(self.C_q.shape[1])
        share = self.unseen.T @ multipliers
        return self.left_out @ share, -(self.weak.T @ share)

    def closes(self, rows: Array) -> Array:
        """Return the part of a violation (m,) that the held rows can close."""
        if self.left_out is None or self.unseen is None:
            return rows
        return rows - self.unseen @ (self.left_out.T @ rows)

    def open(self, rows: Array) -> float:
        """Return the largest violation of the combinations left out, in units of the mechanism's length."""
        return 0.0 if self.left_out is None else float(np.abs(self.left_out.T @ rows).max(initial=0.0))
