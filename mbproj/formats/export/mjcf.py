"""Writes a scene as MJCF: nested bodies, equalities that close loops, tendons between points, a keyframe of the
start."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Polynomial

from mbproj.arrays import Array
from mbproj.formats.export.acting import CoordinateLoads, acting_on
from mbproj.formats.export.couplings import CouplingSum, five, sum_of
from mbproj.formats.export.exported import Written, say_unwritten
from mbproj.formats.export.markup import Tag, tag
from mbproj.formats.export.start import start_of
from mbproj.formats.export.tendons import FAR, TendonWriter
from mbproj.formats.export.tree import TreeBranch, TreeFreedom, down, name_counts, tree_of, without_massless
from mbproj.formats.mechanism import Same
from mbproj.formats.placed import quaternion
from mbproj.scene.read import Scene
from mbproj.scene.records import GROUND, Body, Joint
from mbproj.scene.stops import Limit, OfBody

#: The joints that can close a loop in MJCF.
LOOPS = ("spherical", "fixed", "revolute", "distance")


def as_mjcf(scene: Scene, version: str) -> Written:
    """The model, and the table of what it leaves out. Raises InputError, and the errors of assembly, where the scene
    has no start."""
    return _Mjcf(scene).write(version)


class _Mjcf:
    def __init__(self, scene: Scene) -> None:
        self.scene, self.start = scene, start_of(scene)
        self.out = Written("")
        self.bodies = {body.name: body for body in scene.bodies}
        self.tree = without_massless(scene, tree_of(scene, self.start), name_counts(scene))
        self.acting = acting_on(scene, self.out.say)
        self.equality = tag("equality")
        self.tendons = TendonWriter(scene, self.start, self.tree, self.acting, self.equality, self.out.say)

    def write(self, version: str) -> Written:
        """The text of the whole file, with the table."""
        root = tag("mujoco", model=self.scene.title)
        root.add("compiler", angle="radian", inertiafromgeom="false", fusestatic="false")
        root.add("option", gravity=self.scene.gravity)
        self._loops()
        self._couplings()
        self.tendons.forces()
        for marker in self.scene.markers:
            at = self.start.in_body_axes(OfBody(marker.body, marker.location, marker.local))
            self.tendons.site(marker.name, marker.body, at)
        world = root.add("worldbody")
        world.children += self.tendons.marks(GROUND)
        for branch in self.tree.carried(GROUND):
            self._body(world, branch)
        root.children += [each for each in (self.equality, self.tendons.section) if each.children]
        self._keyframe(root)
        lines = {f"{joint.name}.length" for joint in self.tree.loops if joint.type in ("telescope", "rope")}
        acting = {name: acts for name, acts in self.acting.items() if name not in lines}
        say_unwritten(self.scene, self.out.say, tree=self.tree, acting=acting)
        head = f"<!-- Written by mbproj {version}. Angles are in rad; joints begin at their 'ref'. -->"
        self.out.text = "\n".join([head, *root.lines()]) + "\n"
        return self.out

    def _body(self, above: Tag, branch: TreeBranch) -> None:
        body = self.bodies[branch.body]
        pose, carrier = self.start.poses[branch.body], self.start.poses[branch.carrier]
        inner = carrier.inverse().then(pose)
        turned = quaternion(inner.rotation)
        quat = turned if np.abs(turned[1:]).max() > 1e-15 else None
        own = above.add("body", name=body.name, pos=inner.position, quat=quat)
        for freedom in branch.freedoms:
            self._joint(own, freedom, branch.body)
        own.children.append(self._inertial(body))
        own.children += self.tendons.marks(branch.body)
        for each in self.tree.carried(branch.body):
            self._body(own, each)

    def _inertial(self, body: Body) -> Tag:
        inertia = np.array(body.inertia)
        if body.mass <= 0.0 or np.linalg.eigvalsh(inertia).min() <= 0.0:
            what = "has no mass, or a moment of inertia that is zero: MuJoCo refuses it where it moves"
            self.out.say(f"body '{body.name}'", what, Same.NO)
        mixed = [inertia[0, 1], inertia[0, 2], inertia[1, 2]]
        full = np.concatenate([np.diag(inertia), mixed])
        if np.any(mixed):
            return tag("inertial", pos=np.zeros(3), mass=body.mass, fullinertia=full)
        return tag("inertial", pos=np.zeros(3), mass=body.mass, diaginertia=np.diag(inertia))

    def _joint(self, own: Tag, freedom: TreeFreedom, body: str) -> None:
        if freedom.kind == "free":
            own.add("freejoint", name=freedom.name)
            return
        pose = self.start.poses[body]
        at = pose.rotation.T @ (freedom.point - pose.position)
        if freedom.kind == "ball":
            own.add("joint", name=freedom.name, type="ball", pos=at)
            return
        acting = self.acting.get(freedom.coordinate, CoordinateLoads())
        own.add(
            "joint",
            name=freedom.name,
            type=freedom.kind,
            pos=at,
            axis=pose.rotation.T @ freedom.axis,
            ref=freedom.value or None,
            range=self._range(freedom, acting.limit),
            stiffness=acting.stiffness or None,
            springref=acting.rest if acting.stiffness and acting.rest else None,
            damping=acting.damping or None,
            frictionloss=acting.dry or None,
            armature=acting.armature or None,
        )

    def _range(self, freedom: TreeFreedom, limit: Limit | None) -> tuple[float, float] | None:
        if limit is None:
            return None
        what = "a soft limit in MuJoCo, and not that of the scene while it touches"
        self.out.say(f"limit of '{freedom.name}'", what, Same.UNTIL)
        low, high = (-FAR if limit.low is None else limit.low), (FAR if limit.high is None else limit.high)
        return low, high

    def _loops(self) -> None:
        """Write each loop as equalities, which hold at the model's start."""
        for joint in self.tree.loops:
            bodies = [None if body == GROUND else body for body in joint.bodies]
            if bodies[0] is None:
                bodies.reverse()
            if joint.type in ("telescope", "rope"):
                self.tendons.measured(joint)
            elif joint.type not in LOOPS:
                what = f"left out: MJCF has no {joint.type} joint that closes a loop"
                self.out.say(f"joint '{joint.name}'", what, Same.NO)
            elif joint.type == "distance":
                path = self.tendons.line(joint.name, joint.bodies, self.start.ends(joint.bodies, joint.points))
                self.equality.add("tendon", name=joint.name, tendon1=path)
            elif joint.type == "fixed":
                self.equality.add("weld", name=joint.name, body1=bodies[0], body2=bodies[1])
            else:
                self._points(joint, bodies)

    def _points(self, joint: Joint, bodies: list[str | None]) -> None:
        """Write the equality of a point that two bodies share, and of a second one on the axis of a revolute joint."""
        assert bodies[0] is not None
        place = self.start.of_joint(joint, "p1")
        pose = self.start.poses[bodies[0]]
        arm = self._arm() * self.start.of_joint(joint, "z1")
        ends = [("", place)] if joint.type == "spherical" else [("", place), ("_axis", place + arm)]
        for word, point in ends:
            anchor = pose.rotation.T @ (point - pose.position)
            self.equality.add("connect", name=f"{joint.name}{word}", body1=bodies[0], body2=bodies[1], anchor=anchor)
        if len(ends) == 2:
            what = "two points of its axis in MJCF, of whose six rows one is redundant"
            self.out.say(f"joint '{joint.name}'", what, Same.YES)

    def _arm(self) -> float:
        """A typical length of the mechanism, in m."""
        places = np.array([pose.position for pose in self.start.poses.values()])
        return float(f"{max(0.01, np.ptp(places, axis=0).max() / 2):.1g}")

    def _couplings(self) -> None:
        free = self.tree.freedoms
        screws = [joint for joint in self.scene.joints if joint.type == "screw" and joint not in self.tree.loops]
        for joint in [*screws, *(joint for joint in self.scene.joints if joint.couples is not None)]:
            weighted = sum_of(joint, self.start)
            if weighted is None:
                what = "left out: its function is no polynomial of the fourth degree"
                self.out.say(f"coupler '{joint.name}'", what, Same.NO)
            elif not {*weighted.weights, *filter(None, [weighted.first])} <= set(free):
                self.out.say(f"coupling '{joint.name}'", "left out: it couples joints of loops", Same.NO)
            else:
                self._coupled(weighted, free)

    def _coupled(self, coupling: CouplingSum, free: dict[str, TreeFreedom]) -> None:
        """Write y - y₀ = a₀ + a₁ (x - x₀) + ..: an equality of joints where there are two coordinates, else of
        tendons."""
        weights = {name: weight for name, weight in coupling.weights.items() if weight}
        curve, first = coupling.curve, coupling.first
        if curve is not None and first in weights:
            curve = curve - weights.pop(first) * Polynomial([0.0, 1.0])
        elif curve is None and len(weights) == 2:
            first = next(iter(weights))
            curve = -weights.pop(first) * Polynomial([0.0, 1.0])
        if len(weights) == 1:
            ((y, weight),) = weights.items()
            coefficients = None if curve is None else five(curve / weight)
            second = None if curve is None else free[first].name
            self.equality.add("joint", name=coupling.name, joint1=free[y].name, joint2=second, polycoef=coefficients)
            return
        whole = self.tendons.fixed(coupling.name, {free[name].name: weight for name, weight in weights.items()})
        second = None if curve is None else self.tendons.fixed(f"{coupling.name}_of", {free[first].name: 1.0})
        coefficients = None if curve is None else five(curve)
        self.equality.add("tendon", name=coupling.name, tendon1=whole, tendon2=second, polycoef=coefficients)

    def _keyframe(self, root: Tag) -> None:
        """Write a keyframe with the velocities of the start, since a model itself begins at rest."""
        if not self.start.moves:
            return
        qpos: list[Array] = []
        qvel: list[Array] = []
        for branch in down(self.tree, GROUND):
            pose = self.start.poses[branch.body]
            turning = pose.rotation.T @ (self.start.turning[branch.body] - self.start.turning[branch.carrier])
            for freedom in branch.freedoms:
                if freedom.kind == "free":
                    qpos += [pose.position, quaternion(pose.rotation)]
                    qvel += [self.start.velocities[branch.body], turning]
                elif freedom.kind == "ball":
                    qpos.append(np.array([1.0, 0.0, 0.0, 0.0]))
                    qvel.append(turning)
                else:
                    qpos.append(np.array([freedom.value]))
                    qvel.append(np.array([freedom.rate]))
        root.add("keyframe").add("key", name="start", qpos=np.concatenate(qpos), qvel=np.concatenate(qvel))
        self.out.say("velocities at the start", "in the keyframe 'start', which import begins at with --at", Same.YES)
