"""Rules on ropes: their paths are possible, and their other keys fit the paths."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

from mbproj.scene.blocks.observables import MOST_WHEELS
from mbproj.scene.blocks.ropes.block import connected
from mbproj.scene.blocks.ropes.path import Path, axes, dot
from mbproj.scene.fields.containers import Complaint
from mbproj.scene.records import GROUND, Body, Joint, KeyPath, Motion
from mbproj.thresholds import THRESHOLDS


def run_over_places(
    joints: Mapping[str, Joint], bodies: Mapping[str, Body], motions: Mapping[str, Motion]
) -> Iterator[Complaint]:
    """Complaints about ropes whose paths are impossible, or whose other keys do not fit the path."""
    for joint in joints.values():
        if joint.type == "rope":
            wrong = [*_on_places(joint), *_as_whole(joint, motions), *_on_what_turns(joint, joints)]
            yield from wrong or _in_plane(connected(joint, bodies, motions))


def _on_places(joint: Joint) -> Iterator[Complaint]:
    path: Path = joint.parameters["path"]
    for number, node in enumerate(path.nodes):
        at: KeyPath = ("joints", joint.name, "path", number, node.kind)
        is_end = number in (0, len(path.nodes) - 1)
        if node.kind == "drum" and not is_end:
            yield Complaint(at, "a drum in the middle of a rope", "write 'wheel', or end the rope there")
        if node.kind in ("wheel", "sheave") and is_end:
            yield Complaint(at, f"a {node.kind} at the end of a rope", "write 'drum', to which the rope is fixed")
        if node.kind == "wheel" and node.body == path.frame:
            yield Complaint(at, "this wheel does not turn: the plane of the rope is fixed in it", "write 'sheave'")


def _as_whole(joint: Joint, motions: Mapping[str, Motion]) -> Iterator[Complaint]:
    path: Path = joint.parameters["path"]
    at: KeyPath = ("joints", joint.name, "path")
    driven = any(each.joint == joint.name for each in motions.values())
    turning = [node for node in path.nodes if node.kind in ("wheel", "drum") and node.body != path.frame]
    wheels = sum(node.kind == "wheel" for node in turning)
    if wheels > MOST_WHEELS:
        said = f"this rope turns {wheels} wheels, and can turn {MOST_WHEELS}"
        yield Complaint(at, said, "let it slide over some: write 'sheave'")
    if turning and not path.taut:
        said = "a rope that may go slack runs over wheels or drums that turn"
        yield Complaint(at, said, "let it slide over sheaves, or give it a length that it keeps")
    if driven and wheels < len(turning):
        said = "a motion drives the length of this rope, and a drum winds it"
        yield Complaint(at, said, "drive the drum by a motion of its joint")
    if path.rubbing and (driven or not path.taut):
        said = "a rope whose length may change rubs on a sheave"
        yield Complaint((*at, path.rubbing[0], "friction"), said, "give the rope a length that it keeps")
    for first, second in pairwise(path.lifting):
        if second == first + 1:
            said = f"the rope lifts off places {first + 1} and {second + 1}, which are beside each other"
            yield Complaint((*at, second, "lifts"), said, "let it lift off one of them")
    if path.rubbing and turning:
        said = "a rope that rubs on a sheave turns a wheel or a drum"
        hint = "end it before: at a point of a body that slides along the strand, from which another rope goes on"
        yield Complaint((*at, path.rubbing[0], "friction"), said, hint)
    if len(path.rubbing) > 1:
        said = f"the rope rubs on place {path.rubbing[0] + 1} already"
        hint = "make two ropes of it, with a body between that slides along the strand"
        yield Complaint((*at, path.rubbing[1], "friction"), said, hint)
    if driven and ("length" in joint.parameters or not path.taut):
        yield Complaint(at, "a motion drives the length of this rope", "leave out what else says its length")


def _on_what_turns(joint: Joint, joints: Mapping[str, Joint]) -> Iterator[Complaint]:
    """Complaints about friction on a sheave that may turn relative to the plane of its rope: slip is measured in that
    plane."""
    path: Path = joint.parameters["path"]
    upright, size = {path.frame}, 0
    while len(upright) > size:
        size = len(upright)
        for each in joints.values():
            if each.type in ("fixed", "prismatic") and upright & {*each.bodies}:
                upright |= {*each.bodies}
    for k in path.rubbing:
        if path.nodes[k].body not in upright:
            said = f"the rope rubs on place {k + 1}, whose body may turn against the plane of the rope"
            hint = "hold that body by fixed or prismatic joints, or give it as the 'frame'"
            yield Complaint(("joints", joint.name, "path", k, "friction"), said, hint)


def _in_plane(joint: Joint) -> Iterator[Complaint]:
    """Complaints about circles that overlap or are wrapped on the wrong side. Others are about a rope that leans out of
    its plane, or is too short."""
    path: Path = joint.parameters["path"]
    at: KeyPath = ("joints", joint.name, "path")
    x, y, n = axes(path.normal)
    seen = [[dot(axis, node.at.vector) for axis in (x, y, n)] for node in path.nodes]
    radii = [node.signed_radius for node in path.nodes]
    before = None
    for k, (start, end) in enumerate(pairwise(seen)):
        w, flat = radii[k] - radii[k + 1], math.hypot(end[0] - start[0], end[1] - start[1])
        free = math.sqrt(max(flat**2 - w**2, 0.0))
        pair = f"places {k + 1} and {k + 2} of this path"
        both = abs(radii[k]) + abs(radii[k + 1])
        if free <= THRESHOLDS.least_span * both or flat < both:
            apart = "are one point" if not both else "overlap: no rope runs straight between them"
            yield Complaint((*at, k + 1), f"{pair} {apart}", "move one of them, or give smaller radii")
            return
        if w and abs(end[2] - start[2]) > math.tan(THRESHOLDS.fleet_angle) * free:
            lean = math.degrees(math.atan(abs(end[2] - start[2]) / free))
            said = f"between {pair} the rope leans by {lean:.3g} deg out of the plane of its sheaves"
            most = math.degrees(THRESHOLDS.fleet_angle)
            yield Complaint((*at, k + 1), said, f"{most:.2g} deg is the most: give another 'normal', or move a place")
            return
        θ = math.atan2(end[1] - start[1], end[0] - start[0]) + math.asin(w / flat)
        if before is not None and radii[k]:
            wrap = (math.copysign(1.0, radii[k]) * (θ - before)) % (2.0 * math.pi)
            if wrap > THRESHOLDS.wrong_side and not (path.nodes[k].turns or path.nodes[k].lifts):
                other = "right" if path.nodes[k].left else "left"
                said = f"the rope would wrap {math.degrees(wrap):.4g} deg around place {k + 1}: it is on the wrong side"
                yield Complaint((*at, k), said, f"write bends: {other}, or move the place")
                return
        before = θ
    yield from _long_enough(joint, radii, seen)


def _long_enough(joint: Joint, radii: Sequence[float], seen: Sequence[Sequence[float]]) -> Iterator[Complaint]:
    path: Path = joint.parameters["path"]
    given = joint.parameters.get("length")
    shortest = math.dist(path.nodes[0].at.vector, path.nodes[-1].at.vector) - abs(radii[0]) - abs(radii[-1])
    fixed = all(node.body == GROUND for node in (path.nodes[0], path.nodes[-1]))
    if given is not None and fixed and given < shortest:
        said = f"the rope is shorter than its path: {given:.6g} m between ends {shortest:.6g} m apart"
        yield Complaint(("joints", joint.name, "length"), said, "give a longer rope, or move its ends")
        return
    pairs = zip(pairwise(path.nodes), pairwise(radii), pairwise(seen), strict=True)
    fixed_spans = [
        math.sqrt(math.dist(*ends) ** 2 - (radius - other) ** 2)
        for (first, second), (radius, other), ends in pairs
        if first.body == second.body
    ]
    if given is not None and not path.lifting and given <= sum(fixed_spans):
        least = sum(fixed_spans)
        said = f"the rope is shorter than its path: {given:.6g} m, of {least:.6g} m between places of one body"
        yield Complaint(("joints", joint.name, "length"), said, "give a longer rope, or move its places")
