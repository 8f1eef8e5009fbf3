"""Writes a scene as URDF: links with the global axes at the start, and its loops in a YAML file beside it."""

from __future__ import annotations

import numpy as np

from mbproj.base.arrays import Array
from mbproj.formats.export.exported import Tag, Written, say_unwritten, tag
from mbproj.formats.export.tree import CoordinateLoads, TreeBranch, TreeFreedom, acting_on, start_of, sum_of, tree_of
from mbproj.formats.mechanism import ImportedNames, Same
from mbproj.formats.yaml_text import flow, lines
from mbproj.scene.records import GROUND, DistanceStop, Joint, Limit, PointForce
from mbproj.scene.scene import Scene

#: The joints that may be in the tree. URDF has no ball: a spherical joint becomes a loop between free bodies.
IN_TREE = ("prismatic", "cylindrical", "planar", "universal", "screw", "fixed", "revolute")
#: The gravity that readers of URDF assume, in m/s².
GRAVITY = (0.0, 0.0, -9.81)
#: The other bound of a limit with one side, in m or rad, and the effort of a drive that nothing limits.
FAR, STRONG = 1e6, 1e6


def as_urdf(scene: Scene, version: str) -> Written:
    """The model, its loops, and the table of what it leaves out. Raises InputError, and the errors of assembly, where
    the scene has no start."""
    return _Urdf(scene).write(version)


