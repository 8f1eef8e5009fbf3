"""Exudyn: a kinematic tree with its explicit DOPRI5, and bodies in redundant coordinates with its implicit solvers.

As its documentation advises (https://exudyn.readthedocs.io): explicit solvers only for systems without constraints,
here the tree, with automatic steps; for constraints the generalised-alpha solver (spectral radius 0.9 by default) or
the trapezoidal rule with constraints of index 2, both implicit and of second order, both tried; modified Newton; the
dense solver for small systems and the sparse one for large; nothing written to files. Bodies in space have rotation
vectors with a Lie-group update, the most accurate of its rotations on these mechanisms; those of a planar mechanism are
planar. Its rigid-body spring-damper in the intrinsic formulation is the bushing, midway between both frames."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import product
from time import process_time
from typing import Any

import exudyn as exu
import numpy as np
from exudyn import itemInterface as item  # noqa: N813
from exudyn.utilities import RigidBodyInertia

from mbproj.formats.export.tree import TreeFreedom, acting_on
from mbproj.scene.fields.rotations import to_matrix
from mbproj.scene.records import GROUND, Bushing, JointForce, PointForce

from .problem import (
    Array,
    NotDone,
    Outcome,
    Problem,
    Program,
    Setting,
    opening,
    step_label,
    tolerance_label,
    tolerances,
)

#: From so many bodies on the sparse solver is quicker.
SPARSE = 20
IMPLICIT = (exu.DynamicSolverType.GeneralizedAlpha, exu.DynamicSolverType.TrapezoidalIndex2)
#: The zone of speeds over which dry friction changes its sign, m/s² or rad/s² times the step.
ZONE = 10.0
X, Z = 0, 2
exu.config.printToConsole = False  # what fails is told by the result
exu.config.suppressWarnings = True


class _Model:
    """A system that grows, and the sensors of what is watched and of both ends of its loops."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.start = problem, problem.start
        self.container = exu.SystemContainer()  # it must live as long as the system
        self.system = self.container.AddSystem()
        self.watched: list[tuple[int, float, float]] = []  # a sensor; of a coordinate its sign and its zero, 0 else
        self.ends: list[tuple[int, int]] = []
        self.zones: list[int] = []
        self.sparse = len(problem.scene.bodies) >= SPARSE

    def _sensor(self, kind: Any, **where: Any) -> int:
        position = exu.OutputVariableType.Position
        return int(self.system.AddSensor(kind(storeInternal=True, outputVariableType=position, **where)))

    def _bushings(self, marker: Any) -> None:
        """`marker` makes one of a body at a point in its axes."""
        for force in self.problem.scene.forces:
            if not isinstance(force, Bushing):
                continue
            ends = self.start.ends(force.bodies, force.points)
            axes = to_matrix(force.axes.first)
            turns = [self.start.file_poses[body].rotation.T @ axes for body in force.bodies]
            matrices = []
            for translation, rotation in (force.stiffness, force.damping):
                whole = np.zeros((6, 6))
                whole[:3, :3], whole[3:, 3:] = translation, rotation
                matrices.append(self.in_connector(whole))
            self.system.AddObject(
                item.ObjectConnectorRigidBodySpringDamper(
                    markerNumbers=[marker(body, end) for body, end in zip(force.bodies, ends, strict=True)],
                    stiffness=matrices[0],
                    damping=matrices[1],
                    rotationMarker0=self.turn(turns[0]),
                    rotationMarker1=self.turn(turns[1]),
                    useIntrinsicFormulation=True,
                )
            )

    @staticmethod
    def in_connector(matrix: Array) -> Array:
        """Of a bushing's axes in those of the connector."""
        return matrix

    @staticmethod
    def turn(rotation: Array) -> Array:
        """A bushing's axes in those of a body, as the connector has them."""
        return rotation

    def solve(self, settings: Any, solver: Any, zone: float = 0.0) -> float:
        """Seconds of processor time; the initial values of the model stay as they are."""
        settings.timeIntegration.verboseMode = 0
        settings.timeIntegration.adaptiveStep = False  # where Newton fails the setting has failed
        settings.solutionSettings.writeSolutionToFile = False
        settings.parallel.numberOfThreads = 1
        if self.sparse:
            settings.linearSolverType = exu.LinearSolverType.EigenSparse
        for number in self.zones:
            self.system.SetObjectParameter(number, "frictionProportionalZone", zone)
        begun = process_time()
        try:
            done = self.system.SolveDynamic(settings, solverType=solver)
        except (RuntimeError, ValueError) as error:
            raise NotDone(str(error)) from error
        seconds = process_time() - begun
        if not done:
            raise NotDone("Exudyn does not reach the end")
        return seconds

    def _rows(self, sensor: int, times: Array) -> Array:
        rows = np.atleast_2d(self.system.GetSensorStoredData(sensor))
        where = np.minimum(np.searchsorted(rows[:, 0], times - 1e-9), len(rows) - 1)
        if np.abs(rows[where, 0] - times).max() > 1e-9:
            raise NotDone("Exudyn does not reach the end")
        return np.asarray(rows[where, 1:])

    def seen(self, times: Array) -> Array:
        """What is watched, (T, W, 3)."""
        places = []
        for number, sign, zero in self.watched:
            rows = self._rows(number, times)
            places.append(np.pad(zero + sign * rows[:, :1], ((0, 0), (0, 2))) if sign else self.position(rows))
        return np.stack(places, axis=1)

    @staticmethod
    def position(rows: Array) -> Array:
        """Of a sensor's rows."""
        return rows[:, :3]

    def opened(self, times: Array) -> float | None:
        """By how much loops are open."""
        return opening([(self._rows(one, times), self._rows(other, times)) for one, other in self.ends])


