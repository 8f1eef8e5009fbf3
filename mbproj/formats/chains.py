"""Several joints in a row between two bodies: one joint of the scene where there is one, else massless bodies between.

Robots' formats stack single turns and slides: two crossed turns are a universal joint; a slide along a turn's axis is a
cylindrical one; two slides and a turn across them are a planar one.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import Place
from mbproj.formats.geometry import unit
from mbproj.formats.mechanism import Connection, ImportedBody, ImportedMechanism, ImportedNames, Quantity, Same

#: The tolerances with which axes must be parallel or normal to each other, in rad, and lines must meet, in m.
EXACT = 1e-9

#: A limit beyond this number of radians or metres counts as none.
NO_LIMIT = 1e5
#: The lower and the upper limit, where there is one.
Span = tuple[float | None, float | None]


@dataclass(frozen=True, eq=False)
class Single:
    """A turn or a slide: its point and unit axis in global axes, and the actions on its coordinate, all in SI units.

    `range` and `rest`, where the spring has no force, count from the pose. `armature` is the reflected inertia and
    `dry` a constant friction. `rate` is the rate of the coordinate at the model's start."""

    name: str
    turns: bool
    point: Array
    axis: Array
    range: Span | None = None
    stiffness: float = 0.0
    rest: float = 0.0
    damping: float = 0.0
    dry: float = 0.0
    armature: float = 0.0
    rate: float = 0.0
    place: Place | None = None
    more: dict[str, Any] = field(default_factory=dict)

    @property
    def acted_on(self) -> bool:
        """Whether something acts on its coordinate, or limits it."""
        return bool(self.range or self.stiffness or self.damping or self.dry or self.armature)


@dataclass(frozen=True, eq=False)
class BodyTwist:
    """The velocity of a body: its angular velocity, and the velocity of its point at the origin, both global."""

    turning: Array
    velocity: Array

    @classmethod
    def of(cls, part: ImportedBody) -> BodyTwist:
        """The twist of a body."""
        turning = part.rotation @ part.angular_velocity
        return cls(turning, part.velocity - np.cross(turning, part.position))

    def then(self, single: Single, sign: float = 1.0) -> BodyTwist:
        """The twist of the body that a turn or a slide on this one carries; with the sign -1, of the body that carries
        this one by it."""
        moved = sign * single.rate * single.axis
        if not single.turns:
            return BodyTwist(self.turning, self.velocity + moved)
        return BodyTwist(self.turning + moved, self.velocity - np.cross(moved, single.point))

    def give_to(self, part: ImportedBody) -> ImportedBody:
        """The body with this twist as its velocity."""
        velocity = self.velocity + np.cross(self.turning, part.position)
        return replace(part, velocity=velocity, angular_velocity=part.rotation.T @ self.turning)


#: By the name of a single joint in the model: the joint and the coordinate of the scene that it became.
Coordinates = dict[str, tuple[str, str]]


def connect(
    mechanism: ImportedMechanism,
    bodies: tuple[str, str],
    singles: Sequence[Single],
    unused: Callable[[str], str],
    places: Coordinates,
) -> None:
    """Add the joints between two bodies. `places` gets the joint and coordinate of the scene for each of `singles`."""
    for recognised in (_universal, _cylindrical, _planar):
        joint = recognised(singles)
        if joint is None:
            continue
        kind, point, axes, names = joint
        every = [single.name for single in singles]
        name = unused(before_coordinates(every, names) or "_".join(every))
        add_one(mechanism, name, kind, bodies, point, axes, list(zip(singles, names, strict=True)))
        places.update({single.name: (name, coordinate) for single, coordinate in zip(singles, names, strict=True)})
        return
    first = bodies[0]
    twist = BodyTwist.of(mechanism.part(first))
    for at, single in enumerate(singles):
        last = at == len(singles) - 1
        second = bodies[1] if last else unused(f"{bodies[1]}_after_{single.name}")
        twist = twist.then(single)
        if not last:
            carried = mechanism.part(bodies[1])
            between = ImportedBody(second, 0.0, np.zeros((3, 3)), single.point, carried.rotation, single.place)
            mechanism.insert(twist.give_to(between), bodies[1])
        name = unused(single.name)
        coordinate = "angle" if single.turns else "displacement"
        kind = "revolute" if single.turns else "prismatic"
        add_one(mechanism, name, kind, (first, second), single.point, single.axis, [(single, coordinate)])
        places[single.name] = (name, coordinate)
        first = second


