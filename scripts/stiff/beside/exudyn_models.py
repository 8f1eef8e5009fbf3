"""The mechanisms as Exudyn's models: bodies in the plane or in space with joints as equations, and two kinematic trees
without any. Its rigid-body spring-damper in the intrinsic formulation is the bushing, midway between both frames."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import exudyn as exu
import numpy as np
from exudyn.itemInterface import (
    LoadMassProportional,
    MarkerBodyMass,
    MarkerBodyPosition,
    MarkerBodyRigid,
    MarkerKinematicTreeRigid,
    NodeGenericODE2,
    NodeRigidBody2D,
    ObjectConnectorRigidBodySpringDamper,
    ObjectJointRevolute2D,
    ObjectKinematicTree,
    ObjectRigidBody2D,
    SensorBody,
    SensorKinematicTree,
)
from exudyn.utilities import RigidBodyInertia

from stiff.beside import governor as numbers
from stiff.beside.four_bar import CRANK, FRAME, GRAVITY, HALF, INERTIAS, MASSES, ROCKER, FourBar
from stiff.beside.governor import Governor
from stiff.beside.program import Array

POSITION = exu.OutputVariableType.Position
DOWN = [0.0, -GRAVITY, 0.0]


@dataclass(frozen=True)
class Model:
    """An assembled system, the sensors of both points with the columns of their positions that count, and what makes
    accelerations of the coordinates of the equations by hand from those of its own."""

    system: Any
    sensors: tuple[int, int]
    columns: tuple[list[int], list[int]]
    coordinates: Callable[[Array], Array]


def _system() -> Any:
    container = exu.SystemContainer()
    system = container.AddSystem()
    system.variables["container"] = container  # it must live as long as the system
    return system


def _bushing(system: Any, bar: FourBar, markers: list[Any]) -> None:
    matrices = []
    for along, across, about in (bar.stiffness.tolist(), bar.damping.tolist()):
        matrices.append(np.diag([along, across, across, about, about, about]))
    system.AddObject(
        ObjectConnectorRigidBodySpringDamper(
            markerNumbers=markers, stiffness=matrices[0], damping=matrices[1], useIntrinsicFormulation=True
        )
    )


def bodies(bar: FourBar) -> Model:
    system = _system()
    u = [np.array([np.cos(angle), np.sin(angle)]) for angle in bar.angles]
    n = [np.array([-each[1], each[0]]) for each in u]
    pins = [np.zeros(2), CRANK * u[0], np.array([FRAME, 0.0]) + ROCKER * u[3], np.array([FRAME, 0.0])]
    offsets = (CRANK / 2, HALF / 2, -HALF / 2, ROCKER / 2)
    w = bar.speeds
    pin_velocity = [np.zeros(2), CRANK * w[0] * n[0], ROCKER * w[3] * n[3], np.zeros(2)]
    made = []
    for k in range(4):
        centre, velocity = pins[k] + offsets[k] * u[k], pin_velocity[k] + offsets[k] * w[k] * n[k]
        node = system.AddNode(
            NodeRigidBody2D(referenceCoordinates=[*centre, bar.angles[k]], initialVelocities=[*velocity, w[k]])
        )
        made.append(
            system.AddObject(ObjectRigidBody2D(physicsMass=MASSES[k], physicsInertia=INERTIAS[k], nodeNumber=node))
        )
        mass = system.AddMarker(MarkerBodyMass(bodyNumber=made[-1]))
        system.AddLoad(LoadMassProportional(markerNumber=mass, loadVector=DOWN))
    ground = system.CreateGround()

    def point(body: Any, at: list[float]) -> Any:
        return system.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=at))

    for first, second in (
        (point(ground, [0.0, 0.0, 0.0]), point(made[0], [-CRANK / 2, 0.0, 0.0])),
        (point(made[0], [CRANK / 2, 0.0, 0.0]), point(made[1], [-HALF / 2, 0.0, 0.0])),
        (point(made[2], [HALF / 2, 0.0, 0.0]), point(made[3], [ROCKER / 2, 0.0, 0.0])),
        (point(ground, [FRAME, 0.0, 0.0]), point(made[3], [-ROCKER / 2, 0.0, 0.0])),
    ):
        system.AddObject(ObjectJointRevolute2D(markerNumbers=[first, second]))
    _bushing(
        system,
        bar,
        [
            system.AddMarker(MarkerBodyRigid(bodyNumber=made[1], localPosition=[HALF / 2, 0.0, 0.0])),
            system.AddMarker(MarkerBodyRigid(bodyNumber=made[2], localPosition=[-HALF / 2, 0.0, 0.0])),
        ],
    )
    sensors = tuple(
        int(
            system.AddSensor(
                SensorBody(
                    bodyNumber=body, localPosition=[at, 0.0, 0.0], storeInternal=True, outputVariableType=POSITION
                )
            )
        )
        for body, at in ((made[1], HALF / 2), (made[3], ROCKER / 2))
    )
    system.Assemble()
    turn = np.zeros((4, 12))
    turn[range(4), range(2, 12, 3)] = 1.0
    return Model(system, (sensors[0], sensors[1]), ([0, 1], [0, 1]), lambda own: np.asarray(turn @ own))


def trees(bar: FourBar) -> Model:
    system = _system()
    one, two, three, four = bar.angles.tolist()
    w1, w2, w3, w4 = bar.speeds.tolist()
    made = []
    for base, angles, speeds, lengths, which, offset in (
        (0.0, (one, two - one), (w1, w2 - w1), (CRANK, HALF / 2), (0, 1), HALF / 2),
        (FRAME, (four, three - four), (w4, w3 - w4), (ROCKER, -HALF / 2), (3, 2), -HALF / 2),
    ):
        node = system.AddNode(
            NodeGenericODE2(
                referenceCoordinates=list(angles),
                initialCoordinates=[0.0, 0.0],
                initialCoordinates_t=list(speeds),
                numberOfODE2Coordinates=2,
            )
        )
        inertia = [np.diag([INERTIAS[k] / 50, INERTIAS[k], INERTIAS[k]]) for k in which]
        made.append(
            system.AddObject(
                ObjectKinematicTree(
                    nodeNumber=node,
                    gravity=DOWN,
                    baseOffset=[base, 0.0, 0.0],
                    jointTypes=[exu.JointType.RevoluteZ] * 2,
                    linkParents=[-1, 0],
                    jointTransformations=exu.Matrix3DList([np.eye(3)] * 2),
                    jointOffsets=exu.Vector3DList([[0.0, 0.0, 0.0], [lengths[0], 0.0, 0.0]]),
                    linkInertiasCOM=exu.Matrix3DList(inertia),
                    linkCOMs=exu.Vector3DList([[lengths[0] / 2, 0.0, 0.0], [offset, 0.0, 0.0]]),
                    linkMasses=[MASSES[k] for k in which],
                )
            )
        )
    _bushing(
        system,
        bar,
        [
            system.AddMarker(MarkerKinematicTreeRigid(objectNumber=tree, linkNumber=1, localPosition=[at, 0.0, 0.0]))
            for tree, at in zip(made, (HALF, -HALF), strict=True)
        ],
    )
    sensors = tuple(
        int(
            system.AddSensor(
                SensorKinematicTree(
                    objectNumber=tree,
                    linkNumber=link,
                    localPosition=[at, 0.0, 0.0],
                    storeInternal=True,
                    outputVariableType=POSITION,
                )
            )
        )
        for tree, link, at in ((made[0], 1, HALF), (made[1], 0, ROCKER))
    )
    system.Assemble()
    turn = np.array([[1.0, 0, 0, 0], [1.0, 1.0, 0, 0], [0, 0, 1.0, 1.0], [0, 0, 1.0, 0]])
    return Model(system, (sensors[0], sensors[1]), ([0, 1], [0, 1]), lambda own: np.asarray(turn @ own))


def governor(problem: Governor) -> Model:
    """Four bodies in space with joints as equations, none of them redundant."""
    g, system = numbers, _system()
    s, c = np.sin(g.START), np.cos(g.START)
    out, spin, z = g.PIN + g.ARM * s, [0.0, 0.0, g.SPEED], [0.0, 0.0, 1.0]

    def body(mass: float, inertia: list[float], at: list[float], velocity: float = 0.0) -> Any:
        return system.CreateRigidBody(
            referencePosition=at,
            initialVelocity=[0.0, velocity, 0.0],
            initialAngularVelocity=spin,
            gravity=[0.0, 0.0, -GRAVITY],
            nodeType=exu.NodeType.RotationRotationVector,
            inertia=RigidBodyInertia(mass=mass, inertiaTensor=np.diag(inertia)),
        )

    ground = system.CreateGround()
    spindle = body(g.SPINDLE, [g.ACROSS, g.ACROSS, g.ABOUT], [0.0, 0.0, -0.1])
    collar_at = [0.0, 0.0, -2.0 * g.LINK * c]
    balls = [
        body(g.BALL, [g.BALL_INERTIA] * 3, [side * out, 0.0, -g.ARM * c], side * g.SPEED * out) for side in (1.0, -1.0)
    ]
    collar = body(g.COLLAR, [g.COLLAR_INERTIA] * 3, collar_at)
    system.CreateRevoluteJoint(bodyNumbers=[ground, spindle], position=[0.0] * 3, axis=z, useGlobalFrame=True)
    for ball, side in zip(balls, (1.0, -1.0), strict=True):
        system.CreateRevoluteJoint(
            bodyNumbers=[spindle, ball], position=[side * g.PIN, 0.0, 0.0], axis=[0.0, 1.0, 0.0], useGlobalFrame=True
        )
        system.CreateDistanceConstraint(
            bodyNumbers=[ball, collar],
            localPosition0=[side * (g.LINK - g.ARM) * s, 0.0, (g.ARM - g.LINK) * c],
            localPosition1=[side * g.PIN, 0.0, 0.0],
            distance=g.LINK,
        )
    system.CreatePrismaticJoint(bodyNumbers=[spindle, collar], position=collar_at, axis=z, useGlobalFrame=True)
    system.CreateSpringDamper(
        bodyNumbers=[spindle, collar],
        localPosition0=[0.0, 0.0, 0.1],
        localPosition1=[0.0] * 3,
        referenceLength=2.0 * g.LINK * c,
        stiffness=problem.k,
        damping=problem.damping,
    )
    sensors = [
        int(
            system.AddSensor(
                SensorBody(bodyNumber=each, localPosition=[0.0] * 3, storeInternal=True, outputVariableType=POSITION)
            )
        )
        for each in (balls[0], collar)
    ]
    system.Assemble()

    def found(own: Array) -> Array:
        return np.array([own[7] / out, (own[6] + out * g.SPEED**2) / (g.ARM * c)])

    return Model(system, (sensors[0], sensors[1]), ([0, 1], [1, 2]), found)
