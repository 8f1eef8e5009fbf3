"""The mechanisms as Exudyn's models: minimal coordinates in a kinematic tree; free bodies with joints as equations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import exudyn as exu
import numpy as np
from exudyn.itemInterface import NodeGenericODE2, ObjectKinematicTree, SensorBody, SensorKinematicTree
from exudyn.utilities import RigidBodyInertia

from peers.problem import ACROSS, ALONG, GRAVITY, LENGTH, MASS, SliderCrank

WEIGHT = [0.0, 0.0, -GRAVITY]


@dataclass(frozen=True)
class Model:
    """An assembled system, the sensor of its marker, and the two whose distance says how far the loop is open."""

    system: Any
    marker: int
    ends: tuple[int, int] | None = None


def _system() -> Any:
    container = exu.SystemContainer()
    system = container.AddSystem()
    system.variables["container"] = container  # it must live as long as the system
    return system


def chain_tree(links: int) -> Model:
    """A chain in the x-z plane, level along x, as a kinematic tree."""
    system = _system()
    node = system.AddNode(NodeGenericODE2(
        referenceCoordinates=[0.0] * links, initialCoordinates=[0.0] * links, initialCoordinates_t=[0.0] * links,
        numberOfODE2Coordinates=links,
    ))  # fmt: skip
    tree = system.AddObject(ObjectKinematicTree(
        nodeNumber=node, gravity=WEIGHT, jointTypes=[exu.JointType.RevoluteY] * links,
        linkParents=list(range(-1, links - 1)),
        jointTransformations=exu.Matrix3DList([np.eye(3)] * links),
        jointOffsets=exu.Vector3DList([[LENGTH if index else 0.0, 0.0, 0.0] for index in range(links)]),
        linkInertiasCOM=exu.Matrix3DList([np.diag([ALONG, ACROSS, ACROSS])] * links),
        linkCOMs=exu.Vector3DList([[LENGTH / 2, 0.0, 0.0]] * links), linkMasses=[MASS] * links,
    ))  # fmt: skip
    marker = system.AddSensor(SensorKinematicTree(
        objectNumber=tree, linkNumber=links - 1, localPosition=[LENGTH, 0.0, 0.0], storeInternal=True,
        outputVariableType=exu.OutputVariableType.Position,
    ))  # fmt: skip
    system.Assemble()
    return Model(system, marker)


def _body_sensor(system: Any, body: int, point: list[float]) -> int:
    return int(system.AddSensor(SensorBody(
        bodyNumber=body, localPosition=point, storeInternal=True, outputVariableType=exu.OutputVariableType.Position
    )))  # fmt: skip


def chain_bodies(links: int, node_type: Any) -> Model:
    """A chain of free bodies and revolute joints."""
    system = _system()
    previous = system.CreateGround()
    for index in range(links):
        body = system.CreateRigidBody(
            referencePosition=[(index + 0.5) * LENGTH, 0.0, 0.0], gravity=WEIGHT, nodeType=node_type,
            inertia=RigidBodyInertia(mass=MASS, inertiaTensor=np.diag([ALONG, ACROSS, ACROSS])),
        )  # fmt: skip
        system.CreateRevoluteJoint(
            bodyNumbers=[previous, body], position=[index * LENGTH, 0.0, 0.0], axis=[0.0, 1.0, 0.0], useGlobalFrame=True
        )
        previous = body
    marker = _body_sensor(system, previous, [LENGTH / 2, 0.0, 0.0])
    system.Assemble()
    return Model(system, marker)


def slider_crank_bodies(node_type: Any) -> Model:
    """The slider-crank of three free bodies: revolute, spherical, universal (a generic joint), prismatic."""
    S, system = SliderCrank, _system()
    speed, about_x, about_pin = S.start_velocities()
    turning = about_x * np.array([1.0, 0.0, 0.0]) + about_pin * S.ROD_AXES[:, 1]
    ground = system.CreateGround()
    crank = system.CreateRigidBody(
        referencePosition=S.PIVOT, initialAngularVelocity=[S.SPEED, 0.0, 0.0], gravity=WEIGHT, nodeType=node_type,
        inertia=RigidBodyInertia(mass=S.CRANK_MASS, inertiaTensor=np.diag(S.CRANK_INERTIA)),
    )  # fmt: skip
    rod = system.CreateRigidBody(
        referencePosition=S.ROD_CENTRE, referenceRotationMatrix=S.ROD_AXES, gravity=WEIGHT, nodeType=node_type,
        initialAngularVelocity=turning,
        initialVelocity=np.array([speed, 0.0, 0.0]) + np.cross(turning, S.ROD_CENTRE - S.SLIDER),
        inertia=RigidBodyInertia(mass=S.ROD_MASS, inertiaTensor=np.diag(S.ROD_INERTIA)),
    )  # fmt: skip
    slider = system.CreateRigidBody(
        referencePosition=S.SLIDER, initialVelocity=[speed, 0.0, 0.0], gravity=WEIGHT, nodeType=node_type,
        inertia=RigidBodyInertia(mass=S.SLIDER_MASS, inertiaTensor=np.diag(S.SLIDER_INERTIA)),
    )  # fmt: skip
    x = [1.0, 0.0, 0.0]
    system.CreateRevoluteJoint(bodyNumbers=[ground, crank], position=S.PIVOT, axis=x, useGlobalFrame=True)
    system.CreateSphericalJoint(bodyNumbers=[crank, rod], position=S.BALL, useGlobalFrame=True)
    # Axes of the universal joint at its start: the rod's pin, the slider's x axis (both free), their normal.
    pin = S.ROD_AXES[:, 1]
    frame = np.column_stack([pin, x, np.cross(pin, x)])
    system.CreateGenericJoint(
        bodyNumbers=[rod, slider], position=S.SLIDER, rotationMatrixAxes=frame, constrainedAxes=[1, 1, 1, 0, 0, 1],
        useGlobalFrame=True,
    )  # fmt: skip
    system.CreatePrismaticJoint(bodyNumbers=[ground, slider], position=S.SLIDER, axis=x, useGlobalFrame=True)
    marker = _body_sensor(system, slider, [0.0, 0.0, 0.0])
    ends = (
        _body_sensor(system, crank, [0.0, 0.0, S.CRANK_LENGTH]),
        _body_sensor(system, rod, [-S.ROD_LENGTH / 2, 0.0, 0.0]),
    )
    system.Assemble()
    return Model(system, marker, ends)