def before_coordinates(names: Sequence[str], coordinates: Sequence[str]) -> str:
    """The common part before `_angle_1` and `_angle_2` in the names that an export gives to the turns of one joint; ""
    for other names."""
    before = {name.removesuffix(f"_{coordinate}") for name, coordinate in zip(names, coordinates, strict=True)}
    return before.pop() if len(before) == 1 and len(set(names)) == len(names) else ""


_Recognised = tuple[str, Array, Array, tuple[str, ...]]


def _universal(singles: Sequence[Single]) -> _Recognised | None:
    if len(singles) != 2 or not all(single.turns for single in singles) or any(single.dry for single in singles):
        return None
    first, second = singles
    point = crossing(first, second)
    if point is None:
        return None
    return "universal", point, np.array([first.axis, second.axis]), ("angle_1", "angle_2")


def crossing(first: Single, second: Single) -> Array | None:
    """The point (3,) at which two axes meet at a right angle; None where they do not."""
    if abs(first.axis @ second.axis) > EXACT:
        return None
    between = second.point - first.point
    point = first.point + (between @ first.axis) * first.axis
    off = second.point - point
    meets = np.linalg.norm(off - (off @ second.axis) * second.axis) <= EXACT
    return np.asarray(point) if meets else None


def _cylindrical(singles: Sequence[Single]) -> _Recognised | None:
    if len(singles) != 2 or singles[0].turns == singles[1].turns:
        return None
    turn, slide = sorted(singles, key=lambda single: not single.turns)
    if turn.axis @ slide.axis < 0.0 or np.linalg.norm(np.cross(turn.axis, slide.axis)) > EXACT:
        return None
    return "cylindrical", turn.point, turn.axis, tuple("angle" if each.turns else "displacement" for each in singles)


def _planar(singles: Sequence[Single]) -> _Recognised | None:
    """The planar joint of two slides and a turn, in this order. Nothing may act on the slides, since the scene chooses
    the axes of its displacements."""
    if [single.turns for single in singles] != [False, False, True]:
        return None
    x, y, turn = singles
    crossed = max(abs(x.axis @ y.axis), abs(x.axis @ turn.axis), abs(y.axis @ turn.axis))
    if crossed > EXACT or x.acted_on or y.acted_on or turn.dry:
        return None
    return "planar", turn.point, turn.axis, ("displacement_x", "displacement_y", "angle")


def add_one(
    mechanism: ImportedMechanism,
    name: str,
    kind: str,
    bodies: tuple[str, str],
    point: Array,
    axes: Array,
    coordinates: Sequence[tuple[Single, str]],
    keys: Mapping[str, Any] | None = None,
) -> None:
    """Add a joint, and the forces on its coordinates; limits and reflected inertias are keys of the joint."""
    alone = len(coordinates) == 1 and kind != "screw"
    inertias = {
        coordinate: Quantity(single.armature, "kg*m^2" if single.turns else "kg")
        for single, coordinate in coordinates
        if single.armature
    }
    limits = {
        coordinate: {"range": [_limit(each, single.turns) for each in single.range], "rigid": True}
        for single, coordinate in coordinates
        if single.range
    }
    keys = dict(keys or {})
    if inertias:
        keys["reflected_inertia"] = next(iter(inertias.values())) if alone else inertias
    if limits:
        keys["limits"] = limits
    mechanism.join(name, kind, bodies, point, axes, keys, coordinates[0][0].place)
    for single, coordinate in coordinates:
        _forces(mechanism, name, single, {} if alone else {"coordinate": coordinate})


def span(mechanism: ImportedMechanism, joint: str, place: Place | None, low: float, high: float) -> Span | None:
    """The range of a coordinate, counted from the pose; None where there is no limit. None also where the pose is
    beyond the range, which gets a row of the table."""
    if low <= 0.0 <= high and low < high:
        sides = (None if low < -NO_LIMIT else low, None if high > NO_LIMIT else high)
        return None if sides == (None, None) else sides
    mechanism.say(f"limit of joint '{joint}'", place, "left out: the pose is beyond it", Same.NO)
    return None


def _limit(value: float | None, turns: bool) -> Quantity | None:
    return None if value is None else Quantity(value, "rad" if turns else "m")


