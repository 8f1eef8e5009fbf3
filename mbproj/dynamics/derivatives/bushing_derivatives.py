"""The derivatives of the forces of bushings. With f = gᵀF, F = preload - k s - c s', g the gradients of the
coordinates, and the damping c along them, which depends on the pose,

    δf = -gᵀ k g ξ - gᵀ c (g ξ' + g' ξ) - gᵀ (∂c/∂ξ s') ξ + ∂(gᵀF)/∂ξ, the last with F held,


where g' and the derivatives of g and c are complex steps, exact to round-off (Squire and Trapp 1998).
"""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Numbers
from mbproj.dataclass import dataclass
from mbproj.dynamics.blocks import Blocks
from mbproj.dynamics.derivatives.row_derivatives import COMPLEX_STEP
from mbproj.dynamics.equations.bushings import Deflection, deflected, rates, viscous
from mbproj.dynamics.equations.kinematics import Pose, Twist
from mbproj.model.euler_parameters import matrix_L, rotation_matrix
from mbproj.model.forces import COORDINATES, Bushings, Forces


@dataclass(frozen=True, eq=False)
class _BushingBodies:
    """Positions (B, 2, 3) and Euler parameters (B, 2, 4) of the two bodies of each bushing."""

    bushings: Bushings
    position: Array
    orientation: Array

    @classmethod
    def pose(cls, bushings: Bushings, pose: Pose) -> _BushingBodies:
        return cls(bushings, pose.position[bushings.body], pose.orientation[bushings.body])

    def deflect(self, shift: Numbers, turn: Numbers) -> tuple[Deflection, Numbers]:
        """Return the deflection at changed positions and Euler parameters, and g (..., B, 6, 12) by (δr, δθ in body
        axes) of both bodies."""
        orientation = self.orientation + turn
        deflection = deflected(self.bushings, self.position + shift, orientation)
        size = np.sum(orientation * orientation, axis=-1)[..., None, None]
        in_body = deflection.gradient[..., 3:] @ (rotation_matrix(orientation) / size)
        sides = np.concatenate([deflection.gradient[..., :3], in_body], axis=-1)
        return deflection, np.concatenate([sides[..., 0, :, :], sides[..., 1, :, :]], axis=-1)


def bushing_gradient(bushings: Bushings, pose: Pose) -> Array:
    """Return g (B, 6, 12): s' = g (r', ω) of both bodies."""
    return _at_pose(bushings, pose)[1]


def bushing_derivatives(forces: Forces, pose: Pose, twist: Twist, force: Array) -> tuple[Blocks, Blocks]:
    """Return the parts of D and K that come from bushings. `force` (F,) are the forces along all coordinates; those of
    bushings come last."""
    bushings, at = forces.bushings, _BushingBodies.pose(forces.bushings, pose)
    count = bushings.size
    deflection, g = _at_pose(bushings, pose)
    rate, damping = rates(bushings, deflection, pose, twist), viscous(bushings, deflection)
    moving = 1j * COMPLEX_STEP * twist.velocity[bushings.body], 1j * COMPLEX_STEP * twist.rate[bushings.body]
    g_dot = at.deflect(*moving)[1].imag / COMPLEX_STEP
    steps = 1j * COMPLEX_STEP * np.eye(12).reshape(12, 1, 2, 6)  # of the first body, then of the second
    turns = 0.5 * (np.swapaxes(matrix_L(at.orientation), -1, -2) @ steps[..., 3:, None])[..., 0]
    moved, bent = at.deflect(steps[..., :3], turns)  # bent (12, B, 6, 12)
    own = force[forces.laws.size :].reshape(count, len(COORDINATES))
    geometric = np.einsum("ebcu,bc->bue", bent.imag / COMPLEX_STEP, own)
    thicker = np.einsum("ebcd,bd->bce", viscous(bushings, moved).imag / COMPLEX_STEP, rate)
    transposed = np.swapaxes(g, -1, -2)
    D = transposed @ damping @ g
    K = transposed @ (bushings.stiffness @ g + damping @ g_dot + thicker) - geometric
    return _blocks(bushings, len(pose.position) - 1, D), _blocks(bushings, len(pose.position) - 1, K)


def _at_pose(bushings: Bushings, pose: Pose) -> tuple[Deflection, Array]:
    return _BushingBodies.pose(bushings, pose).deflect(np.zeros(3), np.zeros(4))


def _blocks(bushings: Bushings, bodies: int, matrices: Array) -> Blocks:
    """Return the matrices (B, 12, 12) over the two bodies of each bushing as blocks."""
    value = matrices.reshape(-1, 2, 6, 2, 6).swapaxes(2, 3).reshape(-1, 6, 6)
    row, column = np.repeat(bushings.body, 2, axis=1).ravel(), np.tile(bushings.body, 2).ravel()
    return Blocks.of(bodies, row, column, value)
