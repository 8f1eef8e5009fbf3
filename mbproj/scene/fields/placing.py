"""Fields that say where something is on one body or two: global, or by body in its own axes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from mbproj.scene.fields.alternatives import Alternatives
from mbproj.scene.fields.checks import Placed, different, pair_of, shared, two_axes, two_points
from mbproj.scene.fields.choices import Reference
from mbproj.scene.fields.containers import Named
from mbproj.scene.fields.fields import Converted, Field, List
from mbproj.scene.fields.orientation import ORIENTATION
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.fields.vectors import DIRECTION, POINT
from mbproj.scene.records import GROUND, Pair, Vector

JOINT_POINT: Field[Placed] = Alternatives((Converted(POINT, shared), Named("body", POINT)))
AXIS: Field[Placed] = Alternatives((Converted(DIRECTION, shared), Named("body", DIRECTION)))
AXES: Field[Placed] = Alternatives((Converted(List(DIRECTION, 2, "axes"), two_axes), Named("body", DIRECTION)))
TWO_POINTS: Field[Placed] = Alternatives((Converted(List(POINT, 2, "points"), two_points), Named("body", POINT)))
TWO_BODIES: Field[Any] = Converted(List(Reference("body", "bodies", (GROUND,)), 2, "names of bodies"), different)
#: The orientation of a frame of each body, in that body's axes.
FRAMES: Field[Any] = Named("body", ORIENTATION)
BODY_POINT: Field[Any] = Alternatives((POINT, Named("body", POINT)))
BODY_DIRECTION: Field[Any] = Alternatives((DIRECTION, Named("body", DIRECTION)))


def _pair_on(points: Mapping[str, Vector]) -> tuple[tuple[str, str], Pair]:
    """Two bodies and a global point of each."""
    if len(points) != 2:
        raise Unfit(f"needs points of two bodies, found {len(points)}", "as in {ground: [0, 0, 0], rod: [0, 0, 1]}")
    (first, start), (second, end) = points.items()
    return (first, second), Pair(start, end)


#: Two points by body that are global all the same.
POINTS_OF: Field[Any] = Converted(Named("body", POINT), _pair_on)


def two_ends(points: tuple[tuple[str, str], Pair] | None, bodies: Any, locations: Any) -> tuple[tuple[str, str], Pair]:
    """Two bodies and a point of each, from `points`, or else from `bodies` with their `locations`."""
    if points is not None:
        return points
    if locations is None:
        raise Unfit("lacks 'locations'", "give a point of each of its bodies")
    return bodies, pair_of(locations, bodies)


def on_plane(bodies: tuple[str, str], plane: Any, centre: Any, axis: Any) -> tuple[Pair, Pair]:
    """The points and the axes of two bodies. The first has the plane, with its location and normal; on it is what has
    the centre and the axis. All are global, or all by body."""
    location, normal = plane
    given = {"plane": (location, normal), "centre": (centre,), "axis": (axis,)}
    local = isinstance(location, Mapping)
    for key, parts in given.items():
        if any(isinstance(part, Mapping) != local for part in parts if part is not None):
            raise Unfit(
                f"mixes global and local: its '{key}' is not as the 'plane' is", "give all of them as lists, or by body"
            )
    if not local:
        return Pair(location, centre), Pair(normal, normal if axis is None else axis)
    first, second = bodies
    along = Pair(normal[first], (0.0, 0.0, 1.0) if axis is None else axis[second], local=True)
    return Pair(location[first], centre[second], local=True), along
