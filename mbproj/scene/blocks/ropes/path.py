"""The path of a rope: its places, and the directions of the rope between them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

from mbproj.dataclass import dataclass
from mbproj.scene.fields.rotations import cross, unit
from mbproj.scene.records import GROUND, Vector
from mbproj.scene.stops import OfBody
from mbproj.thresholds import THRESHOLDS

#: The kinds of places of a path: points, sheaves over which the rope slides, wheels and drums that turn with it.
KINDS = ("point", "sheave", "wheel", "drum")


@dataclass(frozen=True)
class Node:
    """A place of a path on a `body`; `kind` is one of KINDS. It is a point, or a circle of `radius` m about the centre
    `at`. Looking against the normal, the rope bends `left` or right on the circle. It is wound around it by `turns`
    additional whole turns.

    A rope rubs on a sheave that has a coefficient of `friction`. It may leave a sheave that `lifts`, and return."""

    kind: str
    body: str
    at: OfBody
    radius: float = 0.0
    left: bool = True
    turns: int = 0
    friction: float | None = None
    lifts: bool = False

    @property
    def signed_radius(self) -> float:
        """The radius in m, positive where the rope bends left."""
        return self.radius if self.left else -self.radius


@dataclass(frozen=True)
class Path:
    """The places over which a rope runs, and the plane of the rope. The body `frame` carries the plane; the `normal` is
    that at the scene's pose. Where `taut`, a row keeps the length; else only limits or motions act on it."""

    nodes: tuple[Node, ...]
    normal: Vector
    frame: str = GROUND
    taut: bool = True

    @property
    def portions(self) -> int:
        """The number of portions with tensions of their own. Each wheel that turns, and each sheave with friction, ends
        one."""
        return 1 + sum(node.kind == "wheel" or node.friction is not None for node in self.nodes)

    @property
    def lifting(self) -> tuple[int, ...]:
        """The numbers of the sheaves that the rope may leave."""
        return tuple(k for k, node in enumerate(self.nodes) if node.lifts)

    @property
    def rubbing(self) -> tuple[int, ...]:
        """The numbers of the sheaves on which the rope rubs."""
        return tuple(k for k, node in enumerate(self.nodes) if node.friction is not None)

    def changed(self, place: Callable[[OfBody], OfBody], normal: Callable[[Vector], Vector], size: float = 1.0) -> Path:
        """The path whose places and normal are changed by these functions, with its radii times `size`."""
        nodes = [replace(node, at=place(node.at), radius=size * node.radius) for node in self.nodes]
        return replace(self, nodes=tuple(nodes), normal=normal(self.normal))


def dot(axis: Vector, vector: Vector) -> float:
    return sum(a * b for a, b in zip(axis, vector, strict=True))


def axes(normal: Vector) -> tuple[Vector, Vector, Vector]:
    """The unit vectors x, y and n of a plane with this normal."""
    size = math.hypot(*normal)
    n: Vector = (normal[0] / size, normal[1] / size, normal[2] / size)
    least = min(range(3), key=lambda k: (abs(n[k]), k))
    x = unit([float(k == least) - n[least] * n[k] for k in range(3)])
    assert x is not None
    first: Vector = (x[0], x[1], x[2])
    return first, cross(n, first), n


def straight(path: Path) -> tuple[list[float], list[float]]:
    """Directions at the scene's pose in rad, from x of `axes`: β of the lines between the centres of a path, and θ of
    the straight parts of the rope. Each circle between the ends is wrapped by less than a turn, plus its `turns`."""
    x, y, _ = axes(path.normal)
    seen = [[dot(axis, node.at.vector) for axis in (x, y)] for node in path.nodes]
    lines: list[float] = []
    ropes: list[float] = []
    for k, (start, end) in enumerate(pairwise(seen)):
        first, second = path.nodes[k], path.nodes[k + 1]
        across, up = end[0] - start[0], end[1] - start[1]
        off = math.asin((first.signed_radius - second.signed_radius) / math.hypot(across, up))
        θ = math.atan2(up, across) + off
        if k and first.radius:
            side = 1.0 if first.left else -1.0
            wrap = side * (θ - ropes[-1]) % (2.0 * math.pi)
            off = first.lifts and wrap > THRESHOLDS.wrong_side
            θ = ropes[-1] + side * (wrap + 2.0 * math.pi * (-1 if off else first.turns))
        lines.append(θ - off)
        ropes.append(θ)
    return lines, ropes
