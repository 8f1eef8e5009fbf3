"""Fields of points and directions on one body or two: global, or by body in that body's axes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from mbproj.scene.fields import rotations
from mbproj.scene.fields.fields import (
    Alternatives,
    Complaint,
    Converted,
    Deferred,
    Field,
    List,
    NameChoice,
    Named,
    NameReference,
    Record,
)
from mbproj.scene.fields.quantities import (
    DIRECTION,
    POINT,
    Number,
    Placed,
    PositionAngle,
    different,
    global_pair,
    of_these_bodies,
    orientation_of,
    pair_of,
    rows,
    two_axes,
    two_points,
    unit_quaternion,
)
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.records import GROUND, Pair, Quaternion, Vector

JOINT_POINT: Field[Placed] = Alternatives((Converted(POINT, global_pair), Named("body", POINT)))
AXIS: Field[Placed] = Alternatives((Converted(DIRECTION, global_pair), Named("body", DIRECTION)))
AXES: Field[Placed] = Alternatives((Converted(List(DIRECTION, 2, "axes"), two_axes), Named("body", DIRECTION)))
#: The origin of a curve, and the point that follows it.
ORIGIN_AND_POINT: Field[Placed] = Alternatives(
    (Converted(List(POINT, 2, "points"), lambda points: Pair(*points)), Named("body", POINT))
)
TWO_POINTS: Field[Placed] = Alternatives((Converted(List(POINT, 2, "points"), two_points), Named("body", POINT)))
TWO_BODIES: Field[Any] = Converted(List(NameReference("body", "bodies", (GROUND,)), 2, "names of bodies"), different)
#: The orientation of a frame of each body, in that body's axes.
FRAMES: Field[Any] = Named("body", Deferred[Quaternion]("mbproj.scene.fields.placing:ORIENTATION"))
BODY_POINT: Field[Any] = Alternatives((POINT, Named("body", POINT)))
BODY_DIRECTION: Field[Any] = Alternatives((DIRECTION, Named("body", DIRECTION)))


def _pair_on(points: Mapping[str, Vector]) -> tuple[tuple[str, str], Pair]:
    """Two bodies and a global point of each."""
    if len(points) != 2:
        raise Unfit(f"needs points of two bodies, found {len(points)}", "as in {ground: [0, 0, 0], rod: [0, 0, 1]}")
    (first, start), (second, end) = points.items()
    return (first, second), Pair(start, end)


#: Two global points by body: these are global although bodies are named.
POINTS_OF: Field[Any] = Converted(Named("body", POINT), _pair_on)


def two_ends(points: tuple[tuple[str, str], Pair] | None, bodies: Any, locations: Any) -> tuple[tuple[str, str], Pair]:
    """Two bodies and a point of each, from `points`, or else from `bodies` with their `locations`."""
    if points is not None:
        return points
    if locations is None:
        raise Unfit("lacks 'locations'", "give a point of each of its bodies")
    return bodies, pair_of(locations, bodies)


#: A plane of body 1, on which body 2 stays.
PLANE = Record(
    "a plane",
    {"location": BODY_POINT, "normal": BODY_DIRECTION},
    lambda location, normal: (location, normal),
    ("location", "normal"),
)
#: The largest sine of the angle between the normal of a face and the plane of its curve.
UPRIGHT = 1e-6
#: The zero vector stands for a direction that is left open.
ANY = (0.0, 0.0, 0.0)


def on_plane(bodies: tuple[str, str], plane: Any, centre: Any, axis: Any, x: Any) -> tuple[Pair, Pair, Pair | None]:
    """The points, the axes and the x axes of two bodies. The first has the plane with its location and normal; the
    second has the centre, the axis and x. All are global, or all by body."""
    location, normal = plane
    by_key = {"plane": (location, normal), "centre": (centre,), "axis": (axis,), "x_axis": (x,)}
    local = isinstance(location, Mapping)
    for key, parts in by_key.items():
        if any(isinstance(part, Mapping) != local for part in parts if part is not None):
            raise Unfit(
                f"mixes global and local: its '{key}' is not as the 'plane' is", "give all of them as lists, or by body"
            )
    if not local:
        return Pair(location, centre), Pair(normal, normal if axis is None else axis), x and Pair(ANY, x)
    first, second = bodies
    along = Pair(normal[first], (0.0, 0.0, 1.0) if axis is None else axis[second], local=True)
    return Pair(location[first], centre[second], local=True), along, x and Pair(ANY, x[second], local=True)


def face_normal(axis: Placed, normal: Any) -> Iterator[Complaint]:
    """A check that the normal of a face is in the plane of the curve, and global or by body as the joint's axis is."""
    if isinstance(normal, Mapping) != isinstance(axis, Mapping):
        yield Complaint(("normal",), "the normal is not given as the axis is", "give both as lists, or both by body")
    elif isinstance(axis, Pair):
        lean = abs(sum(one * other for one, other in zip(axis.first, normal, strict=True)))
        if lean > UPRIGHT:
            said = f"the face leans by {math.degrees(math.asin(min(1.0, lean))):.3g} deg out of the plane of the curve"
            yield Complaint(("normal",), said, "give a normal across the axis")


def with_face(axes: Pair, bodies: tuple[str, str], normal: Any) -> Pair:
    """The axis of the first body, and the normal of a face of the second."""
    return Pair(axes.first, normal[bodies[1]] if isinstance(normal, Mapping) else normal, local=axes.local)


def of_side(key: str, side: int) -> Callable[[tuple[str, str], Any], Iterator[Complaint]]:
    """A check that a mapping by body under `key` has only the body number `side` (0 or 1) of the two."""

    def find(bodies: tuple[str, str], value: Any) -> Iterator[Complaint]:
        parts = zip(("location", "normal"), value, strict=True) if key == "plane" else [("", value)]
        for name, part in parts:
            for complaint in of_these_bodies(key)(bodies[side], part):
                path = (key, name, *complaint.path[1:]) if name else complaint.path
                yield complaint._replace(path=path)

    return find


# --- The field of an orientation of a body or a shape -----------------------------------------------------------------
# An axis and an angle, a quaternion, a matrix, or Euler angles.


QUATERNION: Field[Quaternion] = Converted(List(Number(), 4), unit_quaternion)

ORIENTATION: Field[Quaternion] = Converted(
    Alternatives(
        (
            Record(
                "a rotation",
                {"axis": DIRECTION, "angle": PositionAngle()},
                rotations.from_axis_angle,
                ("axis", "angle"),
            ),
            Record("a rotation", {"quaternion": QUATERNION}, lambda quaternion: quaternion, ("quaternion",)),
            Record("a rotation", {"matrix": Converted(rows(""), orientation_of)}, lambda matrix: matrix, ("matrix",)),
            Record(
                "a rotation",
                {
                    "euler": List(PositionAngle(), 3),
                    "sequence": NameChoice("sequence of axes", lambda: rotations.SEQUENCES),
                },
                lambda euler, sequence: rotations.from_euler(euler, sequence),
                ("euler", "sequence"),
            ),
        )
    ),
    unit_quaternion,
)
