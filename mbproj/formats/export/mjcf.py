"""Writes a scene as MJCF: nested bodies, equalities that close loops, tendons between points, a keyframe of the
start.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.polynomial import Polynomial

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.formats.chains import EXACT
from mbproj.formats.export.exported import Tag, Written, say_unwritten, tag
from mbproj.formats.export.tree import (
    CoordinateLoads,
    CouplingSum,
    Say,
    Start,
    Tree,
    TreeBranch,
    TreeFreedom,
    acting_on,
    down,
    five,
    left_out,
    name_counts,
    start_of,
    sum_of,
    tree_of,
    without_massless,
)
from mbproj.formats.geometry import quaternion
from mbproj.formats.mechanism import ImportedNames, Same
from mbproj.scene.blocks.ropes import Node, Path, axes, straight
from mbproj.scene.records import GROUND, Body, DistanceStop, Joint, Limit, OfBody, PointForce, Vector
from mbproj.scene.scene import Scene

# --- Parts of a scene as tendons of MJCF ------------------------------------------------------------------------------
# Ropes, telescopes, springs and stops between points, sums of coordinates.


#: The other bound of a limit with one side, in m: beyond every coordinate.
FAR = 1e6


@dataclass(eq=False)
class TendonWriter:
    """Writes the `section` of tendons of a model; `on` has the sites and shapes that they run over, by body. `equality`
    is the section of equalities."""

    scene: Scene
    start: Start
    tree: Tree
    acting: Mapping[str, CoordinateLoads]
    equality: Tag
    say: Say
    section: Tag = field(default_factory=lambda: tag("tendon"))
    on: dict[str, list[Tag]] = field(default_factory=dict)
    names: ImportedNames = field(default_factory=ImportedNames)

    def marks(self, body: str) -> list[Tag]:
        """The sites and shapes of a body."""
        return self.on.get(body, [])

    def site(self, name: str, body: str, at: Array) -> str:
        """Add a site to a body, and return its name."""
        self.on.setdefault(body, []).append(tag("site", name=name, pos=at))
        return name

    def line(self, name: str, bodies: tuple[str, str], ends: list[Array], **attributes: object) -> str:
        """Add a tendon between two points, and return its name."""
        sites = [self.site(f"{name}_{side}", body, end) for side, body, end in zip((1, 2), bodies, ends, strict=True)]
        return self._path(name, [("site", {"site": site}) for site in sites], attributes)

    def fixed(self, name: str, weights: Mapping[str, float]) -> str:
        """Add a fixed tendon, a weighted sum of joint coordinates, and return its name."""
        tendon = self.section.add("fixed", name=self.names.unused(name))
        for joint, weight in weights.items():
            tendon.add("joint", joint=joint, coef=weight)
        return str(tendon.attributes["name"])

    def measured(self, joint: Joint) -> None:
        """Write a telescope or a rope as a tendon, with the forces along it. Where nothing acts along a telescope, it
        is left out."""
        acting = self.acting.get(f"{joint.name}.length")
        taut = joint.type == "rope" and joint.parameters["path"].taut
        if acting is None and not taut:
            what = "left out: nothing acts along it, and it holds nothing"
            self.say(f"joint '{joint.name}'", what, Same.YES)
            return
        run = run_of(joint, self.start, self.tree) if joint.type == "rope" else None
        if isinstance(run, str):
            self.say(f"joint '{joint.name}'", f"left out: {run}", Same.NO)
            return
        attributes = self._attributes(joint, acting or CoordinateLoads(), round_shapes=bool(run and run.shapes))
        if run is None:
            self.line(joint.name, joint.bodies, self.start.ends(joint.bodies, joint.points), **attributes)
            return
        name = self._run(joint, run, attributes)
        if taut:
            length = joint.parameters.get("length")
            away = None if length is None else float(length - run.length)
            coefficients = [away, 0.0, 0.0, 0.0, 0.0] if away is not None and abs(away) > 1e-12 else None
            self.equality.add("tendon", name=joint.name, tendon1=name, polycoef=coefficients)
        if run.shapes:
            what = "a tendon around cylinders, which leaves them where the rope would"
            self.say(f"joint '{joint.name}'", what, Same.YES)

    def forces(self) -> None:
        """Write the springs and stops between two points."""
        for force in self.scene.forces:
            if isinstance(force, PointForce) and force.element is not None:
                self.say(f"force '{force.name}'", left_out(force.element), Same.NO)
            elif isinstance(force, PointForce):
                self._spring(force)
            elif isinstance(force, DistanceStop):
                bodies = (force.first.body, force.second.body)
                ends = [self.start.in_body_axes(force.first), self.start.in_body_axes(force.second)]
                self.line(force.name, bodies, ends, range=_range(force.limit))
                self.say(f"stop '{force.name}'", "a soft limit in MuJoCo", Same.UNTIL)

    def _spring(self, force: PointForce) -> None:
        if force.law.function is not None:
            self.say(f"force '{force.name}'", "left out: its law is a function", Same.NO)
            return
        ends = self.start.ends(force.bodies, force.points)
        rest = force.law.free if force.law.free is not None else self._given_length(force.bodies, ends)
        stiffness, damping = force.law.stiffness or None, force.law.damping or None
        length = rest if force.law.stiffness else None
        self.line(force.name, force.bodies, ends, stiffness=stiffness, springlength=length, damping=damping)

    def _given_length(self, bodies: tuple[str, str], ends: list[Array]) -> float:
        """The distance in m of two points at the scene's pose: the free length of a spring that gives none."""
        places = [self.start.file_poses[body] for body in bodies]
        first, second = (pose.position + pose.rotation @ end for pose, end in zip(places, ends, strict=True))
        return float(np.linalg.norm(second - first))

    def _attributes(self, joint: Joint, acting: CoordinateLoads, *, round_shapes: bool) -> dict[str, object]:
        """The attributes of a tendon for all that acts along a coordinate `length`."""
        limit, element = acting.limit, f"joint '{joint.name}'"
        rest: tuple[float, ...] = (acting.rest,)
        stiffness, span = acting.stiffness, None
        if limit is not None and math.isfinite(limit.law.stiffness) and not acting.stiffness and limit.low is None:
            assert limit.high is not None
            stiffness, rest = limit.law.stiffness, (0.0, limit.high)
            if limit.law.damping or limit.law.restitution or limit.law.exponent != 1.0:
                self.say(element, "the damping of its stretch is left out", Same.NO)
        elif limit is not None:
            span = _range(limit)
            self.say(f"limit of '{joint.name}'", "a soft limit in MuJoCo", Same.UNTIL)
        if acting.armature and round_shapes:
            self.say(f"reflected inertia of '{joint.name}'", "left out: MuJoCo has none around shapes", Same.NO)
        return {
            "range": span,
            "stiffness": stiffness or None,
            "springlength": rest if stiffness else None,
            "damping": acting.damping or None,
            "frictionloss": acting.dry or None,
            "armature": None if round_shapes else acting.armature or None,
        }

    def _run(self, joint: Joint, run: RopeRun, attributes: dict[str, object]) -> str:
        """Add a tendon over the places of a rope, and return its name."""
        path: list[tuple[str, dict[str, str]]] = []
        for number, (body, at) in enumerate(run.points, 1):
            if number - 1 not in run.shapes:
                path.append(("site", {"site": self.site(f"{joint.name}_{number}", body, at)}))
                continue
            shape = run.shapes[number - 1]
            name, side = f"{joint.name}_sheave_{number}", self.site(f"{joint.name}_side_{number}", body, shape.side)
            geom = tag(
                "geom",
                name=name,
                type="cylinder",
                size=(shape.radius, 0.1 * shape.radius),
                pos=at,
                zaxis=shape.normal,
                contype=0,
                conaffinity=0,
            )
            self.on.setdefault(body, []).append(geom)
            path.append(("geom", {"geom": name, "sidesite": side}))
        return self._path(joint.name, path, attributes)

    def _path(self, name: str, over: list[tuple[str, dict[str, str]]], attributes: Mapping[str, object]) -> str:
        path = tag("spatial", name=self.names.unused(name), **attributes)
        for kind, words in over:
            path.add(kind, **words)
        self.section.children.append(path)
        return str(path.attributes["name"])


