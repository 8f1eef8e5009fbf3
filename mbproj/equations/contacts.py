"""The free motions that the joints leave at a pose, in coordinates x, and the rows N of the stops' gaps by x.

In x the kinetic energy is ½|x|²: u = u₀ + T R⁻¹ x, with G T = 0 and TᵀM T = RᵀR."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.derivatives.tangent_space import tangent_space
from mbproj.dynamics.equations.constraint_equations import tangent_jacobian
from mbproj.dynamics.equations.equations_of_motion import tangent_mass_matrix
from mbproj.dynamics.equations.kinematics import Pose, Twist, pose_of, twist_of
from mbproj.errors import SimulationError
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.stops import Stops
from mbproj.model.system import System


@dataclass(frozen=True, eq=False)
class Freedom:
    """The freedom of a mechanism at a state: `basis` T R⁻¹ (6n, f), and the pose and twist it belongs to."""

    system: System
    state: State
    pose: Pose
    twist: Twist
    M: Array
    G: Array
    basis: Array
    smallest: Array  # G⁺ (6n, m)

    @classmethod
    def at(cls, system: System, state: State) -> Freedom:
        """Return the freedom at a state. Raises SimulationError where a free motion has no inertia."""
        pose = pose_of(state.q)
        M, G = tangent_mass_matrix(system, pose), _in_bodies(system.rows, pose)
        space = tangent_space(system, G)
        try:
            R = np.linalg.cholesky(space.N.T @ M @ space.N).T
        except np.linalg.LinAlgError as error:
            cause = "a stop meets a motion without inertia: no impulse is finite there"
            raise SimulationError(state.t, cause, hint="give its bodies mass and inertia") from error
        basis = np.linalg.solve(R.T, space.N.T).T
        return cls(system, state, pose, twist_of(pose, state.v), M, G, basis, space.pseudoinverse)

    def rows(self, stops: Stops) -> Array:
        """Return N (S, f): g' = N x for the gaps, apart from the part that motions drive."""
        return np.asarray(stops.side[:, None] * _in_bodies(stops.coordinates, self.pose) @ self.basis)

    def multipliers_of(self, gradients: Array) -> Array:
        """Return the smallest multipliers λ (k, m) caused by a unit force along each coordinate, with `gradients` (k,
        6n)."""
        left = gradients - (gradients @ self.basis) @ (self.M @ self.basis).T
        return np.asarray(left @ self.smallest)

    def gradients_of(self, along: PrimitiveSet) -> Array:
        """Return ∂s/∂(δr, δθ) of coordinates, (k, 6n)."""
        return _in_bodies(along, self.pose)


def _in_bodies(bound: PrimitiveSet, pose: Pose) -> Array:
    """Return the derivatives of a set's values by (δr, δθ), (m, 6n)."""
    return np.ascontiguousarray(tangent_jacobian(bound, pose)[:, :-1, :6]).reshape(
        bound.size, 6 * (len(pose.position) - 1)
    )
