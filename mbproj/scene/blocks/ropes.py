"""The fields of ropes: the places of the path, and the keys that say how long the rope is.

hoist:
  type: rope
  path:
    - {drum: winch, radius: 120 mm, bends: left}                      # turns and winds the rope
    - {sheave: ground, at: [0.4, 0, 3], radius: 0.1 m, bends: right}  # the rope slides over it; with friction it rubs
    - {wheel: pulley, radius: 0.1 m, bends: left}                     # the rope turns it; at the centre of mass
    - {point: load, at: [0.8, 0, 1]}
  normal: [0, 1, 0]
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Annotated, Any

from mbproj.base.dataclass import dataclass
from mbproj.base.thresholds import THRESHOLDS
from mbproj.scene.blocks.observables import MOST_WHEELS
from mbproj.scene.fields.fields import Complaint, Converted, Field, Flag, List, NameChoice, NameReference, OneOf, Record
from mbproj.scene.fields.placing import BODY_POINT
from mbproj.scene.fields.quantities import DIRECTION, Number
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.fields.rotations import cross, to_matrix, unit
from mbproj.scene.records import GROUND, Body, Joint, KeyPath, Limit, Motion, OfBody, Pair, Quantity, StopLaw, Vector

# --- The path of a rope -----------------------------------------------------------------------------------------------
# Its places, and the directions of the rope between them.


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
    at: Annotated[OfBody, Quantity("m", "point")]
    radius: Annotated[float, Quantity("m")] = 0.0
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
    normal: Annotated[Vector, Quantity("", "direction")]
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

    def changed(self, place: Callable[[OfBody], OfBody], normal: Callable[[Vector], Vector]) -> Path:
        """The path whose places and normal are changed by these functions."""
        nodes = [replace(node, at=place(node.at)) for node in self.nodes]
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


# --- The fields of ropes ----------------------------------------------------------------------------------------------


LENGTH = Number("m", above=0.0)
#: The most places that a path has.
MOST_NODES = 14
CENTRE: Vector = (0.0, 0.0, 0.0)


def _turns(number: float) -> int:
    if not (number >= 0.0 and number.is_integer()):
        raise Unfit("is not a whole number of turns", "give 0, 1, 2 ...")
    return int(number)


def _node(
    at: Any = None,
    radius: float = 0.0,
    bends: str | None = None,
    turns: int = 0,
    friction: float | None = None,
    lifts: bool = False,
    **kinds: str,
) -> Node:
    ((kind, body),) = kinds.items()
    if friction is not None and kind != "sheave":
        raise Unfit(
            f"has 'friction' and is a {kind}", "a rope rubs on a 'sheave'; a wheel has friction in its own joint"
        )
    if lifts and (kind != "sheave" or turns or friction is not None):
        raise Unfit("'lifts' off what is no plain sheave", "a rope leaves a 'sheave' without 'turns' and 'friction'")
    if kind == "point" and (radius or turns or bends):
        raise Unfit("is a point, and has keys of a circle", "leave these out, or write 'sheave' for 'point'")
    if kind != "point" and not radius:
        raise Unfit("lacks 'radius'", f"a {kind} has one, to the middle of the rope")
    if kind != "point" and bends is None:
        raise Unfit("lacks 'bends'", "say whether the rope bends left or right there, looking against the normal")
    if at is None and (kind == "point" or body == GROUND):
        raise Unfit("lacks 'at'", "give its place, as in at: [0, 0, 1]")
    if isinstance(at, Mapping) and [*at] != [body]:
        raise Unfit(f"is on '{body}', and its place is given for another body", f"write at: {{{body}: [...]}}")
    local = at is None or isinstance(at, Mapping)
    vector = CENTRE if at is None else at[body] if isinstance(at, Mapping) else at
    return Node(kind, body, OfBody(body, vector, local), radius, bends == "left", turns, friction, lifts)


NODE: Record[Node] = Record(
    "a place of a rope",
    {
        **{kind: NameReference("body", "bodies", (GROUND,)) for kind in KINDS},
        "at": BODY_POINT,
        "radius": LENGTH,
        "bends": NameChoice("side", lambda: ("left", "right")),
        "turns": Converted(Number(), _turns),
        "friction": Number(minimum=0.0),
        "lifts": Flag(),
    },
    _node,
    choices=(OneOf(KINDS, needed=True),),
)


def _several(nodes: tuple[Node, ...]) -> tuple[Node, ...]:
    if len(nodes) < 2:
        raise Unfit("has one place", "a rope runs from a first place to a last one")
    if len(nodes) > MOST_NODES:
        raise Unfit(f"has {len(nodes)} places", f"a rope has {MOST_NODES} at most: make two of it, with a body between")
    return nodes


#: The keys of a rope beside those of its coordinate.
KEYS: Mapping[str, Field[Any]] = {
    "path": Converted(List(NODE, None, "places"), _several),
    "normal": DIRECTION,
    "frame": NameReference("body", "bodies", (GROUND,)),
    "length": LENGTH,
    "slack": Flag(),
    "free": Flag(),
    "restitution": Number(minimum=0.0, maximum=1.0),
    "stiffness": Number("N/m", above=0.0),
    "damping": Number("s/m", minimum=0.0),
}
CHOICES = (
    OneOf(("slack", "stiffness"), hint="a rope with stiffness goes slack by itself"),
    *(
        OneOf(("free", key), hint="a free rope has any length, and only forces on its coordinate act along it")
        for key in ("length", "slack", "stiffness", "limits")
    ),
    OneOf(("slack", "limits"), hint="limits say by themselves how long the rope may be"),
    OneOf(("stiffness", "limits"), hint="give the stiffness in the limits"),
    OneOf(("length", "limits"), hint="limits say by themselves how long the rope may be"),
)


def rope_record(name: str, others: Mapping[str, Field[Any]]) -> Record[Joint]:
    """The record that reads a rope. `others` are the keys that all joints have."""
    return Record(f"a {name} joint", {**others, **KEYS}, _rope, ("type", "path", "normal"), (), CHOICES, named=True)


def _rope(
    name: str,
    type: str,
    path: tuple[Node, ...],
    normal: Vector,
    frame: str = GROUND,
    slack: bool = False,
    free: bool = False,
    restitution: float | None = None,
    stiffness: float | None = None,
    damping: float | None = None,
    length: float | None = None,
    limits: Mapping[str, Limit] | None = None,
    speed: Mapping[str, float] | None = None,
    reflected_inertia: Mapping[str, float] | None = None,
) -> Joint:
    """The joint of a rope. Raises Unfit for keys that do not fit each other.

    Results give its reaction on its second body. This is the last body of the path; where that is also the first, it is
    the first other body."""
    if restitution is not None and not slack:
        raise Unfit("has a 'restitution' and is never slack", "add slack: true, or leave it out")
    if damping is not None and stiffness is None:
        raise Unfit("has 'damping' and no stiffness", "add 'stiffness', or leave it out")
    if slack or stiffness is not None:
        if length is None:
            raise Unfit("may go slack and lacks 'length'", "give the length at which it is taut")
        law = StopLaw(restitution=restitution or 0.0)
        law = law if stiffness is None else StopLaw(stiffness, damping=damping or 0.0)
        limits = {"length": Limit(None, length, law)}
    first, last = path[0], path[-1]
    if first.body == last.body:
        last = next((node for node in path if node.body != first.body), last)
    if first.body == last.body:
        raise Unfit("runs over places of one body", "a rope needs places on two bodies at least")
    parameters: dict[str, Any] = {"path": Path(path, normal, frame, taut=not (limits or free))}
    if length is not None:
        parameters["length"] = length
    points = Pair(first.at.vector, last.at.vector)
    return Joint(
        name,
        type,
        (first.body, last.body),
        points,
        speed=speed or {},
        parameters=parameters,
        limits=limits or {},
        reflected_inertia=reflected_inertia or {},
    )


def connected(joint: Joint, bodies: Mapping[str, Body], motions: Mapping[str, Motion]) -> Joint:
    """The rope with all places in global axes. Where a motion drives the length, the rope has no row of its own."""
    path: Path = joint.parameters["path"]
    driven = any((each.joint, each.coordinate) == (joint.name, "length") for each in motions.values())
    nodes = tuple(replace(node, at=_global(node.at, bodies)) for node in path.nodes)
    path = replace(path, nodes=nodes, taut=path.taut and not driven)
    places = {node.body: node.at.vector for node in reversed(nodes)}
    ends = (nodes[0].at.vector, places[joint.bodies[1]])
    if nodes[-1].body == joint.bodies[1]:
        ends = (ends[0], nodes[-1].at.vector)
    return replace(joint, points=Pair(*ends), parameters={**joint.parameters, "path": path})


def _global(at: OfBody, bodies: Mapping[str, Body]) -> OfBody:
    """A place at the scene's pose, in global axes."""
    if not at.local or at.body == GROUND:
        return replace(at, local=False)
    body = bodies[at.body]
    rows = zip(body.position, to_matrix(body.orientation), strict=True)
    x, y, z = (start + dot(row, at.vector) for start, row in rows)
    return OfBody(at.body, (x, y, z))


