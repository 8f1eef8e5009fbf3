"""What a mechanism that nothing holds conserves, and what is added up in it."""

from __future__ import annotations

import numpy as np

from mbproj import System
from mbproj.base.arrays import Numbers
from mbproj.equations.kinematics import body_rates, pose_of, twist_of
from mbproj.equations.samples import Samples


def momentum(system: System, samples: Samples) -> tuple[Numbers, float]:
    """Linear momentum less what gravity has given, (T, 3) in kg m/s, and the sum of the sizes of its parts."""
    v = samples.v.reshape(len(samples.t), -1, 7)[..., :3]
    given = system.mass.sum() * system.gravity * samples.t[:, None]
    parts = system.mass[:, None] * v
    return parts.sum(axis=1) - given, float(np.abs(parts).sum(axis=1).max() + np.abs(given).max())


def angular_momentum(system: System, samples: Samples) -> tuple[Numbers, float]:
    """About the common centre of mass, (T, 3) in kg m²/s, and the sum of the sizes of its parts."""
    pose = pose_of(samples.q)
    twist = twist_of(pose, samples.v)
    mass = system.mass[:, None]
    r, v = (part[:, :-1] for part in (pose.position, twist.velocity))
    r, v = (part - (mass * part).sum(axis=1, keepdims=True) / mass.sum() for part in (r, v))
    spin = system.inertia @ body_rates(pose, twist)[:, :-1, :, None]
    parts = mass * np.cross(r, v) + (pose.rotation[:, :-1] @ spin)[..., 0]
    size = np.linalg.norm(mass * r, axis=-1) * np.linalg.norm(v, axis=-1) + np.linalg.norm(spin[..., 0], axis=-1)
    return parts.sum(axis=1), float(size.sum(axis=1).max())