def _range(limit: Limit) -> tuple[float, float]:
    return limit.low or 0.0, FAR if limit.high is None else limit.high


# --- A rope over points and sheaves in one plane ----------------------------------------------------------------------
# A tendon of MJCF can have the same run.


#: The distance, in radii, of a side site from the centre of its circle; it tells on which side a tendon passes.
ASIDE = 1.5


class Sheave(NamedTuple):
    """A circle: its radius in m, its normal and a point on the side of the rope, both in the axes of its body."""

    radius: float
    normal: Array
    side: Array


@dataclass(frozen=True, eq=False)
class RopeRun:
    """The run of a rope. `points` are the places in order, each a body and a point from its centre of mass in its axes;
    `shapes` are the sheaves, by the number of the place; `length` is that at the start in m."""

    points: list[tuple[str, Array]]
    shapes: Mapping[int, Sheave]
    length: float


def run_of(joint: Joint, start: Start, tree: Tree) -> RopeRun | str:
    """The run of a rope, or the reason why no tendon can have it."""
    path: Path = joint.parameters["path"]
    wrong = _why_no_tendon(path.nodes)
    if wrong:
        return wrong
    points = [(node.body, start.in_body_axes(node.at)) for node in path.nodes]
    normal = start.poses[path.frame].rotation @ start.file_poses[path.frame].rotation.T @ np.array(path.normal)
    normal /= np.linalg.norm(normal)
    here = path.changed(
        lambda at: OfBody(at.body, _vector(start.point(at.body, start.in_body_axes(at)))), lambda _: _vector(normal)
    )
    circles = [number for number, node in enumerate(path.nodes) if node.radius]
    for number in circles:
        beside = here.nodes[number - 1 : number + 2]
        heights = [float(normal @ np.array(node.at.vector)) for node in beside]
        if max(heights) - min(heights) > EXACT:
            return f"it leans at its place {number + 1}, and a tendon runs along a helix there"
        if not all(_stays(tree, node.body, path.frame, normal) for node in beside):
            return f"what it touches at its place {number + 1} moves out of its plane"
    _, ropes = straight(here)
    off = [k + 1 for k in path.lifting if (ropes[k] - ropes[k - 1]) * path.nodes[k].signed_radius < 0.0]
    if off:
        return f"it is off its place {off[0]} at the start"
    x, y, _ = (np.array(axis) for axis in axes(here.normal))
    shapes = {}
    for number in circles:
        node = here.nodes[number]
        middle = 0.5 * (ropes[number - 1] + ropes[number]) + (-0.5 if node.left else 0.5) * np.pi
        out = np.array(node.at.vector) + ASIDE * node.radius * (np.cos(middle) * x + np.sin(middle) * y)
        pose = start.poses[node.body]
        side = pose.rotation.T @ (out - pose.position)
        shapes[number] = Sheave(node.radius, pose.rotation.T @ normal, side)
    return RopeRun(points, shapes, _length(here, ropes))