# --- Rules on ropes ---------------------------------------------------------------------------------------------------
# Their paths are possible, and their other keys fit the paths.


def run_over_places(
    joints: Mapping[str, Joint], bodies: Mapping[str, Body], motions: Mapping[str, Motion]
) -> Iterator[Complaint]:
    """Complaints about ropes whose paths are impossible, or whose other keys do not fit the path."""
    for joint in joints.values():
        if joint.type == "rope":
            wrong = [*_on_places(joint), *_as_whole(joint, motions), *_on_what_turns(joint, joints)]
            if wrong:
                yield from wrong
                continue
            whole = connected(joint, bodies, motions)
            yield from _about_the_normal(whole, joints, bodies) or _in_plane(whole)


def _about_the_normal(rope: Joint, joints: Mapping[str, Joint], bodies: Mapping[str, Body]) -> list[Complaint]:
    """Complaints about wheels and drums whose pins are not along the normal: they would not turn with the rope."""
    path: Path = rope.parameters["path"]
    _, _, n = axes(path.normal)
    complaints = []
    for k, node in enumerate(path.nodes):
        if node.kind not in ("wheel", "drum") or node.body == path.frame:
            continue
        leans = {joint.name: _lean(joint, node.body, n, bodies) for joint in joints.values() if _pins(joint, node.body)}
        pin = min(leans, key=lambda name: leans[name], default="")
        if leans and leans[pin] > THRESHOLDS.fleet_angle:
            lean = math.degrees(leans[pin])
            said = f"'{node.body}' turns about the axis of '{pin}', which is {lean:.4g} deg off the normal of the rope"
            at: KeyPath = ("joints", rope.name, "path", k, node.kind)
            complaints.append(Complaint(at, said, f"give the rope a 'normal' along the axis of '{pin}'"))
    return complaints


