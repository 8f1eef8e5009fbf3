"""The start that a scene asks for: a guess of poses and velocities, and conditions on joint coordinates."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, numbers
from mbproj.dataclass import dataclass
from mbproj.model.compile.rigid_groups import rigid_groups
from mbproj.model.euler_parameters import matrix_L, product, rotation_matrix
from mbproj.model.system import Conditions, System
from mbproj.scene.read import Scene


@dataclass(frozen=True, eq=False)
class Guess:
    """Coordinates q (7n,) and velocities v = q' (7n,) to start assembly from, and conditions on joint coordinates."""

    q: Array
    v: Array
    start: Conditions
    speed: Conditions


def initial_guess(scene: Scene, system: System) -> Guess:
    """Return the guess from the poses and velocities of the scene's bodies, and the conditions of its joints.

    Λ' = ½ Lᵀ ω (Eq. 16). A body with a pose at the start carries the other bodies of its rigid group along."""
    carriers = rigid_groups(scene).carriers
    position = numbers([carrier.position for carrier in carriers])
    orientation = numbers([carrier.orientation for carrier in carriers])
    velocity = numbers([carrier.velocity for carrier in carriers])
    for body, (carrier, offset, turn) in zip(
        scene.bodies, zip(system.body_carrier, system.body_offset, system.body_turn, strict=True), strict=True
    ):
        if body.start is not None and carrier < system.bodies:
            orientation[carrier] = product(numbers(body.start[1]), turn * [1.0, -1.0, -1.0, -1.0])
            position[carrier] = body.start[0] - rotation_matrix(orientation[carrier]) @ offset
    omega = numbers([carrier.angular_velocity for carrier in carriers])
    rate = 0.5 * np.einsum("nij,ni->nj", matrix_L(orientation), omega)
    return Guess(
        q=np.hstack([position, orientation]).ravel(),
        v=np.hstack([velocity, rate]).ravel(),
        start=_conditions(scene, system, "start"),
        speed=_conditions(scene, system, "speed"),
    )


def _conditions(scene: Scene, system: System, kind: str) -> Conditions:
    wanted = {
        f"{joint.name}.{coordinate}": value
        for joint in scene.joints
        for coordinate, value in getattr(joint, kind).items()
    }
    index = [index for index, name in enumerate(system.names.coordinates) if name in wanted]
    value = [wanted[system.names.coordinates[i]] for i in index]
    return Conditions(np.array(index, dtype=np.intp), numbers(value))
