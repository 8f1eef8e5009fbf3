"""The start of a scene in the form that other formats need: poses and velocities of its bodies, frames of its
joints."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.adjust import compile_system
from mbproj.dynamics.assembly.assemble import coordinates
from mbproj.dynamics.equations.kinematics import attached, attached_velocity, body_rates, pose_of, twist_of
from mbproj.formats.geometry import IDENTITY, Frame, from_quaternion
from mbproj.linear.equilibrium.started import start_state
from mbproj.model.compile.frames import SYMBOLS, local_frames, poses_of
from mbproj.model.euler_parameters import product
from mbproj.scene.read import Scene
from mbproj.scene.records import GROUND, Joint, Pair
from mbproj.scene.stops import OfBody


@dataclass(frozen=True, eq=False)
class Start:
    """The assembled start of a scene: `poses` of bodies and the ground; `velocities` (3,) of their centres of mass and
    angular velocities `turning` (3,), both global. `values` and `rates` are joint coordinates and their rates by name.
    `given` are the poses in the scene's file. `frames` are the points and axes of each joint by symbol, in the axes of
    its bodies."""

    poses: Mapping[str, Frame]
    velocities: Mapping[str, Array]
    turning: Mapping[str, Array]
    values: Mapping[str, float]
    rates: Mapping[str, float]
    given: Mapping[str, Frame]
    frames: Mapping[str, Mapping[str, Array]]

    def point(self, body: str, local: Array) -> Array:
        """The global place of a point that is given from the body's centre of mass, in its axes."""
        pose = self.poses[body]
        return np.asarray(pose.position + pose.rotation @ local)

    def of_joint(self, joint: Joint, symbol: str) -> Array:
        """A joint's point or axis, "p1", "x1", .. "z2", in global axes at the start."""
        body, local = joint.bodies[int(symbol[1]) - 1], self.frames[joint.name][symbol]
        return self.point(body, local) if symbol[0] == "p" else np.asarray(self.poses[body].rotation @ local)

    def ends(self, bodies: tuple[str, str], points: Pair) -> list[Array]:
        """The points of two bodies, each from its body's centre of mass, in that body's axes."""
        both = zip(bodies, (points.first, points.second), strict=True)
        return [self.in_body_axes(OfBody(body, point, points.local)) for body, point in both]

    def in_body_axes(self, point: OfBody) -> Array:
        """The point from its body's centre of mass, in that body's axes."""
        if point.local:
            return np.array(point.vector)
        pose = self.given[point.body]
        return np.asarray(pose.rotation.T @ (np.array(point.vector) - pose.position))

    @property
    def moves(self) -> bool:
        """Whether any body has a velocity at the start."""
        return any(np.any(each) for each in (*self.velocities.values(), *self.turning.values()))


def start_of(scene: Scene) -> Start:
    """The start of a scene. Raises InputError, and the errors of assembly, where it has none."""
    system = compile_system(scene)
    state = start_state(scene, system)
    pose, carrier = pose_of(state.q), system.body_carrier
    twist = twist_of(pose, state.v)
    points = np.ones(len(carrier))
    position = attached(pose, carrier, system.body_offset, points)
    velocity = attached_velocity(twist, carrier, system.body_offset, points)
    omega = np.einsum("nij,nj->ni", pose.rotation, body_rates(pose, twist))[carrier]
    turned = product(pose.orientation[carrier], system.body_turn)
    names = [body.name for body in scene.bodies]
    poses = {
        name: Frame(np.array(at), from_quaternion(np.array(turn)))
        for name, at, turn in zip(names, position, turned, strict=True)
    }
    values, rates = coordinates(system, state.q, state.v)
    given = poses_of(scene)
    own = [joint for joint in scene.joints if joint.couples is None]
    framed = dict(zip([joint.name for joint in own], local_frames(own, given), strict=True))
    return Start(
        poses | {GROUND: IDENTITY},
        dict(zip(names, np.asarray(velocity), strict=True)) | {GROUND: np.zeros(3)},
        dict(zip(names, np.asarray(omega), strict=True)) | {GROUND: np.zeros(3)},
        dict(zip(system.names.coordinates, values.tolist(), strict=False)),
        dict(zip(system.names.coordinates, rates.tolist(), strict=False)),
        {name: Frame(*each) for name, each in given.items()},
        {name: dict(zip(SYMBOLS, each, strict=True)) for name, each in framed.items()},
    )
