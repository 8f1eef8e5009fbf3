"""Directions of motion in words: by the joint coordinates that change most, or by the motion of a body."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, cross
from mbproj.dynamics.derivatives.linear_equations import MotionAtTime
from mbproj.dynamics.derivatives.row_derivatives import row_motion
from mbproj.dynamics.derivatives.tangent_space import tangent_lengths
from mbproj.dynamics.equations.kinematics import attached, slots_of
from mbproj.dynamics.rank.row_words import direction
from mbproj.model.planar.rows import kind_of
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

#: The most joint coordinates that are named.
MOST = 3


def direction_words(system: System, motion: MotionAtTime, ξ: Array) -> str:
    """Return a virtual displacement (6n,), turns in body axes, in words: "of A.angle, B.angle", or "'rod' shifts along
    -z"."""
    change = row_motion(system.coordinates, motion.carried()).G.times(ξ)
    scaled = np.abs(change) / np.where(system.coordinates.is_length, system.length, 1.0)
    scale = float(np.abs(ξ / tangent_lengths(system)).max(initial=0.0))
    if len(scaled) and scaled.max() > THRESHOLDS.named * scale:
        order = [int(index) for index in np.argsort(-scaled, kind="stable")[:MOST]]
        names = [system.names.coordinates[index] for index in order if scaled[index] > THRESHOLDS.named * scaled.max()]
        return f"of {', '.join(names)}"
    rows = ξ.reshape(-1, 6) / ([system.length] * 3 + [1.0] * 3)
    body = int(np.argmax(np.linalg.norm(rows, axis=1)))
    shift, turn = rows[body, :3], motion.pose.rotation[body] @ rows[body, 3:]
    name = system.names.carriers[body]
    if np.linalg.norm(shift) >= np.linalg.norm(turn):
        return f"in which '{name}' shifts along {direction(shift / np.linalg.norm(shift))}"
    return f"in which '{name}' turns about {direction(turn / np.linalg.norm(turn))}"


def lying_flat(system: System, motion: MotionAtTime) -> str | None:
    """Return the joint at which a wheel rolls that lies flat on its plane; None where all wheels stand."""
    x = attached(motion.pose, *slots_of(system.joints))
    for group in system.joints.groups:
        if kind_of(group.primitive) == "wheel_height":
            own = x[group.slots]
            upright = np.linalg.norm(cross(own[:, 1], own[:, 3]), axis=1)
            if upright.min() < THRESHOLDS.rounded:
                return system.names.joints[system.joints.owner[group.rows[int(np.argmin(upright)), 0]]]
    return None