def _why_no_tendon(nodes: tuple[Node, ...]) -> str:
    """The reason why no tendon has these places: wheels, whole turns, two circles without a point between. "" where a
    tendon can."""
    kinds = {node.kind for node in nodes} - {"point", "sheave"}
    if kinds:
        return f"no tendon turns the {min(kinds)} that it runs over"
    if any(node.friction for node in nodes):
        return "no tendon rubs on what it runs over"
    if any(node.turns for node in nodes):
        return "no tendon has whole turns around a shape"
    if any(one.radius and other.radius for one, other in pairwise(nodes)):
        return "a tendon has a point between two shapes"
    return ""


def _vector(values: Array) -> Vector:
    x, y, z = values.tolist()
    return x, y, z


def _stays(tree: Tree, one: str, other: str, normal: Array) -> bool:
    """Whether the relative motion of two bodies is in the plane: turns about its normal, and slides normal to that."""
    first, second = _above(tree, one), _above(tree, other)
    for name in {*first} ^ {*second}:
        for freedom in (first | second)[name]:
            if freedom.kind not in ("hinge", "slide"):
                return False
            turns = freedom.kind == "hinge"
            off = np.linalg.norm(np.cross(freedom.axis, normal)) if turns else abs(freedom.axis @ normal)
            if off > EXACT:
                return False
    return True


def _above(tree: Tree, body: str) -> dict[str, tuple[TreeFreedom, ...]]:
    """The freedoms between a body and the ground, by the body that they carry."""
    branches = {branch.body: branch for branch in tree.branches}
    above = {}
    while body != GROUND:
        above[body] = branches[body].freedoms
        body = branches[body].carrier
    return above


def _length(path: Path, ropes: list[float]) -> float:
    total = 0.0
    for number, (start, end) in enumerate(pairwise(path.nodes)):
        far = np.subtract(end.at.vector, start.at.vector)
        total += float(np.sqrt(far @ far - (start.signed_radius - end.signed_radius) ** 2))
        if number and start.radius:
            total += start.signed_radius * (ropes[number] - ropes[number - 1])
    return total


# --- Writes a scene as MJCF -------------------------------------------------------------------------------------------


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
        body_tag = above.add("body", name=body.name, pos=inner.position, quat=quat)
        for freedom in branch.freedoms:
            self._joint(body_tag, freedom, branch.body)
        body_tag.children.append(self._inertial(body))
        body_tag.children += self.tendons.marks(branch.body)
        for each in self.tree.carried(branch.body):
            self._body(body_tag, each)

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

    def _joint(self, body_tag: Tag, freedom: TreeFreedom, body: str) -> None:
        if freedom.kind == "free":
            body_tag.add("freejoint", name=freedom.name)
            return
        pose = self.start.poses[body]
        at = pose.rotation.T @ (freedom.point - pose.position)
        if freedom.kind == "ball":
            body_tag.add("joint", name=freedom.name, type="ball", pos=at)
            return
        acting = self.acting.get(freedom.coordinate, CoordinateLoads())
        body_tag.add(
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
