"""Groups of bodies that `fixed` joints make one: each moves as one carrier, with the mass and inertia of the group."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbproj.arrays import Array, cross, numbers
from mbproj.dataclass import dataclass
from mbproj.joints import JOINTS
from mbproj.model.compile.frames import Pose, poses_of
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.scene.read import Scene
from mbproj.scene.records import GROUND, Body, Joint


@dataclass(frozen=True, eq=False)
class Carrier:
    """A rigid body of the system: mass, inertia (3, 3) about its centre of mass, and a guess of its pose and motion.

    `orientation` (4,) are Euler parameters; `velocity` is in global axes, `angular_velocity` in the carrier's axes.
    """

    name: str
    mass: float
    inertia: Array
    position: Array
    orientation: Array
    velocity: Array
    angular_velocity: Array


@dataclass(frozen=True, eq=False)
class Seat:
    """The place of a scene's body on its carrier (index n: the ground). `offset` (3,) is the body's centre of mass and
    `turn` (3, 3) its axes, both in the carrier's axes."""

    carrier: int
    offset: Array
    turn: Array

    def point(self, local: Array) -> Array:
        """Return a point of the body in the carrier's axes; `local` is in the body's axes."""
        return self.offset + self.turn @ local

    def vector(self, local: Array) -> Array:
        """Return a vector of the body in the carrier's axes; `local` is in the body's axes."""
        return self.turn @ local


@dataclass(frozen=True, eq=False)
class RigidGroups:
    """The carriers, the seat of every body by name, and the joints that remain between carriers."""

    carriers: tuple[Carrier, ...]
    seats: Mapping[str, Seat]
    joints: tuple[Joint, ...]


#: The seat of a body that is its own carrier.
_AT_CENTRE = (np.zeros(3), np.eye(3))


def rigid_groups(scene: Scene) -> RigidGroups:
    """Merge the bodies of the scene that fixed joints connect. A body alone is its own carrier, to the last bit."""
    bodies = {body.name: body for body in scene.bodies}
    merging = _merging(scene)
    poses = poses_of(scene)
    carriers: list[Carrier] = []
    seats: dict[str, Seat] = {}
    grounded: dict[str, Seat] = {}
    for root in (GROUND, *bodies):
        if root in seats or root in grounded:
            continue
        group = _group(root, merging, poses)
        if root == GROUND:
            grounded = {name: Seat(-1, position, turn) for name, (position, turn) in group.items()}
        elif len(group) == 1:
            seats[root] = Seat(len(carriers), *_AT_CENTRE)
            carriers.append(_alone(bodies[root]))
        else:
            carrier = _composite([bodies[name] for name in group], group)
            turn = group[root][1]
            seats |= {
                name: Seat(len(carriers), turn.T @ (position - carrier.position), turn.T @ axes)
                for name, (position, axes) in group.items()
            }
            carriers.append(carrier)
    seats |= {name: Seat(len(carriers), seat.offset, seat.turn) for name, seat in grounded.items()}
    return RigidGroups(tuple(carriers), seats, tuple(joint for joint in scene.joints if joint not in merging))


def _merging(scene: Scene) -> list[Joint]:
    """Return the joints that merge their bodies. Groups in which a further joint connects two bodies stay unmerged. In
    one carrier the rows of that joint would have no gradient, which would hide that they are redundant."""
    merging = [joint for joint in scene.joints if JOINTS[joint.type].merges and not joint.reaction]
    group = {name: name for name in (GROUND, *(body.name for body in scene.bodies))}
    for joint in merging:
        first, second = (group[name] for name in joint.bodies)
        group = {name: first if root == second else root for name, root in group.items()}
    held = {
        group[joint.bodies[0]]
        for joint in scene.joints
        if joint not in merging and joint.couples is None and group[joint.bodies[0]] == group[joint.bodies[1]]
    }
    return [joint for joint in merging if group[joint.bodies[0]] not in held]


def _group(root: str, merging: list[Joint], poses: Mapping[str, Pose]) -> dict[str, Pose]:
    """Return the bodies held rigidly to `root`, with poses in which points and frames of the merging joints agree."""
    group, waiting = {root: poses[root]}, [root]
    while waiting:
        name = waiting.pop()
        for joint in merging:
            if name not in joint.bodies:
                continue
            side = joint.bodies.index(name)
            other = joint.bodies[1 - side]
            if other in group:
                continue
            position, turn = poses[other]
            if joint.frames is not None:
                own = [rotation_matrix(numbers(each)) for each in (joint.frames.first, joint.frames.second)]
                turn = group[name][1] @ own[side] @ own[1 - side].T
            if joint.points.local:
                ends = (numbers(joint.points.first), numbers(joint.points.second))
                position = group[name][0] + group[name][1] @ ends[side] - turn @ ends[1 - side]
            group[other] = (position, turn)
            waiting.append(other)
    return group


def _alone(body: Body) -> Carrier:
    return Carrier(
        body.name,
        body.mass,
        numbers(body.inertia),
        numbers(body.position),
        numbers(body.orientation),
        numbers(body.velocity),
        numbers(body.angular_velocity),
    )


def _composite(bodies: list[Body], group: Mapping[str, Pose]) -> Carrier:
    """Return the carrier of several bodies, in the axes of the first (parallel-axis theorem)."""
    first = bodies[0]
    start, axes = group[first.name]
    mass = sum(body.mass for body in bodies)
    weights = [body.mass / mass if mass > 0.0 else 1.0 / len(bodies) for body in bodies]
    centre = sum((weight * group[body.name][0] for weight, body in zip(weights, bodies, strict=True)), np.zeros(3))
    inertia = np.zeros((3, 3))
    for body in bodies:
        position, turn = group[body.name]
        arm, local = axes.T @ (position - centre), axes.T @ turn
        inertia += local @ numbers(body.inertia) @ local.T
        inertia += body.mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    omega = numbers(first.angular_velocity)
    velocity = numbers(first.velocity) + cross(axes @ omega, centre - start)
    return Carrier(first.name, mass, 0.5 * (inertia + inertia.T), centre, numbers(first.orientation), velocity, omega)
