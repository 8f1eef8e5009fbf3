"""The linear model of a mechanism that rolls: displacements a and speeds a' of motions without slip, and further
displacements b.

With ξ = N (Z a + W b) as in `reduction/projected.py` and forces F u along the bodies,

    M a'' + D a' + K (a, b) = (N Z)ᵀ F u,      b' = -E (Z a + W b).
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem
from mbproj.linear.eigenvalues import heavy_and_light
from mbproj.linear.reduction.projected import Projected
from mbproj.model.system import System


@dataclass(frozen=True, eq=False)
class RollingStates:
    """x' = A x + B u of x = (a, a', b), with the displacements (6n, x) and rates (6n, x) that belong to x. `free`: the
    number of coordinates a."""

    A: Array
    B: Array
    displacement: Array
    rate: Array
    free: int


def rolling_states(here: Projected, force: Array) -> RollingStates:
    """Return the model for forces (6n, p) on the bodies, in the axes of the equations. Raises InputError where a motion
    has no mass."""
    reduced, back = here.solvable(np.zeros(0))
    free, N = here.freedom, here.space.N
    M, D, K = reduced.M[:free, :free], reduced.D[:free, :free], reduced.K[:free]
    if heavy_and_light(here.reduced)[1].size:
        said = "a rolling motion moves no mass, which this linear model does not cover"
        raise InputError(Problem(said, hint="give the moving bodies mass; `mbproj modes` needs none"))
    rest = len(reduced.M) - free
    follows = np.asarray(-np.linalg.solve(reduced.D[free:, free:], reduced.K[free:]), dtype=float)  # b' by (a, b)
    pull = np.linalg.solve(M, np.hstack([K, D, (N @ back[:, :free]).T @ force]))
    size = 2 * free + rest
    A, B = np.zeros((size, size)), np.zeros((size, force.shape[1]))
    A[:free, free : 2 * free] = np.eye(free)
    A[free : 2 * free] = -_placed(pull[:, : free + rest], free)
    A[free : 2 * free, free : 2 * free] -= pull[:, free + rest : 2 * free + rest]
    A[2 * free :] = _placed(follows, free)
    B[free : 2 * free] = pull[:, 2 * free + rest :]
    moved = N @ back
    displacement = _placed(moved, free)
    rate = moved[:, free:] @ A[2 * free :]
    rate[:, free : 2 * free] += moved[:, :free]
    return RollingStates(A, B, displacement, rate, free)


def _placed(of: Array, free: int) -> Array:
    """Return columns for (a, b) as columns for (a, a', b)."""
    return np.hstack([of[:, :free], np.zeros((len(of), free)), of[:, free:]])


def refuse_beside_rolling(system: System, asks_reactions: bool) -> None:
    """Raise InputError for parts that this model lacks: states of elements, motions and reactions."""
    reasons = {
        "states of elements": system.states.size,
        "motions": system.driven,
        "reactions as outputs": asks_reactions,
    }
    for what, has in reasons.items():
        if has:
            joint = int(system.joints.owner[np.argmax(system.joints.is_velocity)])
            said = f"joint '{system.names.joints[joint]}' rolls, and linear models of what rolls have no {what}"
            raise InputError(Problem(said, system.joint_places[joint], "`mbproj modes` knows them; or leave them out"))
