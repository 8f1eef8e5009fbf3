"""Independent combinations of the rows of C_q, in which the equations of motion and of every projection are solved."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass


@dataclass(frozen=True, eq=False)
class HeldRows:
    """Rows that are independent: `C_q` (r, 7n), combinations of all rows by `weights` (m, r), or all as they are, None.

    Near a singular pose some combinations are not held: `left_out` (m, k), with the rows `weak` (k, 7n) that they make
    of C_q, and `unseen` (m, k), what the rows held do not see of a violation for each. `nearness`: the distance from
    dependence, as a part of the largest of the run; 1 where nobody has looked. `shares` (m, r): how much of the
    multiplier of a row held each row bears, where that is not as the `weights`."""

    C_q: Array
    weights: Array | None = None
    left_out: Array | None = None
    unseen: Array | None = None
    weak: Array | None = None
    nearness: float = 1.0
    shares: Array | None = None

    def combined(self, rows: Array) -> Array:
        """γ, C or C' (m,) of the rows held, (r,)."""
        return rows if self.weights is None else self.weights.T @ rows

    def multipliers(self, held: Array) -> Array:
        """λ (m,) from that of the rows held, (r,): the smallest where rows are redundant."""
        shares = self.weights if self.shares is None else self.shares
        return held if shares is None else shares @ held

    def lasting(self, multipliers: Array) -> tuple[Array, Array]:
        """Of multipliers λ (m,) what is of the combinations left out, and the force -C_qᵀλ of that, (7n,)."""
        if self.left_out is None or self.unseen is None or self.weak is None:
            return np.zeros_like(multipliers), np.zeros(self.C_q.shape[1])
        share = self.unseen.T @ multipliers
        return self.left_out @ share, -(self.weak.T @ share)

    def closes(self, rows: Array) -> Array:
        """The part of a violation (m,) that the rows held can close."""
        if self.left_out is None or self.unseen is None:
            return rows
        return rows - self.unseen @ (self.left_out.T @ rows)

    def open(self, rows: Array) -> float:
        """The largest violation of what is left out, in the mechanism's own lengths."""
        return 0.0 if self.left_out is None else float(np.abs(self.left_out.T @ rows).max(initial=0.0))
