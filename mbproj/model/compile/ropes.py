"""Ropes: the coordinates of their paths, and the rows that keep their lengths.

A wheel or drum that turns with the rope divides it into portions. Each portion has its own row: its length changes by
the rope that the wheels at its ends wind up or unwind. The multiplier of the row is the tension of the portion.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.errors import InputError, Place, Problem
from mbproj.joints.primitives.basic import Angle
from mbproj.joints.primitives.coupling import Coupling
from mbproj.joints.primitives.rope import Rope
from mbproj.model.compile.contacts import local_point, seated
from mbproj.model.compile.couplings import common_measure
from mbproj.model.compile.frames import Pose, Seat
from mbproj.model.primitive_set import Binding
from mbproj.scene.blocks.ropes import Node, Path, axes, straight
from mbproj.scene.records import Joint

Slot = tuple[int, int, Array]


class Wound(NamedTuple):
    """The coordinates of a rope by name, and its rows."""

    coordinates: dict[str, Binding]
    rows: list[Binding]


def wound(joint: Joint, owner: int, seats: Mapping[str, Seat], poses: Mapping[str, Pose], place: Place | None) -> Wound:
    """The coordinates and rows of a rope. Raises InputError where the radii of a portion's wheels have no common
    measure, or where fixed joints keep a wheel from turning.

    The coordinates are `length`, of the whole path; `length_1`, `length_2` ... of the portions between wheels;
    `angle_1`, `angle_2` ... of wheels and drums. Each place on which the rope rubs has `slip_1` ..., half the
    difference of the lengths before and behind it, and `wrapped_1` ..., the length that lies on it."""
    path: Path = joint.parameters["path"]
    second = seats[joint.bodies[1]].carrier
    frame = seats[path.frame]
    x, y, _ = axes(path.normal)
    plane = [frame.vector(poses[path.frame][1].T @ np.array(axis)) for axis in (x, y)]
    vectors: list[Slot] = [(frame.carrier, 1, vector) for vector in plane]
    centres: list[Slot] = []
    for node in path.nodes:
        if node.kind == "wheel" and seats[node.body].carrier == frame.carrier:
            what = f"the wheel '{node.body}' of the rope '{joint.name}' does not turn: a fixed joint holds it"
            raise InputError(Problem(what, place, "let it turn, or write 'sheave'"))
        carrier, local = seated(node.at, local_point(node.at, poses), seats)
        centres.append((carrier, 2 if carrier == second else 1, local))
    turning = {
        k: Binding(Angle(), owner, (*vectors, _turning(node, seats, poses, x, second)))
        for k, node in enumerate(path.nodes)
        if node.kind in ("wheel", "drum") and seats[node.body].carrier != frame.carrier
    }
    whole = _portion(path, 0, len(path.nodes) - 1, owner, vectors, centres)
    last = len(path.nodes) - 1
    cuts = [0, *(k for k in turning if 0 < k < last), last]
    portions = [_portion(path, *ends, owner, vectors, centres) for ends in pairwise(cuts)]
    coordinates = {"length": whole}
    if len(portions) > 1:
        coordinates |= {f"length_{number}": portion for number, portion in enumerate(portions, 1)}
    coordinates |= {f"angle_{number}": angle for number, angle in enumerate(turning.values(), 1)}
    for number, at in enumerate(path.rubbing, 1):
        coordinates[f"slip_{number}"] = _portion(path, 0, last, owner, vectors, centres, at)
        coordinates[f"wrapped_{number}"] = _lying(path, at, owner, vectors, centres)
    for at in path.lifting:
        coordinates[f"on_{at + 1}"] = _lying(path, at, owner, vectors, centres, watched=True)
    constrained = portions if path.taut else portions[:-1]  # a length with a motion or limits has no row of its own
    rows = list(_rows(joint, path, constrained, list(pairwise(cuts))[: len(constrained)], turning, place))
    return Wound(coordinates, rows)


def _turning(node: Node, seats: Mapping[str, Seat], poses: Mapping[str, Pose], x: Sequence[float], second: int) -> Slot:
    """The slot of a vector of a wheel that is along x at the scene's pose."""
    seat = seats[node.body]
    return seat.carrier, 2 if seat.carrier == second else 1, seat.vector(poses[node.body][1].T @ np.array(x))


