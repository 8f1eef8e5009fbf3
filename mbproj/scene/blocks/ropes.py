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

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from mbproj.scene.blocks.ropes.path import KINDS, Node, Path, dot
from mbproj.scene.fields.choices import NameChoice, NameReference
from mbproj.scene.fields.containers import OneOf, Record
from mbproj.scene.fields.fields import Converted, Field, Flag, List
from mbproj.scene.fields.placing import BODY_POINT
from mbproj.scene.fields.quantities import DIRECTION, Number
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.fields.rotations import to_matrix
from mbproj.scene.records import GROUND, Body, Joint, Motion, Pair, Vector
from mbproj.scene.stops import Limit, OfBody, StopLaw

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