def _forces(mechanism: ImportedMechanism, joint: str, single: Single, which: dict[str, str]) -> None:
    """Add the spring, the damper and the dry friction of a coordinate."""
    unit = "N*m/rad" if single.turns else "N/m"
    if single.stiffness or single.damping:
        kind = "torsion_spring_damper" if single.turns else "linear_spring_damper"
        entry: dict[str, Any] = {"type": kind, "joint": joint} | which
        if single.stiffness:
            entry["stiffness"] = Quantity(single.stiffness, unit)
            if single.rest:
                key = "free_angle" if single.turns else "free_displacement"
                entry[key] = Quantity(single.rest, "rad" if single.turns else "m")
        if single.damping:
            entry["damping"] = Quantity(single.damping, "N*m*s/rad" if single.turns else "N*s/m")
        mechanism.forces[
            free_name(mechanism, f"{single.name}_spring" if single.stiffness else f"{single.name}_damper")
        ] = entry
    if single.dry:
        amount = {"torque": Quantity(single.dry, "N*m")} if single.turns else {"force": Quantity(single.dry, "N")}
        entry = {"type": "friction", "joint": joint, "coulomb": amount}
        mechanism.forces[free_name(mechanism, f"{single.name}_friction")] = entry


def free_name(mechanism: ImportedMechanism, wanted: str) -> str:
    """A name for a force that no other force has, as near to the wanted one as can be."""
    return ImportedNames(frozenset(mechanism.forces)).unused(wanted)


def follow(
    mechanism: ImportedMechanism,
    names: ImportedNames,
    ends: tuple[str, str],
    ratio: float,
    constant: float,
    place: Place,
) -> None:
    """Add a coupler of two joint coordinates: s = ratio s' + constant, both counted from the pose. `ends` are the names
    of s and s' in the scene, "joint.coordinate"."""
    follower, leader = ends
    keys: dict[str, Any] = {"of": {follower: 1.0} | ({leader: -ratio} if ratio else {})}
    if constant:
        keys["constant"] = constant
    name = names.unused(f"{follower.partition('.')[0]}_mimic")
    mechanism.joints[name] = Connection(name, "coupler", keys=keys, place=place)


# --- Puts one joint in the place of several that formats of robots need for it ----------------------------------------
# Massless links between turns whose axes cross at right angles are a universal or a spherical joint. Such a link, a
# ring, moves without bounds near the pose where the first and the last axis are parallel; the joint does not. Two
# points of a body that are held to two points of another one are a hinge, which has no redundant row.


#: The largest difference of the distance of two points in one body and in the other, and the least distance, in m.
ALIKE, APART = 1e-12, 1e-6
#: The joint that replaces a number of turns in a row.
KINDS = {2: "universal", 3: "spherical"}


def without_rings(mechanism: ImportedMechanism) -> None:
    """Put one joint in the place of two or three turns in a row, with a row of the table. No other joint may hold, and
    nothing may name, the massless links between."""
    used = _names_in_use(mechanism)
    for count in (3, 2):
        for first in list(mechanism.joints.values()):
            chain = _chain(mechanism, first, count, used) if first.name in mechanism.joints else []
            point = _meeting(mechanism, chain) if chain else None
            if point is not None:
                _replace(mechanism, chain, point)


def _names_in_use(mechanism: ImportedMechanism) -> set[str]:
    """The joints and bodies that forces, motions, couplers and markers name."""
    names = {body for body, _ in mechanism.markers.values()}
    couplers = [joint.keys for joint in mechanism.joints.values()]
    for entry in [*mechanism.forces.values(), *mechanism.motions.values(), *couplers]:
        names |= set(_names_in(entry))
    return names


def _names_in(entry: Mapping[str, Any]) -> list[str]:
    of = [name.partition(".")[0] for name in entry.get("of", {})]
    alone = [str(entry[key]) for key in ("joint", "body") if key in entry]
    return [*of, *alone, *entry.get("bodies", [])]


def _chain(mechanism: ImportedMechanism, first: Connection, count: int, used: set[str]) -> list[Connection]:
    """The `count` turns in a row from `first` on, with massless links between that have no other joint; [] where there
    are fewer."""
    chain = [first]
    while _is_free_turn(mechanism, chain[-1], used):
        if len(chain) == count:
            return chain
        ring = chain[-1].bodies[1]
        others = [joint for joint in mechanism.joints.values() if ring in joint.bodies and joint is not chain[-1]]
        if ring in used or len(others) != 1 or others[0].bodies[0] != ring or not _massless(mechanism.part(ring)):
            return []
        chain.append(others[0])
    return []