def _portion(
    path: Path, first: int, last: int, owner: int, vectors: Sequence[Slot], centres: Sequence[Slot], cut: int = 0
) -> Binding:
    """The length of the part of a path from place `first` to `last`. With a `cut`, half the difference: the length up
    to the cut, less the length behind it."""
    lines, ropes = straight(path)
    radii = [node.signed_radius for node in path.nodes]
    counts = [1.0 if not cut else 0.5 if k < cut else -0.5 for k in range(first, last)]
    around = [count * (radii[k] - radii[k + 1]) for k, count in enumerate(counts, first)]
    wound = counts[0] * radii[first] * ropes[first] - counts[-1] * radii[last] * ropes[last - 1]
    lifts = tuple(at - first for at in path.lifting if first < at < last)
    ends = tuple(radii[first : last + 1]), tuple(lines[first:last])
    primitive = Rope(*ends, tuple(counts), tuple(around), wound, lifts)
    return Binding(primitive, owner, (*vectors, *centres[first : last + 1]))


def _lying(
    path: Path, at: int, owner: int, vectors: Sequence[Slot], centres: Sequence[Slot], *, watched: bool = False
) -> Binding:
    """The length of rope that lies on a circle of a path, below 0 where the rope is off it."""
    lines, radius = straight(path)[0][at - 1 : at + 1], path.nodes[at].signed_radius
    radii = tuple(node.signed_radius for node in path.nodes[at - 1 : at + 2])
    primitive = Rope(radii, tuple(lines), (0.0, 0.0), (-radius, radius), watched=watched)
    return Binding(primitive, owner, (*vectors, *centres[at - 1 : at + 2]))


def _rows(
    joint: Joint,
    path: Path,
    portions: Sequence[Binding],
    ends: Sequence[tuple[int, int]],
    turning: Mapping[int, Binding],
    place: Place | None,
) -> Iterator[Binding]:
    """The row of each portion. A given `length` is that of the whole rope: the last portion gets the rest."""
    left = joint.parameters.get("length")
    for number, (portion, (first, last)) in enumerate(zip(portions, ends, strict=True)):
        assert isinstance(portion.primitive, Rope)
        length = _length(path, first, last)
        if left is not None:
            length, left = (left, 0.0) if number == len(portions) - 1 else (length, left - length)
        signs = ((first, -1.0), (last, 1.0))
        angles = [(turning[k], sign * path.nodes[k].signed_radius) for k, sign in signs if k in turning]
        if not angles:
            yield Binding(portion.primitive, portion.owner, portion.slots, length)
            continue
        measure = common_measure([abs(weight) for _, weight in angles])
        if measure is None:
            what = f"the radii of wheels and drums of the rope '{joint.name}' have no common measure"
            raise InputError(Problem(what, place, "round them, as to mm, or let the rope slide over a sheave"))
        weights = tuple(weight for _, weight in angles)
        period = 2.0 * np.pi * measure
        names = ("rope", *["angle" for _ in angles])
        primitive = Coupling(names, (1.0, *weights), period, other=portion.primitive)
        slots = (*portion.slots, *[slot for angle, _ in angles for slot in angle.slots])
        yield Binding(primitive, portion.owner, slots, length - period * np.round(length / period))


def _length(path: Path, first: int, last: int) -> float:
    """Return the length of a portion of the path at the scene's pose, without rope wound on its ends."""
    _, ropes = straight(path)
    for k in path.lifting:
        if first < k < last and (ropes[k] - ropes[k - 1]) * path.nodes[k].signed_radius < 0.0:
            past = replace(path, nodes=path.nodes[:k] + path.nodes[k + 1 :])
            return _length(past, first, last - 1)
    total = 0.0
    for k in range(first, last):
        start, end = path.nodes[k], path.nodes[k + 1]
        far = np.subtract(end.at.vector, start.at.vector)
        total += float(np.sqrt(far @ far - (start.signed_radius - end.signed_radius) ** 2))
        if k > first:
            total += start.signed_radius * (ropes[k] - ropes[k - 1])
    return total