class Spatial(_Model):
    """Free bodies in space with joints as equations."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        self.bodies = {GROUND: self.system.CreateGround()}
        scene, start = problem.scene, self.start
        for body in scene.bodies:
            pose = start.poses[body.name]
            self.bodies[body.name] = self.system.CreateRigidBody(
                referencePosition=pose.position,
                referenceRotationMatrix=pose.rotation,
                initialVelocity=start.velocities[body.name],
                initialAngularVelocity=start.turning[body.name],
                gravity=list(scene.gravity),
                nodeType=exu.NodeType.RotationRotationVector,
                inertia=RigidBodyInertia(mass=body.mass, inertiaTensor=np.array(body.inertia)),
            )
        for joint in scene.joints:
            self._joint(joint)
        for force in scene.forces:
            assert isinstance(force, PointForce)
            ends = start.ends(force.bodies, force.points)
            places = [start.point(body, end) for body, end in zip(force.bodies, ends, strict=True)]
            free = force.law.free
            self.system.CreateSpringDamper(
                bodyNumbers=[self.bodies[body] for body in force.bodies],
                localPosition0=ends[0],
                localPosition1=ends[1],
                referenceLength=float(np.linalg.norm(places[1] - places[0])) if free is None else free,
                stiffness=force.law.stiffness,
                damping=force.law.damping,
            )
        self.watched = [(self._point(*place), 0.0, 0.0) for place in problem.places()]
        self.ends = [(self._point(*one), self._point(*other)) for one, other in problem.loops()]
        self.system.Assemble()

    def _point(self, body: str, at: Array) -> int:
        return self._sensor(item.SensorBody, bodyNumber=self.bodies[body], localPosition=at)

    def _joint(self, joint: Any) -> None:
        pair = [self.bodies[body] for body in joint.bodies]
        if joint.type == "distance":
            one, other = self.start.ends(joint.bodies, joint.points)
            places = [self.start.point(body, end) for body, end in zip(joint.bodies, (one, other), strict=True)]
            length = float(np.linalg.norm(places[1] - places[0]))
            self.system.CreateDistanceConstraint(
                bodyNumbers=pair, localPosition0=one, localPosition1=other, distance=length
            )
            return
        place = self.start.of_joint(joint, "p1")
        where = {"bodyNumbers": pair, "position": place, "useGlobalFrame": True}
        if joint.type == "spherical":
            self.system.CreateSphericalJoint(**where)
            return
        axis, second = self.start.of_joint(joint, "z1"), self.start.of_joint(joint, "z2")
        if joint.type == "universal":  # both axes are free, and their normal is not
            frame = np.column_stack([axis, second, np.cross(axis, second)])
            self.system.CreateGenericJoint(**where, rotationMatrixAxes=frame, constrainedAxes=[1, 1, 1, 0, 0, 1])
            return
        make = {"revolute": self.system.CreateRevoluteJoint, "prismatic": self.system.CreatePrismaticJoint}
        make[joint.type](**where, axis=axis)


class Planar(_Model):
    """Bodies in the plane x-z with pins as equations; Exudyn's x and y are x and z here."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        scene, start = problem.scene, self.start
        self.bodies = {GROUND: self.system.CreateGround()}
        for body in scene.bodies:
            pose, velocity = start.poses[body.name], start.velocities[body.name]
            angle = float(np.arctan2(pose.rotation[Z, X], pose.rotation[X, X]))
            node = self.system.AddNode(
                item.NodeRigidBody2D(
                    referenceCoordinates=[pose.position[X], pose.position[Z], angle],
                    initialVelocities=[velocity[X], velocity[Z], -start.turning[body.name][1]],
                )
            )
            made = item.ObjectRigidBody2D(
                physicsMass=body.mass, physicsInertia=np.array(body.inertia)[1, 1], nodeNumber=node
            )
            self.bodies[body.name] = self.system.AddObject(made)
            mass = self.system.AddMarker(item.MarkerBodyMass(bodyNumber=self.bodies[body.name]))
            weight = [scene.gravity[X], scene.gravity[Z], 0.0]
            self.system.AddLoad(item.LoadMassProportional(markerNumber=mass, loadVector=weight))
        for joint in scene.joints:
            ends = [start.frames[joint.name][symbol] for symbol in ("p1", "p2")]
            pins = [self._marker(item.MarkerBodyPosition, *each) for each in zip(joint.bodies, ends, strict=True)]
            self.system.AddObject(item.ObjectJointRevolute2D(markerNumbers=pins))
        self._bushings(partial(self._marker, item.MarkerBodyRigid))
        for name, at in problem.places():
            number = self._sensor(item.SensorBody, bodyNumber=self.bodies[name], localPosition=self.flat(at))
            self.watched.append((number, 0.0, 0.0))
        self.system.Assemble()

    @staticmethod
    def flat(point: Array) -> list[float]:
        """A point of the plane as Exudyn has it."""
        return [point[X], point[Z], 0.0]

    @staticmethod
    def in_connector(matrix: Array) -> Array:
        order = [0, 2, 1, 3, 5, 4]
        return matrix[np.ix_(order, order)]

    @staticmethod
    def turn(rotation: Array) -> Array:
        flat = np.eye(3)
        flat[:2, :2] = rotation[np.ix_([X, Z], [X, Z])]
        return flat

    @staticmethod
    def position(rows: Array) -> Array:
        return np.stack([rows[:, 0], 0.0 * rows[:, 0], rows[:, 1]], axis=-1)

    def _marker(self, kind: Any, body: str, at: Array) -> Any:
        return self.system.AddMarker(kind(bodyNumber=self.bodies[body], localPosition=self.flat(at)))


