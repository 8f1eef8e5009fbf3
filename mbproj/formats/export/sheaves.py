"""The run of a scene's rope over points and sheaves in one plane, where a tendon of MJCF can have the same."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.formats.chains import EXACT
from mbproj.formats.export.start import Start
from mbproj.formats.export.tree import Tree, TreeFreedom
from mbproj.scene.blocks.ropes.path import Node, Path, axes, straight
from mbproj.scene.records import GROUND, Joint, Vector
from mbproj.scene.stops import OfBody

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
    normal = start.poses[path.frame].rotation @ start.given[path.frame].rotation.T @ np.array(path.normal)
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