def _pins(joint: Joint, body: str) -> bool:
    return joint.type in ("revolute", "cylindrical") and body in joint.bodies and joint.axes is not None


def _lean(joint: Joint, body: str, n: Vector, bodies: Mapping[str, Body]) -> float:
    """The angle in rad between the line of a joint's axis at the scene's pose and a unit vector."""
    assert joint.axes is not None
    axis = joint.axes.first if joint.bodies[0] == body else joint.axes.second
    if joint.axes.local and body in bodies:
        x, y, z = (dot(row, axis) for row in to_matrix(bodies[body].orientation))
        axis = (x, y, z)
    return math.acos(min(1.0, abs(dot(axis, n)) / math.hypot(*axis)))


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
    length = joint.parameters.get("length")
    shortest = math.dist(path.nodes[0].at.vector, path.nodes[-1].at.vector) - abs(radii[0]) - abs(radii[-1])
    fixed = all(node.body == GROUND for node in (path.nodes[0], path.nodes[-1]))
    if length is not None and fixed and length < shortest:
        said = f"the rope is shorter than its path: {length:.6g} m between ends {shortest:.6g} m apart"
        yield Complaint(("joints", joint.name, "length"), said, "give a longer rope, or move its ends")
        return
    pairs = zip(pairwise(path.nodes), pairwise(radii), pairwise(seen), strict=True)
    fixed_spans = [
        math.sqrt(math.dist(*ends) ** 2 - (radius - other) ** 2)
        for (first, second), (radius, other), ends in pairs
        if first.body == second.body
    ]
    if length is not None and not path.lifting and length <= sum(fixed_spans):
        least = sum(fixed_spans)
        said = f"the rope is shorter than its path: {length:.6g} m, of {least:.6g} m between places of one body"
        yield Complaint(("joints", joint.name, "length"), said, "give a longer rope, or move its places")
