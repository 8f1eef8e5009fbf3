"""Planar coordinates: x, y and θ, 3 freedoms a body; reactions out of the plane by one spatial solve a sample."""

from __future__ import annotations

from collections.abc import Mapping
from types import ModuleType
from typing import Any, final

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dynamics.samples import Samples
from mbproj.integrate.compiled import Compiled
from mbproj.integrate.reduced import Reduced, space_state
from mbproj.kernel.models import joints_in_plane, plane_model, plane_rows
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.planar import Plane
from mbproj.model.system import System


@final
class InPlane(Compiled):
    """The kernel in a plane."""

    name = "planar"
    dimension = "Plane"

    def __init__(self, core: ModuleType | None, system: System, plane: Plane) -> None:
        super().__init__(core, system, plane_model(core, system, plane) if core else None)
        self.plane = plane
        self._joints = joints_in_plane(plane)
        self._rows = plane_rows(plane)
        self._space = Reduced(core, system).equations()

    @property
    def degrees_of_freedom(self) -> int:
        return 3 * self.system.bodies - self.plane.joints.size

    def state(self, q: Array, v: Array) -> Array:
        p, u = self.plane.reduce(q, v)
        return np.concatenate([part.reshape(*part.shape[:-1], -1, 3) for part in (p, u)], axis=-1)

    def samples(self, block: Mapping[str, Any], counters: Mapping[str, Integers]) -> Samples:
        y, acceleration = block["y"], block["acceleration"]
        count = len(y)
        p, u = y[..., :3].reshape(count, -1), y[..., 3:].reshape(count, -1)
        q, v, a = self.plane.expand(p, u, acceleration.reshape(count, -1))
        turns = np.zeros((count, self.system.coordinates.size), dtype=np.intp)
        turns[:, self.plane.coordinates.source.source] = block["turns"]
        return Samples(
            t=block["t"],
            q=q,
            v=v,
            acceleration=a,
            multipliers=self._multipliers(space_state(q, v), self._spatial(acceleration)),
            turns=turns,
            step_size=block["step_size"],
            work=np.zeros((len(block["t"]), 2)),
            counters=counters,
        )

    def turns(self, turns: Integers) -> Integers:
        return turns[self.plane.coordinates.source.source]

    def joint(self, number: int) -> str:
        return self.system.names.joints[self._joints[number]]

    def row(self, number: int) -> int:
        return int(self.system.bodies + self._rows[number])

    def _spatial(self, acceleration: Array) -> Array:
        """Accelerations r'' and ω' in global axes, (T, n, 6), from those in the plane (T, n, 3)."""
        axes = self.plane.axes
        return np.concatenate([acceleration[..., :2] @ axes[:, :2].T, acceleration[..., 2:] * axes[:, 2]], axis=-1)

    def _multipliers(self, states: Array, accelerations: Array) -> Array:
        """λ of all joint rows, (T, m), at spatial states (T, n, 13). Where rows out of the plane are redundant, the
        smallest λ that keep the bodies on the motion that the plane gives."""
        found = np.empty((len(states), self.system.joints.size))
        for index, (y, a) in enumerate(zip(states, accelerations, strict=True)):
            solved = self._space.accelerations(np.ascontiguousarray(y))
            found[index] = self._smallest(y, a) if solved is None else solved[1]
        return found

    def _smallest(self, y: Array, a: Array) -> Array:
        system = self.system
        G = self._space.jacobian(np.ascontiguousarray(y)).reshape(system.joints.size, -1)
        A = rotation_matrix(y[:, 3:7])
        omega, spin_up = y[:, 10:13], (np.swapaxes(A, -1, -2) @ a[:, 3:, None])[..., 0]
        momentum = (system.inertia @ omega[..., None])[..., 0]
        torque = (system.inertia @ spin_up[..., None])[..., 0] + np.cross(omega, momentum)
        force = system.mass[:, None] * (a[:, :3] - system.gravity)
        missing = -np.concatenate([force, (A @ torque[..., None])[..., 0]], axis=-1).ravel()
        return np.asarray(np.linalg.lstsq(G.T, missing, rcond=1e-11)[0], dtype=float)
