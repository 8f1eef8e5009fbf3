"""Frames of joints in the axes of their bodies, from the points and axes in the scene; all joints at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from mbproj.base.arrays import Array, cross, like_of, numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.joints.table import JOINTS
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.scene.records import GROUND, Body, Joint, Pair
from mbproj.scene.scene import Scene

#: A body's pose: its centre of mass (3,) and its rotation matrix (3, 3).
Pose = tuple[Array, Array]
#: The points and vectors that a joint binds, in the order of arrays (..., 8, 3).
SYMBOLS = ("p1", "x1", "y1", "z1", "p2", "x2", "y2", "z2")
_NO_AXIS = Pair((0.0, 0.0, 1.0), (0.0, 0.0, 1.0), local=False)


def local_frames(joints: Sequence[Joint], poses: Mapping[str, Pose]) -> Array:
    """Return the vectors `SYMBOLS` of joints that couple no others, (joints, 8, 3), each in the axes of its own body.

    At the scene's pose x1 and x2 have the same direction, so that the joint's angle is zero there. Where the axes do
    not agree yet, the shortest rotation takes one to the other.
    """
    if not joints:
        return np.zeros((0, len(SYMBOLS), 3))
    number = {name: at for at, name in enumerate(poses)}
    bodies = np.array([[number[name] for name in joint.bodies] for joint in joints])
    position, rotation = (numbers(part)[bodies] for part in zip(*poses.values(), strict=True))
    p = _global([joint.points for joint in joints], position, rotation)
    z = _global([joint.axes or _NO_AXIS for joint in joints], np.zeros_like(position), rotation)
    z = z / _length(z)
    frame = np.array([JOINTS[joint.type].frame for joint in joints])
    z[frame == "normal", 1] = z[frame == "normal", 0]
    z1, z2 = z[:, 0], z[:, 1]
    x = np.empty_like(z)
    x[:, 0] = _any_normal(z1)
    x[:, 1] = _parallel_transport(x[:, 0], z1, z2)
    for at, joint in enumerate(joints):
        if joint.frames is not None:
            pair = (joint.frames.first, joint.frames.second)
            turned = numbers(
                [pose @ rotation_matrix(numbers(turn)) for pose, turn in zip(rotation[at], pair, strict=True)]
            )
            x[at], z[at] = turned[:, :, 0], turned[:, :, 2]
    has_x_axis = np.array([joint.x_axis is not None for joint in joints])
    if has_x_axis.any():
        chosen = [joint.x_axis for joint in joints if joint.x_axis is not None]
        direction = _global(chosen, np.zeros_like(position[has_x_axis]), rotation[has_x_axis])
        direction[frame[has_x_axis] == "normal", 1] = direction[frame[has_x_axis] == "normal", 0]
        direction[frame[has_x_axis] == "face", 1] = z[has_x_axis][frame[has_x_axis] == "face", 0]
        x[has_x_axis] = _normal_part(direction, z[has_x_axis])
    crosswise = (frame == "axes") | (frame == "line")
    if crosswise.any():
        x[crosswise] = _normal_part(z[crosswise, ::-1], z[crosswise])
    triad = np.stack([p - position, x, cross(z, x), z], axis=2)
    return (triad @ rotation).reshape(len(joints), len(SYMBOLS), 3)  # as rows: sᵀ A = (Aᵀ s)ᵀ


def poses_of(scene: Scene) -> dict[str, Pose]:
    """Return the pose of each body in the scene, and of the ground."""
    rotation = rotation_matrix(numbers([body.orientation for body in scene.bodies]).reshape(-1, 4))
    poses = {body.name: (numbers(body.position), turn) for body, turn in zip(scene.bodies, rotation, strict=True)}
    return poses | {GROUND: (np.zeros(3), np.eye(3))}


def pose(position: tuple[float, ...], orientation: tuple[float, ...]) -> Pose:
    """A body's pose from its position (3,) and unit Euler parameters (4,)."""
    return numbers(position), rotation_matrix(numbers(orientation))


def _global(pairs: Sequence[Pair], position: Array, rotation: Array) -> Array:
    """Return pairs of points or vectors in global axes, (k, 2, 3)."""
    values = numbers([(pair.first, pair.second) for pair in pairs])
    local = np.array([pair.local for pair in pairs])
    if local.any():
        values = np.array(values, like=like_of(values, position, rotation))
        values[local] = position[local] + (rotation[local] @ values[local][..., None])[..., 0]
    return values


def _length(vectors: Array) -> Array:
    return np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True))


def _normal_part(vector: Array, axis: Array) -> Array:
    """Unit vectors of the parts of vectors (..., 3) normal to axes; any normal where there is no such part."""
    part = vector - np.sum(vector * axis, axis=-1, keepdims=True) * axis
    length = _length(part)
    is_inclined = length > THRESHOLDS.same_written
    return np.where(is_inclined, part / np.where(is_inclined, length, 1.0), _any_normal(axis))


def _any_normal(axis: Array) -> Array:
    """Unit vectors normal to axes (..., 3): the normal parts of the coordinate axes that are farthest from them."""
    farthest = np.eye(3)[np.argmin(np.abs(axis), axis=-1)]
    part = farthest - np.sum(farthest * axis, axis=-1, keepdims=True) * axis
    normal: Array = part / _length(part)
    return normal


def _parallel_transport(vector: Array, start: Array, end: Array) -> Array:
    """Vectors (..., 3), normal to unit vectors `start`, by the shortest rotations that take `start` to `end`."""
    axis, cosine = cross(start, end), np.sum(start * end, axis=-1, keepdims=True)
    once = cross(axis, vector)
    back = cosine < -1.0 + THRESHOLDS.rounding
    return np.where(back, vector, vector + once + cross(axis, once) / np.where(back, 1.0, 1.0 + cosine))


# --- Groups of bodies that `fixed` joints make one --------------------------------------------------------------------
# Each moves as one carrier, with the mass and inertia of the group.


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
                frames = [rotation_matrix(numbers(each)) for each in (joint.frames.first, joint.frames.second)]
                turn = group[name][1] @ frames[side] @ frames[1 - side].T
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
