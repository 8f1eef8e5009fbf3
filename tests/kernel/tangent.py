"""Rows of the full formulation in tangent coordinates, as the reduced one has them."""

from __future__ import annotations

import numpy as np

from mbproj.base.arrays import Array
from mbproj.equations.constraints import jacobian
from mbproj.equations.kinematics import pose_of
from mbproj.model.euler_parameters import matrix_E
from mbproj.model.system import System


def tangent_jacobian(system: System, q: Array) -> Array:
    """G of the joints' rows in (δr, δθ global), (m, n, 6): C_Λ = 2 G_θ E at unit Λ, but for the radial part."""
    C_q = jacobian(system, pose_of(q))[system.bodies :].reshape(-1, system.bodies, 7)
    turning = 0.5 * np.einsum("mnp,nip->mni", C_q[..., 3:], matrix_E(q.reshape(-1, 7)[:, 3:]))
    return np.concatenate([C_q[..., :3], turning], axis=-1)