class Trees(_Model):
    """A kinematic tree on each joint of the ground, with springs on coordinates, and bushings between the trees."""

    def __init__(self, problem: Problem) -> None:
        super().__init__(problem)
        self.where: dict[str, tuple[int, int]] = {}  # by body: its tree, and its link there
        self.local: dict[str, Array] = {}  # by body: its joint from its centre of mass, in its axes
        self.coordinate: dict[str, tuple[int, int, float]] = {}  # by name: node, number there, sign
        for root in [] if self._alone() else problem.tree.carried(GROUND):
            names = [root.body]
            for branch in problem.tree.branches:
                if branch.carrier in names:
                    names.append(branch.body)
            self._tree([branch for branch in problem.tree.branches if branch.body in names])
        self._loads()
        self._bushings(self._marker)
        for name in problem.watch:
            if name in self.coordinate:
                node, number, sign = self.coordinate[name]
                assert number == 0, "the sensor has the first coordinate of a node"
                kind = exu.OutputVariableType.Coordinates
                sensor = item.SensorNode(nodeNumber=node, storeInternal=True, outputVariableType=kind)
                self.watched.append((int(self.system.AddSensor(sensor)), sign, self.start.values[name]))
        for body, at in problem.places():
            tree, link = self.where[body]
            local = at - self.local[body]
            number = self._sensor(item.SensorKinematicTree, objectNumber=tree, linkNumber=link, localPosition=local)
            self.watched.append((number, 0.0, 0.0))
        self.system.Assemble()

    def _alone(self) -> bool:
        """Takes one body with one freedom and without weight as a mass of one coordinate, which costs less than a
        tree."""
        scene, branch = self.problem.scene, self.problem.tree.branches[0]
        if len(scene.bodies) > 1 or np.any(scene.gravity):
            return False
        ((freedom,), (body,)) = branch.freedoms, scene.bodies
        pose = self.start.poses[body.name]
        arm, axis = freedom.point - pose.position, pose.rotation.T @ freedom.axis
        turning = axis @ np.array(body.inertia) @ axis + body.mass * (arm @ arm - (arm @ freedom.axis) ** 2)
        node = self.system.AddNode(item.Node1D(initialVelocities=[freedom.rate]))
        mass = body.mass if freedom.kind == "slide" else float(turning)
        self.system.AddObject(item.Mass1D(nodeNumber=node, physicsMass=mass))
        self.coordinate[freedom.coordinate] = (node, 0, 1.0)
        return True

    def _tree(self, branches: list[Any]) -> None:
        """Links have the axes of their bodies."""
        start, bodies = self.start, {body.name: body for body in self.problem.scene.bodies}
        links = {branch.body: number for number, branch in enumerate(branches)}
        kinds, offsets, turns, centres, inertias, rates = [], [], [], [], [], []
        for branch in branches:
            (freedom,) = branch.freedoms
            pose, carrier = start.poses[branch.body], start.poses[branch.carrier]
            kind, sign = _kind(freedom, pose.rotation.T @ freedom.axis)
            base = start.point(branch.carrier, self.local.get(branch.carrier, np.zeros(3)))
            self.local[branch.body] = pose.rotation.T @ (freedom.point - pose.position)
            kinds.append(kind)
            offsets.append(carrier.rotation.T @ (freedom.point - base))
            turns.append(carrier.rotation.T @ pose.rotation)
            centres.append(-self.local[branch.body])
            inertias.append(np.array(bodies[branch.body].inertia))
            rates.append(sign * freedom.rate)
        count = len(branches)
        node = self.system.AddNode(
            item.NodeGenericODE2(
                referenceCoordinates=[0.0] * count,
                initialCoordinates=[0.0] * count,
                initialCoordinates_t=rates,
                numberOfODE2Coordinates=count,
            )
        )
        tree = self.system.AddObject(
            item.ObjectKinematicTree(
                nodeNumber=node,
                gravity=list(self.problem.scene.gravity),
                jointTypes=kinds,
                linkParents=[links.get(branch.carrier, -1) for branch in branches],
                jointTransformations=exu.Matrix3DList(turns),
                jointOffsets=exu.Vector3DList(offsets),
                linkInertiasCOM=exu.Matrix3DList(inertias),
                linkCOMs=exu.Vector3DList(centres),
                linkMasses=[bodies[branch.body].mass for branch in branches],
            )
        )
        for branch in branches:
            self.where[branch.body] = (tree, links[branch.body])
            (freedom,) = branch.freedoms
            _, sign = _kind(freedom, start.poses[branch.body].rotation.T @ freedom.axis)
            self.coordinate[freedom.coordinate] = (node, links[branch.body], sign)

    def _loads(self) -> None:
        """Springs, dampers and dry friction on coordinates; those of Exudyn are zero at the start."""
        acting = acting_on(self.problem.scene, lambda *_: None)
        if not acting:
            return
        ground = self.system.AddMarker(
            item.MarkerNodeCoordinate(nodeNumber=self.system.AddNode(item.NodePointGround()), coordinate=0)
        )
        for name, load in acting.items():
            node, number, sign = self.coordinate[name]
            moving = self.system.AddMarker(item.MarkerNodeCoordinate(nodeNumber=node, coordinate=number))
            value = self.start.values[name]
            self.zones.append(
                int(
                    self.system.AddObject(
                        item.CoordinateSpringDamperExt(
                            markerNumbers=[ground, moving],
                            stiffness=load.stiffness,
                            damping=load.damping,
                            offset=sign * (load.rest - value),
                            fDynamicFriction=load.dry,
                            frictionProportionalZone=1e-3,
                        )
                    )
                )
            )

    def _marker(self, body: str, at: Array) -> Any:
        tree, link = self.where[body]
        local = at - self.local[body]
        return self.system.AddMarker(
            item.MarkerKinematicTreeRigid(objectNumber=tree, linkNumber=link, localPosition=local)
        )


