"""Puts one joint in the place of several that formats of robots need for it.

Massless links between turns whose axes cross at right angles are a universal or a spherical joint. Such a link, a ring,
moves without bounds near the pose where the first and the last axis are parallel; the joint does not. Two points of a
body that are held to two points of another one are a hinge, which has no redundant row.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from mbproj.arrays import Array
from mbproj.formats.chains import EXACT, Single, before_coordinates, crossing
from mbproj.formats.geometry import unit
from mbproj.formats.mechanism import Connection, ImportedBody, ImportedMechanism, ImportedNames, Same

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
    own = ImportedNames(frozenset(mechanism.joints)).unused(
        before_coordinates(names, ("angle_1", "angle_2", "angle_3")[: len(names)])
        or ImportedNames.beginning(names)
        or names[0]
    )
    before = dict(mechanism.joints)
    mechanism.joints.clear()
    for name, joint in before.items():
        if joint is chain[0]:
            mechanism.join(own, kind, (chain[0].bodies[0], chain[-1].bodies[1]), point, axes, place=joint.place)
        elif joint not in chain:
            mechanism.joints[name] = joint
    for joint in chain[:-1]:
        del mechanism.parts[joint.bodies[1]]
    mechanism.tree -= set(names)
    what = f"one {kind} joint '{own}': the parts between them have no mass"
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
        own = ImportedNames.beginning([first.name, second.name]) or first.name
        name = own if own in (first.name, second.name) else ImportedNames(frozenset(mechanism.joints)).unused(own)
        hinge = Connection(name, "revolute", first.bodies, first.points, axes, place=first.place)
        held = {second.name: None, first.name: hinge}
        before = dict(mechanism.joints)
        mechanism.joints.clear()
        for each, joint in before.items():
            kept = held.get(each, joint)
            if kept is not None:
                mechanism.joints[kept.name] = kept
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
