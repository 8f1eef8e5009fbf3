"""The tree of a scene's bodies that formats of robots need: the joints of the tree, and those that close its loops."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import field, replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.formats.export.start import Start
from mbproj.joints import JOINTS
from mbproj.scene.read import Scene
from mbproj.scene.records import GROUND, Joint, JointForce

#: The joints that may be in a tree; the first of them cannot be written as a loop in formats of robots.
IN_TREE = (
    *("prismatic", "cylindrical", "planar", "universal", "screw", "point_on_line", "point_in_plane"),
    *("fixed", "revolute", "spherical"),
)


@dataclass(frozen=True, eq=False)
class TreeFreedom:
    """A freedom of a joint: a "hinge", a "slide", a "ball", or all six of a "free" body. `name` is that of the joint
    where it has one coordinate, else it ends with that of the coordinate. `point` and unit `axis` are global at the
    start. `coordinate` is "joint.angle", with its value and its rate; "" where the scene has none."""

    kind: str
    name: str
    point: Array
    axis: Array = field(default_factory=lambda: np.zeros(3))
    coordinate: str = ""
    value: float = 0.0
    rate: float = 0.0


@dataclass(frozen=True, eq=False)
class TreeBranch:
    """A body, its carrier, and the freedoms between them, in order from the carrier on."""

    body: str
    carrier: str
    freedoms: tuple[TreeFreedom, ...]
    joint: str = ""


@dataclass(frozen=True, eq=False)
class Tree:
    """The branches from the ground on, each after its carrier's, and the joints that close loops."""

    branches: tuple[TreeBranch, ...]
    loops: tuple[Joint, ...]

    def carried(self, body: str) -> Iterator[TreeBranch]:
        """The branches that a body carries."""
        return (branch for branch in self.branches if branch.carrier == body)

    @property
    def freedoms(self) -> dict[str, TreeFreedom]:
        """The freedoms that have a coordinate, by its name."""
        return {each.coordinate: each for branch in self.branches for each in branch.freedoms if each.coordinate}


def tree_of(scene: Scene, start: Start, able: tuple[str, ...] = IN_TREE) -> Tree:
    """A tree of joints of the types in `able`. It prefers joints on whose coordinates something acts."""
    acted = _acted_on(scene)
    own = [joint for joint in scene.joints if JOINTS[joint.type].frame != "joints"]
    wanted = sorted(
        (joint for joint in own if joint.type in able),
        key=lambda joint: (joint.name not in acted, able.index(joint.type)),
    )
    group = {body.name: body.name for body in scene.bodies} | {GROUND: GROUND}
    chosen: dict[str, Joint] = {}
    for joint in wanted:
        first, second = (group[body] for body in joint.bodies)
        if first != second:
            chosen[joint.name] = joint
            group = {body: first if each == second else each for body, each in group.items()}
    kept = [joint for joint in own if joint.name in chosen]
    branches = tuple(_branches(scene, start, kept))
    return Tree(branches, tuple(joint for joint in own if joint.name not in chosen))


def _acted_on(scene: Scene) -> set[str]:
    """The names of the joints that should be in the tree: something acts on their coordinates, or couples them."""
    joints = {force.joint for force in scene.forces if isinstance(force, JointForce)}
    joints |= {motion.joint for motion in scene.motions}
    for joint in scene.joints:
        if joint.reflected_inertia or joint.limits:
            joints.add(joint.name)
        if joint.couples is not None:
            joints |= set(joint.couples.joints)
    return joints


def _branches(scene: Scene, start: Start, joints: list[Joint]) -> Iterator[TreeBranch]:
    done, waiting = {GROUND}, [GROUND]
    for begin in [GROUND, *(body.name for body in scene.bodies)]:
        if begin not in done:
            pose = start.poses[begin]
            done.add(begin)
            waiting.append(begin)
            yield TreeBranch(begin, GROUND, (TreeFreedom("free", f"{begin}_free", pose.position),))
        while waiting:
            carrier = waiting.pop(0)
            for joint in joints:
                if carrier not in joint.bodies:
                    continue
                back = joint.bodies[1] == carrier
                body = joint.bodies[0] if back else joint.bodies[1]
                if body not in done:
                    done.add(body)
                    waiting.append(body)
                    yield TreeBranch(body, carrier, freedoms(joint, start, back), joint.name)


