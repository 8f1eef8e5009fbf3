"""Joints that bear part of a load which stops and frictions share arbitrarily, for planar runs. Such a part may load
joints out of the plane."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.contact.freedom import Freedom
from mbproj.dynamics.observe.reactions import reactions
from mbproj.integrate.formulations.compiled import Compiled
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


def loaded_joints(
    system: System, compiled: Compiled, joints: Sequence[int]
) -> Callable[[float, Array, Array], list[int]]:
    """Return a function of (t, y, forces). It returns the places, within `joints`, of the joints that bear any of the
    forces.

    y is the kernel's, and `forces` (S + K, k) act along the coordinates of stops and frictions."""

    def loaded(t: float, y: Array, forces: Array) -> list[int]:
        q, v = compiled.coordinates(compiled.bodies_of(y))
        freedom = Freedom.at(system, State.of(system, t, positions=q, velocities=v))
        owners = [own.coordinates for own in (system.stops, system.frictions) if own is not None]
        gradients = np.vstack([freedom.gradients_of(along) for along in owners])
        force, torque = reactions(system, freedom.pose, forces.T @ freedom.multipliers_of(gradients))
        size = np.linalg.norm(force, axis=-1) * system.length + np.linalg.norm(torque, axis=-1)
        bears = (size > THRESHOLDS.no_part * np.abs(forces).max() * system.length).any(axis=0)
        return np.flatnonzero(bears[list(joints)]).tolist()

    return loaded
