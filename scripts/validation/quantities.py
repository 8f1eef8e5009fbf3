"""What a reference table's columns are called, and what of a run they are held against.

A column is OWNER.QUANTITY or OWNER.QUANTITY.COMPONENT, SI units. Of a body: `position`, `velocity`, `acceleration`
(global), `orientation` (e0..e3, of either sign), `angular_velocity`, `angular_acceleration` (body axes),
`global_angular_velocity`, `global_angular_acceleration`. Of a marker: its `position`. Of a joint: its coordinates,
`speed` (`speed_1`) of its `angle` (`angle_1`), and `force_on_first`, `torque_on_first`: the reaction on the joint's
first body, the ground here, at the joint's point in that body, global axes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from mbproj import Report
from mbproj.base.arrays import Array
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.system import System
from mbproj.scene.scene import Scene

#: Where a component stands; a scalar has none.
COMPONENTS = {"": 0, **dict(zip("xyz", range(3), strict=True)), **{f"e{k}": k for k in range(4)}}
UNITS = {
    "position": "m",
    "velocity": "m/s",
    "acceleration": "m/s^2",
    "orientation": "1",
    "angular_velocity": "rad/s",
    "angular_acceleration": "rad/s^2",
    "global_angular_velocity": "rad/s",
    "global_angular_acceleration": "rad/s^2",
    "force_on_first": "N",
    "torque_on_first": "N m",
    "angle": "rad",
    "angle_1": "rad",
    "angle_2": "rad",
    "speed": "rad/s",
    "speed_1": "rad/s",
    "speed_2": "rad/s",
}

#: Those that are a joint's coordinates and their rates.
COORDINATES = {"angle", "angle_1", "angle_2", "speed", "speed_1", "speed_2"}


@dataclass(frozen=True, eq=False)
class Done:
    """A finished run: what it has `recorded` is by path, the first axis time."""

    scene: Scene
    system: System
    recorded: Mapping[str, Any]
    report: Report


class Column(NamedTuple):
    """A column's name in its parts; `component` is empty for a scalar."""

    owner: str
    quantity: str
    component: str

    @classmethod
    def of(cls, name: str) -> Column:
        owner, quantity, component = (*name.split("."), "")[:3]
        return cls(owner, quantity, component)


def quantity(done: Done, owner: str, name: str) -> Array:
    """The values of a quantity at all samples: (T,) or (T, 3), orientations (T, 4)."""
    names, recorded = done.system.names, done.recorded
    if name in COORDINATES:
        path = "joints/speed" if name.startswith("speed") else "joints/coordinate"
        return recorded[path][:, names.coordinates.index(f"{owner}.{name.replace('speed', 'angle')}")]
    if name.endswith("_on_first"):
        return _on_first(done, names.joints.index(owner), name.removesuffix("_on_first"))
    if owner in names.markers:
        return recorded[f"markers/{name}"][:, names.markers.index(owner)]
    body = names.bodies.index(owner)
    values = recorded[f"bodies/{name.removeprefix('global_')}"][:, body]
    if name.startswith("global_"):
        return np.einsum("tij,tj->ti", rotation_matrix(recorded["bodies/orientation"][:, body]), values)
    return values


def _on_first(done: Done, joint: int, what: str) -> Array:
    """The reaction on the ground, at the joint's global point: what is recorded acts on body 2 at its own point, which
    is elsewhere on a sliding joint."""
    force = done.recorded["joints/reaction_force"][:, joint]
    if what == "force":
        return -force
    body, local = done.system.reaction_body[joint], done.system.reaction_local[joint]
    turned = rotation_matrix(done.recorded["bodies/orientation"][:, body]) @ local
    arm = done.recorded["bodies/position"][:, body] + turned - np.array(done.scene.joints[joint].points.first)
    return -done.recorded["joints/reaction_torque"][:, joint] - np.cross(arm, force)