def freedoms(joint: Joint, start: Start, back: bool) -> tuple[TreeFreedom, ...]:
    """The freedoms of the second body of a joint against the first, or with `back` of the first against the second.

    Back reverses each axis, and their order too: the inverse of R₁(θ₁) R₂(θ₂) is R₂(-θ₂) R₁(-θ₁)."""
    point = start.of_joint(joint, "p2")
    kinds = _kinds(joint, start)
    alone = sum(1 for _, coordinate, _ in kinds if coordinate) == 1 and len(kinds) == 1
    free = []
    for kind, coordinate, axis in kinds:
        name = f"{joint.name}.{coordinate}" if coordinate else ""
        called = joint.name if alone or not coordinate else f"{joint.name}_{coordinate}"
        value, rate = start.values.get(name, 0.0), start.rates.get(name, 0.0)
        free.append(TreeFreedom(kind, called, point, -axis if back else axis, name, value, rate))
    return tuple(reversed(free) if back else free)


def _kinds(joint: Joint, start: Start) -> list[tuple[str, str, Array]]:
    """The (kind, coordinate, axis) of each freedom of a joint, from the first body on."""
    x, y, z, z2 = (start.of_joint(joint, symbol) for symbol in ("x1", "y1", "z1", "z2"))
    return {
        "fixed": [],
        "revolute": [("hinge", "angle", z)],
        "prismatic": [("slide", "displacement", z)],
        "spherical": [("ball", "", np.zeros(3))],
        "universal": [("hinge", "angle_1", z), ("hinge", "angle_2", z2)],
        "cylindrical": [("slide", "displacement", z), ("hinge", "angle", z)],
        "screw": [("slide", "displacement", z), ("hinge", "angle", z)],
        "planar": [("slide", "displacement_x", x), ("slide", "displacement_y", y), ("hinge", "angle", z)],
        "point_on_line": [("slide", "displacement", z), ("ball", "", np.zeros(3))],
        "point_in_plane": [("slide", "displacement_x", x), ("slide", "displacement_y", y), ("ball", "", np.zeros(3))],
    }[joint.type]


def without_massless(scene: Scene, tree: Tree, named: Mapping[str, int]) -> Tree:
    """The tree without massless bodies between two others: each gives its freedoms to the body that it carries. Bodies
    that loops, forces or markers name stay; `named` counts these names."""
    massless = {body.name for body in scene.bodies if not body.mass and not np.any(body.inertia)}
    branches = {branch.body: branch for branch in tree.branches}
    for name in massless:
        carried = [branch for branch in branches.values() if branch.carrier == name]
        own = branches[name]
        single = {each.kind for branch in (own, *carried) for each in branch.freedoms} <= {"hinge", "slide"}
        if len(carried) == 1 and single and not named.get(name):
            (outer,) = carried
            joined = (*own.freedoms, *outer.freedoms)
            branches[outer.body] = replace(outer, carrier=own.carrier, freedoms=joined)
            del branches[name]
    return replace(tree, branches=tuple(branches.values()))


def down(tree: Tree, body: str) -> list[TreeBranch]:
    """The branches that a body carries, directly or not, in the order of the file."""
    branches = []
    for branch in tree.carried(body):
        branches += [branch, *down(tree, branch.body)]
    return branches


def name_counts(scene: Scene) -> Counter[str]:
    """The number of loops, forces and markers that name each body. A named body is needed, and cannot be removed."""
    names: Counter[str] = Counter(marker.body for marker in scene.markers)
    for force in scene.forces:
        names.update(getattr(force, "bodies", ()))
        names.update([body for body in [getattr(force, "body", None)] if body])
        for end in ("first", "second", "point", "location"):
            if hasattr(getattr(force, end, None), "body"):
                names[getattr(force, end).body] += 1
    joints: Counter[str] = Counter()
    for joint in scene.joints:
        if joint.couples is None:
            joints.update(joint.bodies)
    names.update({name: 1 for name, often in joints.items() if often != 2})
    return names
