"""The full formulation as an initial value problem: y = (q, q'), y' = (q', q'') from Eq. 14 or Eqs. 80-81."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import final

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly import State
from mbproj.dynamics.constraint_equations import constraint, constraint_velocity, gamma, jacobian
from mbproj.dynamics.equations import SOLVERS, generalised_force, mass_matrix
from mbproj.dynamics.kinematics import pose_of, twist_of
from mbproj.dynamics.rank import SINGULAR, row_distances, scaled_jacobian
from mbproj.errors import InputError, SimulationError
from mbproj.integrate.failures import not_finite, singular
from mbproj.model.system import System
from mbproj.projection import Method, Projected, Projection, make_method, project_after
from mbproj.scene.records import Settings


@final
@dataclass(frozen=True, eq=False)
class FullFormulation:
    """Constants of a run: the system, the settings, the projection method that they name."""

    system: System
    settings: Settings
    method: Method

    @classmethod
    def of(cls, system: System, state: State, settings: Settings) -> FullFormulation:
        """Raises InputError where the projection method cannot be used with this system's mass matrix."""
        method = make_method(settings.projection)
        reason = method.refusal(mass_matrix(system, pose_of(state.q))) if isinstance(method, Projection) else None
        if reason:
            raise InputError(reason)
        return cls(system, settings, method)

    def derivative(self, t: float, y: Array) -> Array:
        """y' (14n,) of y (14n,)."""
        q, v = np.split(y, 2)
        return np.concatenate([v, self.accelerations(t, q, v)[0]])

    def accelerations(self, t: float, q: Array, v: Array) -> tuple[Array, Array]:
        """q'' (7n,) and λ (m,). Raises SimulationError where the equations have no unique solution."""
        system, pose = self.system, pose_of(q)
        twist = twist_of(pose, v)
        rhs = gamma(system, pose, twist)
        if self.method.stabilises:
            rhs = self.method.stabilised(rhs, constraint(system, pose), constraint_velocity(system, pose, twist))
        solve = SOLVERS[self.settings.acceleration]
        force = generalised_force(system, pose, twist)
        try:
            return solve(mass_matrix(system, pose), jacobian(system, pose), force, rhs)
        except np.linalg.LinAlgError as error:
            raise self._singular(t, q) from error

    def project(self, step: int, t: float, y: Array) -> Projected:
        """The state after step number `step`, projected as the settings say."""
        q, v = np.split(y, 2)
        if not isinstance(self.method, Projection):
            return Projected(q, v)
        try:
            return project_after(step, self.system, self.method, self.settings.projection, q, v)
        except np.linalg.LinAlgError as error:
            raise self._singular(t, q) from error

    def project_copy(self, y: Array) -> Array:
        """A state between two steps moved to the constraints, both levels that the settings switch on."""
        if not isinstance(self.method, Projection):
            return y
        always = replace(self.settings.projection, every=1, threshold=None)
        projected = project_after(1, self.system, self.method, always, *np.split(y, 2))
        return np.concatenate([projected.q, projected.v])

    def violations(self, q: Array, v: Array) -> tuple[Array, Array]:
        """|C| and |C'|, row by row, (m,)."""
        pose = pose_of(q)
        twist = twist_of(pose, v)
        return np.abs(constraint(self.system, pose)), np.abs(constraint_velocity(self.system, pose, twist))

    def check_regular(self, t: float, q: Array) -> None:
        """Raises SimulationError that names the joint where C_q has lost its rank at this pose."""
        if row_distances(scaled_jacobian(self.system, pose_of(q))).min(initial=1.0) < SINGULAR:
            raise self._singular(t, q)

    def _singular(self, t: float, q: Array) -> SimulationError:
        if not np.all(np.isfinite(q)):
            return not_finite(t)
        distances = row_distances(scaled_jacobian(self.system, pose_of(q)))
        return singular(t, self.system.row_owner(int(np.argmin(distances))))
