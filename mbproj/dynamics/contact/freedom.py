"""The freedom that the joints leave at a pose, and the rows N of the gaps of stops in its coordinates x.

In x the kinetic energy is ½|x|²: u = u₀ + T R⁻¹ x, with G T = 0 and TᵀM T = RᵀR."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State, coordinate_values
from mbproj.dynamics.derivatives.linear_equations import MotionAtTime, tangent_force
from mbproj.dynamics.derivatives.tangent import tangent_velocities, velocities
from mbproj.dynamics.derivatives.tangent_space import tangent_space
from mbproj.dynamics.equations.constraint_equations import set_bias, set_jacobian, tangent_jacobian
from mbproj.dynamics.equations.equations_of_motion import tangent_mass_matrix
from mbproj.dynamics.equations.kinematics import Pose, Twist, pose_of, twist_of
from mbproj.dynamics.equations.motions import drive_at
from mbproj.dynamics.rank.right_hand_sides import tangent_gamma
from mbproj.errors import SimulationError
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.stops import Stops
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class Free:
    """A motion without contacts: u' (6n,), and the multipliers λ (m,) of the joints' and motions' rows."""

    change: Array
    multipliers: Array


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
        M, G = tangent_mass_matrix(system, pose), _rows(system, pose)
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
        return np.asarray(_gradients(stops, self.pose) @ self.basis)

    def changed(self, x: Array) -> Array:
        """Return the change of q', (7n,), by x (f,)."""
        return velocities(self.pose, self.basis @ x)

    def gained(self, x: Array) -> float:
        """Return the increase of kinetic energy by x, in J."""
        change = self.basis @ x
        return float(change @ self.M @ (tangent_velocities(self.pose, self.state.v) + 0.5 * change))

    def free(self, counted: Array) -> Free:
        """Return the motion without stops and dry friction; `counted` (nc,) are the joints' coordinates with turns."""
        drive = drive_at(self.system, self.state.t)
        particular = self.smallest @ tangent_gamma(self.system, self.pose, self.twist, drive)
        force = tangent_force(self.system, self._moving(particular, counted))
        change = particular + self.basis @ (self.basis.T @ force)
        return Free(change, self._multipliers(tangent_force(self.system, self._moving(change, counted))))

    def gap_accelerations(self, stops: Stops, free: Free) -> Array:
        """Return g'' of the gaps (S,) where no stop acts; values within round-off of the whole motion are 0."""
        bias = stops.side * _bias(stops.coordinates, self.pose, self.twist)
        accelerations = _gradients(stops, self.pose) @ free.change + bias
        none = self.round_off(free) * np.linalg.norm(self.rows(stops), axis=1)
        return np.asarray(np.where(np.abs(accelerations) <= none, 0.0, accelerations))

    def round_off(self, free: Free) -> float:
        """Return the round-off of x'', √J/kg. Along a row N the round-off is at most |N| times this."""
        return float(THRESHOLDS.no_push * np.sqrt(free.change @ self.M @ free.change))

    def gap_gradients(self, stops: Stops) -> Array:
        """Return ∂g/∂(δr, δθ) of the gaps, (S, 6n)."""
        return _gradients(stops, self.pose)

    def rows_of(self, along: PrimitiveSet) -> Array:
        """Return the rows N (k, f) of coordinates, s' = N x."""
        return np.asarray(_in_bodies(along, self.pose) @ self.basis)

    def accelerations_of(self, along: PrimitiveSet, free: Free) -> Array:
        """Return s'' of coordinates, (k,), in the motion `free`."""
        return np.asarray(_in_bodies(along, self.pose) @ free.change + _bias(along, self.pose, self.twist))

    def multipliers_of(self, gradients: Array) -> Array:
        """Return the multipliers λ (k, m) caused by a unit force along each coordinate, with `gradients` (k, 6n)."""
        return np.array([self._multipliers(g - self.M @ (self.basis @ (self.basis.T @ g))) for g in gradients])

    def gradients_of(self, along: PrimitiveSet) -> Array:
        """Return ∂s/∂(δr, δθ) of coordinates, (k, 6n)."""
        return _in_bodies(along, self.pose)

    def _multipliers(self, left: Array) -> Array:
        """Return the smallest λ (m,) with Gᵀλ = left."""
        return np.asarray(self.smallest.T @ left)

    def _moving(self, change: Array, counted: Array) -> MotionAtTime:
        state = self.state
        return MotionAtTime(state.t, state.q, tangent_velocities(self.pose, state.v), change, counted, state.x)


def counted_coordinates(system: System, state: State) -> Array:
    """Return the joints' coordinates with turns, (nc,)."""
    return coordinate_values(system, pose_of(state.q)) + 2.0 * np.pi * state.turns


def _rows(system: System, pose: Pose) -> Array:
    """Return G (m, 6n) of the joints and the motions."""
    return _in_bodies(system.rows, pose)


def _in_bodies(bound: PrimitiveSet, pose: Pose) -> Array:
    """Return the derivatives of a set's values by (δr, δθ), (m, 6n)."""
    return np.ascontiguousarray(tangent_jacobian(bound, pose)[:, :-1, :6]).reshape(
        bound.size, 6 * (len(pose.position) - 1)
    )


def _gradients(stops: Stops, pose: Pose) -> Array:
    return stops.side[:, None] * _in_bodies(stops.coordinates, pose)


def _bias(bound: PrimitiveSet, pose: Pose, twist: Twist) -> Array:
    """Return the part of s'' without (r'', ω'), (k,). The part of Λ'' that keeps |Λ| is -|Λ'|² Λ."""
    kept = np.zeros((len(pose.position) - 1, 7))
    kept[:, 3:] = -np.sum(twist.rate[:-1] ** 2, axis=1, keepdims=True) * pose.orientation[:-1]
    return np.asarray(set_bias(bound, pose, twist) + set_jacobian(bound, pose) @ kept.ravel())