def _is_free_turn(mechanism: ImportedMechanism, joint: Connection, used: set[str]) -> bool:
    return joint.type == "revolute" and joint.name in mechanism.tree and not joint.keys and joint.name not in used


def _massless(part: ImportedBody) -> bool:
    return not part.mass and not part.inertia.any()


def _meeting(mechanism: ImportedMechanism, chain: Sequence[Connection]) -> Array | None:
    """The global point (3,) at which the axes meet, each at a right angle to the next; None where they do not."""
    singles = [_single(mechanism, joint) for joint in chain]
    first, *others = (crossing(one, other) for one, other in pairwise(singles))
    if first is None or any(other is None or np.abs(other - first).max() > EXACT for other in others):
        return None
    return first


def _single(mechanism: ImportedMechanism, joint: Connection) -> Single:
    assert joint.points is not None and joint.axes is not None
    part = mechanism.part(joint.bodies[0])
    point = part.position + part.rotation @ joint.points[0]
    return Single(joint.name, True, point, part.rotation @ joint.axes[0])


def _replace(mechanism: ImportedMechanism, chain: Sequence[Connection], point: Array) -> None:
    """Put one joint in the place of the first of the chain, and remove the others and the links between."""
    kind, names = KINDS[len(chain)], [joint.name for joint in chain]
    axes = np.array([_single(mechanism, joint).axis for joint in chain]) if len(chain) == 2 else None
    new_name = ImportedNames(frozenset(mechanism.joints)).unused(
        before_coordinates(names, ("angle_1", "angle_2", "angle_3")[: len(names)])
        or ImportedNames.beginning(names)
        or names[0]
    )
    before = dict(mechanism.joints)
    mechanism.joints.clear()
    for name, joint in before.items():
        if joint is chain[0]:
            mechanism.join(new_name, kind, (chain[0].bodies[0], chain[-1].bodies[1]), point, axes, place=joint.place)
        elif joint not in chain:
            mechanism.joints[name] = joint
    for joint in chain[:-1]:
        del mechanism.parts[joint.bodies[1]]
    mechanism.tree -= set(names)
    what = f"one {kind} joint '{new_name}': the parts between them have no mass"
    mechanism.say(f"joints {', '.join(names)}", chain[0].place, what, Same.YES)


def with_hinges(mechanism: ImportedMechanism) -> None:
    """Put a revolute joint in the place of two spherical ones that close loops between the same bodies, with a row of
    the table.

    Its name is the common beginning of their names."""
    pairs: dict[tuple[str, ...], list[Connection]] = {}
    for joint in mechanism.joints.values():
        if joint.type == "spherical" and joint.name not in mechanism.tree and not joint.keys:
            pairs.setdefault(tuple(sorted(joint.bodies)), []).append(joint)
    for first, second in (pair for pair in pairs.values() if len(pair) == 2):
        axes = _axes(first, second)
        if axes is None:
            continue
        stem = ImportedNames.beginning([first.name, second.name]) or first.name
        name = stem if stem in (first.name, second.name) else ImportedNames(frozenset(mechanism.joints)).unused(stem)
        hinge = Connection(name, "revolute", first.bodies, first.points, axes, place=first.place)
        held = {second.name: None, first.name: hinge}
        before = dict(mechanism.joints)
        mechanism.joints.clear()
        for each, joint in before.items():
            successor = held.get(each, joint)
            if successor is not None:
                mechanism.joints[successor.name] = successor
        what = f"joints '{first.name}' and '{second.name}'"
        mechanism.say(what, first.place, "one revolute joint through both points", Same.YES)


def _axes(first: Connection, second: Connection) -> Array | None:
    """The unit vectors (2, 3) of the line through both points, in the axes of each body; None where the distance of the
    points differs between the bodies, or is too small."""
    assert first.points is not None and second.points is not None
    ends = second.points if first.bodies == second.bodies else second.points[::-1]
    lines = ends - first.points
    lengths = np.linalg.norm(lines, axis=1)
    if lengths.min() < APART or abs(lengths[0] - lengths[1]) > ALIKE * max(1.0, float(np.abs(ends).max())):
        return None
    return np.array([unit(line) for line in lines])
