"""The ropes of a scene at its start: their lengths, and their angles of wrap on sheaves, wheels and drums."""

from __future__ import annotations

from typing import TypedDict

from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.observe.tensions import length_and_wraps
from mbproj.model.system import System
from mbproj.scene.read import Scene


class Wrap(TypedDict):
    """The wrap on a circle between the ends of a rope. `place` counts the places of the path from 1; `body` carries the
    circle; `angle` is in rad."""

    place: int
    body: str
    angle: float


class RopeAtStart(TypedDict):
    """The length of a rope in m, without the rope on the drums at its ends, and its wraps."""

    length: float
    wraps: list[Wrap]


def ropes_at_start(scene: Scene, system: System, state: State) -> dict[str, RopeAtStart]:
    """The lengths and wraps of all ropes of a scene, by name."""
    ropes, pose = dict[str, RopeAtStart](), pose_of(state.q)
    for joint in scene.joints:
        if "path" not in joint.parameters:
            continue
        length, angles = length_and_wraps(system, pose, joint.name)
        circles = [(k, node.body) for k, node in enumerate(joint.parameters["path"].nodes[1:-1], 2) if node.radius]
        wraps = [Wrap(place=k, body=body, angle=angle) for (k, body), angle in zip(circles, angles, strict=True)]
        ropes[joint.name] = RopeAtStart(length=length, wraps=wraps)
    return ropes
