"""The forces and torques of given components on bodies, as they are recorded."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Numbers, dot
from mbproj.dynamics.equations.instant import Instant
from mbproj.dynamics.equations.kinematics import attached_velocity, body_rates
from mbproj.functions.series import run
from mbproj.model.system import System


def applied_paths(system: System) -> tuple[str, ...]:
    """The datasets that a scene has."""
    return tuple(APPLIED) if system.forces.on_bodies.size else ()


def applied_vectors(instant: Instant) -> Numbers:
    """The forces in N and torques in N m, in global axes, (T, W, 3)."""
    forces, variables = instant.system.forces, instant.variables()
    given, samples = forces.on_bodies, np.size(instant.t)
    found = (run(forces.programs, int(index), variables, None)[0] for index in given.program.flat)
    each = [np.broadcast_to(values, samples) for values in found]
    components = np.stack(each, axis=-1).reshape(samples, given.size, 3)
    carried = given.turn @ components[..., None]
    turned = (instant.pose.rotation[..., given.body, :, :] @ carried)[..., 0]
    return np.asarray(np.where(given.in_body[:, None], turned, components))


def applied_power(instant: Instant) -> Numbers:
    """The power of these in W, (T, W): along the velocity of the point, or the angular velocity of the body."""
    vectors, given, pose = applied_vectors(instant), instant.system.forces.on_bodies, instant.pose
    velocity = attached_velocity(instant.twist, given.body, given.point, np.ones(given.size))
    rates = body_rates(pose, instant.twist)[..., given.body, :]
    omega = (pose.rotation[..., given.body, :, :] @ rates[..., None])[..., 0]
    return np.asarray(dot(vectors, np.where(given.is_torque[:, None], omega, velocity)))


#: By dataset, what it holds.
APPLIED = {"forces/applied": applied_vectors, "forces/applied_power": applied_power}
