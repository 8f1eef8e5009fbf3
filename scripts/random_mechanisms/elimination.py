"""What the kernel's elimination may lose beyond the round-off of the equations themselves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj import System
from mbproj.base.arrays import Array
from mbproj.equations.constraints import jacobian
from mbproj.equations.kinematics import pose_of
from mbproj.equations.of_motion import mass_matrix
from mbproj.motion.formulations.full import Accelerations

from .round_off import RoundOff

EPSILON = float(np.finfo(float).eps)
#: A pivot of G M⁻¹Gᵀ below this part of its entry has the kernel refine its solution.
REFINED = 1e-4


def in_the_kernel(system: System, q: Array, found: Accelerations, limit: RoundOff) -> RoundOff:
    """The round-off of the kernel's solution at a pose, from that of the equations, whose solution is `found`.

    - Down to pivots of `REFINED`, which are not refined, each row may add ε / `REFINED` to the relative error of λ. The
      error acts on each body over the body's own inertia. The full formulation, which is held against it, knows
      accelerations to ε of the largest, and λ of heavy bodies from them: to ε × the ratio of the masses.
    - What hangs on a body is added to its inertia (articulated bodies), so that a light one knows its own to ε of the
      heavy one's only: its acceleration to ε × their ratio. Beyond 1e8 neither is eliminated
      (inertia_cancellation.hpp).
    """
    n, pose = system.bodies, pose_of(q)
    M, C_q = mass_matrix(system, pose), np.abs(jacobian(system, pose)[system.bodies :])
    scale = system.row_scale[n:]
    spread = _spread(system)
    lost = len(scale) * EPSILON * max(1.0 / REFINED, spread)
    pull = lost * np.abs(found.multipliers[n:] * scale).max(initial=0.0) / scale
    load = (C_q.T @ pull).reshape(-1, 7)
    lightest = np.linalg.eigvalsh(np.array([M[at + 3 : at + 7, at + 3 : at + 7] for at in range(0, 7 * n, 7)]))[:, 1]
    moved = np.column_stack(
        [
            np.repeat(load[:, :3].max(axis=1) / system.mass, 3).reshape(-1, 3),
            np.repeat(load[:, 3:].max(axis=1) / lightest, 4).reshape(-1, 4),
        ]
    )
    largest = np.abs(found.acceleration).reshape(-1, 7).max(axis=1, keepdims=True)
    moved += EPSILON * spread * largest
    return replace(
        limit,
        acceleration=limit.acceleration + moved.ravel(),
        multipliers=limit.multipliers + pull,
        load=limit.load + load.ravel(),
    )


def _spread(system: System) -> float:
    """The largest inertia of all bodies, in translation or rotation, over the smallest."""
    moments = np.linalg.eigvalsh(system.inertia)
    inertia = np.concatenate([system.mass[:, None] * system.length**2, moments], axis=1)
    return float(inertia.max() / inertia.min())