def _kind(freedom: TreeFreedom, axis: Array) -> tuple[Any, float]:
    """Exudyn's type of a joint about an axis of a body, and 1 or -1 where it is against that axis; its axes are x, y,
    z."""
    number = int(np.abs(axis).argmax())
    word = {"hinge": "Revolute", "slide": "Prismatic"}[freedom.kind]
    return getattr(exu.JointType, f"{word}{'XYZ'[number]}"), float(np.sign(axis[number]))


def _fixed(model: _Model, step: float, count: int, solver: Any, times: Array) -> Outcome:
    settings = exu.SimulationSettings()
    settings.timeIntegration.endTime = float(times[-1])
    settings.timeIntegration.numberOfSteps = count
    settings.solutionSettings.sensorsWritePeriod = float(times[-1]) / len(times)
    seconds = model.solve(settings, solver, ZONE * step)
    return Outcome(model.seen(times), seconds, model.opened(times))


def _adaptive(model: _Model, tolerance: float, times: Array) -> Outcome:
    """By runs that end at each sample, so that outputs do not shorten steps; the time is that of the last."""
    seen, seconds = [], 0.0
    for time in times:
        settings = exu.SimulationSettings()
        settings.timeIntegration.endTime = settings.solutionSettings.sensorsWritePeriod = float(time)
        settings.timeIntegration.numberOfSteps = 100
        settings.timeIntegration.automaticStepSize = True
        settings.timeIntegration.initialStepSize = 1e-6
        settings.timeIntegration.minimumStepSize = 1e-12
        settings.timeIntegration.absoluteTolerance = settings.timeIntegration.relativeTolerance = tolerance
        seconds = model.solve(settings, exu.DynamicSolverType.DOPRI5)
        seen.append(model.seen(np.array([time]))[0])
    return Outcome(np.array(seen), seconds)


