"""How far each body's centre of mass can be from points of the ground, for any pose that closes the joints.

A path of links and rods reaches no farther than it is long. So a body's centre lies in a ball about each point of the
ground that a joint holds. The radius is the length of the shortest path there: within a body from point to point, along
a rod its length, through joints that hold two points together nothing. A joint that slides has the length at
which it is held or driven. Where it is free it may slide as far as all lengths of the mechanism together, which loops
of links do not exceed.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.constraints import Primitive, name_of
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.kinematics import attached, pose_of
from mbproj.dynamics.equations.motions import Drive
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import Conditions, System
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class Reach:
    """The points of the ground (g, 3) and, for each body's centre, its largest distance from each, (n, g), in m."""

    points: Array
    radius: Array

    @property
    def largest(self) -> float:
        """The longest way across the region of a body, m."""
        low, high = self.box(np.eye(3))
        return float((high - low).max(initial=0.0))

    def box(self, axes: Array) -> tuple[Array, Array]:
        """Return the least and the largest coordinates (n, k) along axes (3, k) of the bodies' centres."""
        along = self.points @ axes
        low = (along - self.radius[..., None]).max(axis=1)
        high = (along + self.radius[..., None]).min(axis=1)
        return low, high


def reach_of(system: System, q: Array, held: Conditions, drive: Drive) -> Reach:
    """Return the reach of the bodies; a pose q (7n,) lies within it, and widens it where a joint slides farther."""
    pose, n = pose_of(q), system.bodies
    body, local, ends = _points(system.joints)
    place = attached(pose, body, local, np.ones(len(body)))
    apart = np.full((len(body) + n,) * 2, np.inf)
    owner_body, all_places = np.concatenate([body, np.arange(n)]), np.concatenate([place, pose.position[:n]])
    same = owner_body[:, None] == owner_body
    between = np.linalg.norm(all_places[:, None] - all_places, axis=-1)
    apart[same] = between[same]
    free = []
    for joint, first, second in ends:
        length = _length(system, joint, held, drive)
        if length is None:
            free.append((first, second))
        else:
            apart[first, second] = apart[second, first] = min(apart[first, second], length)
    finite = np.where(np.isfinite(apart), apart, 0.0)
    bodies = sum(
        float(finite[np.ix_(own, own)].max(initial=0.0)) for own in (owner_body == each for each in range(n + 1))
    )
    whole = max(bodies + _rods(apart, same), system.length)
    for first, second in free:
        apart[first, second] = apart[second, first] = min(apart[first, second], max(whole, between[first, second]))
    for via in range(len(apart)):
        apart = np.minimum(apart, apart[:, via, None] + apart[via])
    ground = np.flatnonzero(body == n)
    if not len(ground):
        middle = pose.position[:n].mean(axis=0)
        far = np.linalg.norm(pose.position[:n] - middle, axis=1, keepdims=True)
        return Reach(middle[None], np.maximum(far, whole))
    radius = np.where(np.isfinite(apart), apart, whole)[len(body) :, ground]
    known = np.maximum(radius, between[len(body) :, ground] * (1.0 + THRESHOLDS.rounded))
    return Reach(all_places[ground], known)


def _points(joints: PrimitiveSet) -> tuple[Integers, Array, list[tuple[int, int, int]]]:
    """Return the body (p,) and the local place (p, 3) of the joints' points, and for each joint with two of them its
    number and theirs."""
    body: list[int] = []
    local: list[Array] = []
    known: dict[tuple[int, bytes], int] = {}
    ends: dict[int, dict[int, int]] = {}
    owner = np.full(len(joints.body), -1, dtype=np.intp)
    owner[joints.entry_slot] = joints.owner[joints.entry_row]
    for slot in np.flatnonzero((joints.is_point > 0.0) & (owner >= 0)).tolist():
        key = int(joints.body[slot]), joints.local[slot].tobytes()
        if key not in known:
            known[key] = len(body)
            body.append(key[0])
            local.append(joints.local[slot])
        ends.setdefault(int(owner[slot]), {}).setdefault(int(joints.side[slot]), known[key])
    pairs = [(joint, of[1], of[2]) for joint, of in ends.items() if len(of) == 2]
    return np.array(body, dtype=np.intp), np.array(local).reshape(-1, 3), pairs


def _length(system: System, joint: int, held: Conditions, drive: Drive) -> float | None:
    """Return the largest distance of a joint's two points; None where it slides freely."""
    parts = []
    for member, row in _members(system.joints, joint):
        kind = name_of(type(member))
        if kind == "coincident":
            return 0.0
        if kind == "distance":
            return float(system.joints.offset[row])
        if kind == "along":
            parts.append(float(system.joints.offset[row]))
    known = dict(zip(held.index.tolist(), held.value.tolist(), strict=True))
    known |= dict(zip(system.motions.joint_coordinate.tolist(), drive.value.tolist(), strict=True))
    for member, row in _members(system.coordinates, joint):
        kind = name_of(type(member))
        if row in known and kind == "distance":
            return abs(known[row])
        if row in known and kind == "along":
            parts.append(known[row])
    return float(np.linalg.norm(parts)) if len(parts) >= 3 else None


def _members(bound: PrimitiveSet, joint: int) -> Iterator[tuple[Primitive, int]]:
    """The primitives of a joint, each with its first row."""
    for row in np.flatnonzero(bound.owner == joint).tolist():
        member = bound.layout.members[bound.layout.member[row]]
        if row == member.rows[0]:
            yield member.primitive, row


def _rods(apart: Array, same: Flags) -> float:
    """Return the sum of the lengths between points of different bodies."""
    between = np.triu(np.where(np.isfinite(apart) & ~same, apart, 0.0))
    return float(between.sum())
