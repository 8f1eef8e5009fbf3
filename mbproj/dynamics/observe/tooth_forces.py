"""Forces between teeth: their points of action, and their effect on the bearings of both wheels."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Numbers, cross, dot
from mbproj.dynamics.equations.kinematics import Pose, attached
from mbproj.model.system import System


def on_bearings(system: System, pose: Pose, force: Numbers, torque: Numbers) -> tuple[Numbers, Numbers]:
    """Return reactions (T, nj, 3) in which gears push with their teeth, not with a pure torque on each wheel.

    At the pitch point P the second wheel takes F = τ/r e ± |τ|/r tan α n. τ is its torque, e is normal to the line of
    the centres, and n points from P to its centre. The first wheel takes -F. The bearings carry the difference between
    this force and the pure torque τ.
    """
    force, torque = force.copy(), torque.copy()
    places = attached(pose, system.reaction_body, system.reaction_local, np.ones(len(system.reaction_body)))
    x = pose.places(system.coordinates)
    for gear in system.couplings.teeth:
        centres = [places[..., joint, :] for joint in gear.joints]
        axes = [_axis(system, x, coordinate) for coordinate in gear.coordinates]
        first, second = gear.teeth
        line = _normal_part(centres[1] - centres[0], axes[0])
        pitch = centres[0] + line * (first / (first + second))
        turning = dot(torque[..., gear.joint, :], axes[1])
        out = _normal_part(pitch - centres[1], axes[1])
        radius = np.sqrt(dot(out, out))[..., None]
        along = (turning[..., None] / radius) * cross(axes[1], out / radius)
        aside = np.sign(second) * np.abs(turning)[..., None] / radius * np.tan(gear.pressure_angle) * out / radius
        push = along - aside
        both = (-push, turning * (first / second)), (push, turning)
        for joint, centre, axis, (own, about) in zip(gear.joints, centres, axes, both, strict=True):
            force[..., joint, :] -= own
            torque[..., joint, :] += about[..., None] * axis - cross(pitch - centre, own)
        force[..., gear.joint, :] = push
        torque[..., gear.joint, :] = cross(pitch - places[..., gear.joint, :], push)
    return force, torque


def _axis(system: System, x: Numbers, coordinate: int) -> Numbers:
    """Return the axis about which an angle counts, at places (T, S, 3)."""
    first, second, _ = system.coordinates.layout.members[system.coordinates.layout.member[coordinate]].slots
    return cross(x[..., first, :], x[..., second, :])


def _normal_part(vector: Numbers, axis: Numbers) -> Numbers:
    return np.asarray(vector - dot(vector, axis)[..., None] * axis)