class _Urdf:
    def __init__(self, scene: Scene) -> None:
        self.scene, self.start = scene, start_of(scene)
        self.out = Written("")
        self.bodies = {body.name: body for body in scene.bodies}
        self.tree = tree_of(scene, self.start, IN_TREE)
        self.acting = acting_on(scene, self.out.say)
        self.links = ImportedNames(frozenset({"world", *self.bodies}))
        self.joints = ImportedNames()
        self.places = {GROUND: np.zeros(3)}
        self.root = tag("robot", name=scene.title)
        self.mimics: dict[str, Tag] = {}
        self.loops: list[tuple[str, str, str]] = []

    def write(self, version: str) -> Written:
        """The texts of both files, with the table."""
        self._couplings()
        self.root.add("link", name="world")
        for branch in self.tree.branches:
            self._branch(branch)
        for joint in self.tree.loops:
            self._loop(joint)
        self._say_rest()
        head = f"<!-- Written by mbproj {version}. Links have the global axes at the start, where joints are zero. -->"
        self.out.text = "\n".join([head, *self.root.lines()]) + "\n"
        if self.loops:
            rows = [f"# Loops of {flow(self.scene.title)}.", "closed_loop:"]
            rows += [f"  - [{flow(first)}, {flow(second)}]" for first, second, _ in self.loops]
            rows += lines("type", [kind for _, _, kind in self.loops], 0)
            self.out.loops = "\n".join(rows) + "\n"
        return self.out

    def _called(self, body: str) -> str:
        return "world" if body == GROUND else body

    def _branch(self, branch: TreeBranch) -> None:
        """Write the joints of a branch in a row, with massless links between. The frame of a link is at its joint."""
        pose = self.start.poses[branch.body]
        freedoms = branch.freedoms or (TreeFreedom("fixed", branch.joint, pose.position),)
        carrier = self._called(branch.carrier)
        for at, freedom in enumerate(freedoms):
            last = at == len(freedoms) - 1
            link = branch.body if last else self.links.unused(f"{branch.body}_after_{freedom.name}")
            self._joint(freedom, carrier, link)
            self.places[link] = freedom.point
            if last:
                self._link(branch.body)
            else:
                self.root.add("link", name=link)
            carrier = link

    def _link(self, name: str) -> None:
        body, pose = self.bodies[name], self.start.poses[name]
        link = self.root.add("link", name=name)
        if not body.mass and not np.any(body.inertia):
            return
        inertial = link.add("inertial")
        inertial.add("origin", xyz=pose.position - self.places[name])
        inertial.add("mass", value=body.mass)
        i = pose.rotation @ np.array(body.inertia) @ pose.rotation.T
        inertial.add("inertia", ixx=i[0, 0], iyy=i[1, 1], izz=i[2, 2], ixy=i[0, 1], ixz=i[0, 2], iyz=i[1, 2])

    def _joint(self, freedom: TreeFreedom, carrier: str, link: str) -> None:
        acting = self.acting.get(freedom.coordinate, CoordinateLoads())
        kind = {"free": "floating", "fixed": "fixed", "slide": "prismatic"}.get(freedom.kind, "continuous")
        if kind == "continuous" and acting.limit is not None:
            kind = "revolute"
        joint = self.root.add("joint", name=self.joints.unused(freedom.name), type=kind)
        joint.add("parent", link=carrier)
        joint.add("child", link=link)
        joint.add("origin", xyz=freedom.point - self._place(carrier))
        if freedom.kind not in ("hinge", "slide"):
            return
        joint.add("axis", xyz=freedom.axis)
        if kind != "continuous":
            low, high = self._range(freedom, acting.limit)
            joint.add("limit", lower=low, upper=high, effort=STRONG, velocity=STRONG)
        if acting.damping or acting.dry:
            joint.add("dynamics", damping=acting.damping, friction=acting.dry)
        if freedom.coordinate in self.mimics:
            joint.children.append(self.mimics[freedom.coordinate])
        for word, value in (("spring", acting.stiffness), ("reflected inertia", acting.armature)):
            if value:
                self.out.say(f"{word} of '{freedom.name}'", "left out: URDF has none", Same.NO)

    def _range(self, freedom: TreeFreedom, limit: Limit | None) -> tuple[float, float]:
        """The range of a joint's coordinate, counted from its value at the start."""
        low = -FAR if limit is None or limit.low is None else limit.low - freedom.value
        high = FAR if limit is None or limit.high is None else limit.high - freedom.value
        return low, high

    def _place(self, link: str) -> Array:
        return np.zeros(3) if link == "world" else self.places[link]

    def _frame(self, name: str, body: str, point: Array) -> str:
        """Add a massless link at a point of a body, and return its name."""
        link, carrier = self.links.unused(name), self._called(body)
        self.root.add("link", name=link)
        joint = self.root.add("joint", name=self.joints.unused(f"{name}_joint"), type="fixed")
        joint.add("parent", link=carrier)
        joint.add("child", link=link)
        joint.add("origin", xyz=point - self._place(carrier))
        return link

    def _loop(self, joint: Joint) -> None:
        """Write a loop: one point, two points for a revolute joint, or a frame."""
        if joint.type == "telescope":
            if f"{joint.name}.length" not in self.acting:
                what = "left out: nothing acts along it, and it holds nothing"
                self.out.say(f"joint '{joint.name}'", what, Same.YES)
            return
        if joint.type not in ("spherical", "revolute", "fixed"):
            what = f"left out: no {joint.type} joint closes a loop of URDF"
            self.out.say(f"joint '{joint.name}'", what, Same.NO)
            return
        place = self.start.of_joint(joint, "p1")
        points = {joint.name: place}
        if joint.type == "revolute":
            places = np.array([pose.position for pose in self.start.poses.values()])
            arm = float(f"{max(0.01, np.ptp(places, axis=0).max() / 2):.1g}")
            points[f"{joint.name}_axis"] = place + arm * self.start.of_joint(joint, "z1")
            what = "two points of its axis beside the URDF, of whose six rows one is redundant"
            self.out.say(f"joint '{joint.name}'", what, Same.YES)
        for name, point in points.items():
            ends = [self._frame(f"{name}_{side}", body, point) for side, body in zip((1, 2), joint.bodies, strict=True)]
            self.loops.append((ends[0], ends[1], "6d" if joint.type == "fixed" else "3d"))

    def _couplings(self) -> None:
        """Write couplings: one coordinate as a multiple of another is a mimic, others are left out."""
        free = self.tree.freedoms
        screws = [joint for joint in self.scene.joints if joint.type == "screw" and joint not in self.tree.loops]
        for joint in [*screws, *(joint for joint in self.scene.joints if joint.couples is not None)]:
            weighted = sum_of(joint, self.start)
            weights = {} if weighted is None else {name: each for name, each in weighted.weights.items() if each}
            able = weighted is not None and weighted.curve is None and len(weights) == 2 and set(weights) <= set(free)
            follower = next((name for name in reversed(list(weights)) if name not in self.mimics), "")
            if not able or not follower:
                self.out.say(f"coupling '{joint.name}'", "left out: it is no mimic of URDF", Same.NO)
                continue
            ratio = weights.pop(follower)
            ((leader, weight),) = weights.items()
            self.mimics[follower] = tag("mimic", joint=free[leader].name, multiplier=-weight / ratio)

    def _say_rest(self) -> None:
        say = self.out.say
        if tuple(self.scene.gravity) != GRAVITY:
            what = f"left out: readers of URDF take {flow(np.array(GRAVITY))} m/s^2"
            say(f"gravity {flow(np.array(self.scene.gravity))}", what, Same.NO)
        if self.start.moves:
            say("velocities at the start", "left out: URDF begins at rest", Same.NO)
        shifted = [each.name for each in self.tree.freedoms.values() if each.value]
        if shifted:
            say(f"{len(shifted)} joints", "their coordinates are zero at the start, not at the scene's zero", Same.YES)
        for force in self.scene.forces:
            if isinstance(force, PointForce | DistanceStop):
                same = Same.UNTIL if isinstance(force, DistanceStop) else Same.NO
                say(f"force '{force.name}'", "left out: URDF has none between two points", same)
        if self.scene.markers:
            say(f"{len(self.scene.markers)} markers", "left out: they do not act on the motion", Same.YES)
        say_unwritten(self.scene, say, tree=self.tree, acting=self.acting)