def _steps(problem: Problem, model: _Model, name: str, solvers: tuple[Any, ...]) -> Iterator[Setting]:
    for (step, count), solver in product(problem.steps(name), solvers):
        run = partial(_fixed, model, step, count, solver)
        yield Setting(f"{step_label(step)}, {solver.name}", run, count)


def _explicit(problem: Problem, model: _Model, name: str) -> Iterator[Setting]:
    if problem.tried:
        yield from _steps(problem, model, name, (exu.DynamicSolverType.RK44,))
        return
    for tolerance in tolerances():
        yield Setting(tolerance_label(tolerance), partial(_adaptive, model, tolerance))


def _is_planar(problem: Problem) -> bool:
    """Whether all joints are pins along y, and nothing but bushings acts."""
    along = [np.abs(problem.start.of_joint(joint, "z1"))[1] for joint in problem.scene.joints]
    pins = all(joint.type == "revolute" for joint in problem.scene.joints) and min(along) > 1.0 - 1e-12
    markers = {marker.name for marker in problem.scene.markers}
    return pins and all(isinstance(force, Bushing) for force in problem.scene.forces) and set(problem.watch) <= markers


def programs(problem: Problem) -> Iterator[Program]:
    """Trees, implicit and explicit, where nothing closes a loop; bodies, implicit."""
    scene, tree = problem.scene, problem.tree
    single = all([each.kind for each in branch.freedoms] in (["hinge"], ["slide"]) for branch in tree.branches)
    loaded = any(isinstance(force, JointForce) for force in scene.forces)
    if not tree.loops and single and not any(isinstance(force, PointForce) for force in scene.forces):
        model = Trees(problem)
        if scene.forces:
            yield Program("Exudyn, tree, implicit", partial(_steps, problem, model, "Exudyn, tree, implicit", IMPLICIT))
        if not loaded:
            yield Program("Exudyn, tree, explicit", partial(_explicit, problem, model, "Exudyn, tree, explicit"))
    known = {"revolute", "spherical", "universal", "prismatic", "distance"}
    acted = all(isinstance(force, PointForce) for force in scene.forces)
    if _is_planar(problem) or (acted and {joint.type for joint in scene.joints} <= known and not scene.curves):
        bodies = Planar(problem) if _is_planar(problem) else Spatial(problem)
        yield Program("Exudyn, bodies", partial(_steps, problem, bodies, "Exudyn, bodies", IMPLICIT))
