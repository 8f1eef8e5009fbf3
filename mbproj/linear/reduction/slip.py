"""Linear equations with rows at velocity level: fewer speeds than positions.

On the tangent space N of the rows at position level, ξ = N η, rows at velocity level require A η' + H η = 0. Let Z span
null(A) and W the rest: η = Z a + W b. Then b has no inertia of its own; it follows

    b' = -E η,    E = (A W)⁻¹ H,    A W b'' = -(A' + H) η' - H' η,


and the forces along Z are those of motions without slip. Where nothing moves, b stays where it is: a wheel rests
anywhere.
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.linear.eigenvalues import ReducedEquations
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class SlipEquations:
    """A, A', H and H' on the tangent space of the rows at position level, (k, f) each."""

    A: Array
    A_dot: Array
    H: Array
    H_dot: Array

    @property
    def rank(self) -> int:
        """The number of speeds that these rows remove."""
        σ = np.linalg.svd(self.A, compute_uv=False)
        return int(np.count_nonzero(σ > THRESHOLDS.dependent * σ.max(initial=0.0)))

    def beside(self, states: int) -> SlipEquations:
        """Return the rows with zeros for so many coordinates of states after them."""
        parts = (np.pad(part, ((0, 0), (0, states))) for part in (self.A, self.A_dot, self.H, self.H_dot))
        return SlipEquations(*parts)


def without_slip(reduced: ReducedEquations, slip: SlipEquations, states: int) -> tuple[ReducedEquations, Array]:
    """Return the equations in coordinates (a, b), then the `states` of elements, which come last in both; and (η, s) by
    these, (f + K, f + K)."""
    of = slip.beside(states)
    U, σ, V = np.linalg.svd(slip.A)
    rank = slip.rank
    pad = ((0, states), (0, 0))
    W, own = np.pad(V[:rank].T, pad), np.pad(V[rank:].T, pad)
    last = np.eye(len(reduced.M))[:, len(reduced.M) - states :]
    Z = np.hstack([own, last])
    P = (U[:, :rank] / σ[:rank]).T
    E, pull = P @ of.H, Z.T @ reduced.M @ W
    D = Z.T @ reduced.D - pull @ (P @ (of.A_dot + of.H))
    K = Z.T @ reduced.K - pull @ (P @ of.H_dot) - D @ W @ E
    size = np.abs(Z).T, np.abs(pull), np.abs(P)
    D_size = size[0] @ reduced.D_size + size[1] @ (size[2] @ np.abs(of.A_dot + of.H))
    K_size = size[0] @ reduced.K_size + size[1] @ (size[2] @ np.abs(of.H_dot)) + D_size @ np.abs(W @ E)
    mass = float(np.abs(reduced.M).max(initial=0.0)) or 1.0
    back, free = np.hstack([own, W, last]), own.shape[1]
    order = np.r_[:free, free + states : free + states + rank, free : free + states]  # rows: a, b, states
    none, one = np.zeros((rank, len(back))), mass * np.linalg.pinv(W) @ back

    def arranged(upper: Array, lower: Array) -> Array:
        return np.asarray(np.concatenate([upper, lower])[order], dtype=float)

    M = np.hstack([Z.T @ reduced.M @ own, np.zeros_like(pull), Z.T @ reduced.M @ last])
    moved = reduced.weighs @ _except(back, free, rank)
    follows = np.zeros((rank, len(back)))
    follows[:, free : free + rank] = np.eye(rank)
    without = ReducedEquations(
        arranged(M, none),
        arranged(D @ _except(back, free, rank), one),
        arranged(K @ back, mass * E @ back),
        arranged(D_size @ np.abs(back), np.abs(one)),
        arranged(K_size @ np.abs(back), mass * np.abs(E) @ np.abs(back)),
        np.concatenate([moved, follows]),
        chains=True,
    )
    return without, back


def _except(back: Array, first: int, count: int) -> Array:
    """Return a matrix with 0 in the columns of the coordinates b."""
    found = back.copy()
    found[:, first : first + count] = 0.0
    return found
