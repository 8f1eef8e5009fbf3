"""The `curves` block: curves in a plane, for cams and slots, and in space, for slots.

track: {points: [[0, 0], [1, 0.2], [2, 0]]}                            # a spline; closed: true closes it
plate: {polyline: [[0, 0], [1, 0], [1, 1]], fillet: 20 mm, closed: true}
disc:  {circle: 40 mm}                                                 # or ellipse: [0.7, 0.4]
flank: {involute: {base: 38 mm, from: 5 deg, to: 40 deg}}              # of a tooth; by the angle that is unrolled
wire:  {space_points: [[0, 0, 0], [1, 0.2, 0.1], [2, 0, 0.3]]}         # a spline in space; closed: true closes it
drawn: {table: [[0 deg, 40 mm], [90 deg, 45 mm], [180 deg, 50 mm], [360 deg, 40 mm]]}
lift:  {lift: {base: 40 mm, rises: [[120 deg, 20 mm, cycloidal], [60 deg, 20 mm, dwell], ...]}, roller: 12 mm}
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, ClassVar

from mbproj.base.dataclass import dataclass
from mbproj.functions.curve_soundness import At, corner, crossing, undercut
from mbproj.functions.plane_curve import (
    FULL_TURN,
    LAWS,
    CamFollower,
    PlaneCurve,
    Rise,
    ellipse,
    involute,
    of_law,
    polar,
    polyline,
    through,
)
from mbproj.functions.space_curve import SpaceTrack, Track, through_space
from mbproj.scene.fields.fields import Converted, Field, Flag, List, NameChoice, OneOf, Record, Schema
from mbproj.scene.fields.quantities import Number, PositionAngle
from mbproj.scene.fields.reading import Reading, Unfit
from mbproj.scene.records import KeyPath
from mbproj.scene.text.nodes import Node, SequenceNode

if TYPE_CHECKING:
    from mbproj.functions.space_curve import SpaceTrack, Track


LENGTH = Number("m", above=0.0)
#: How far the sum of the angles of a lift law or a table may be from a whole turn, in rad.
WHOLE = 1e-9


@dataclass(frozen=True)
class RowField(Field[tuple[Any, ...]]):
    """A list whose entries are read by different fields, such as [angle, lift, law]."""

    items: tuple[Field[Any], ...]
    node_type: ClassVar[type] = SequenceNode

    @property
    def expects(self) -> str:
        return f"[{', '.join(each.expects for each in self.items)}]"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> tuple[Any, ...] | None:
        if not isinstance(node, SequenceNode) or len(node.items) != len(self.items):
            self.reject(node, path, reading)
            return None
        pairs = enumerate(zip(self.items, node.items, strict=True))
        values = [reading.read(field, item, (*path, at)) for at, (field, item) in pairs]
        return None if any(each is None for each in values) else tuple(values)

    def schema(self) -> Schema:
        rows = [each.schema() for each in self.items]
        array = {"prefixItems": rows, "minItems": len(rows), "maxItems": len(rows)}
        return {"description": self.expects, "type": "array", **array}


LAW = NameChoice("lift law", lambda: LAWS)
POINT: RowField = RowField((Number("m"), Number("m")))
POINTS: Field[Any] = List(POINT, None, "points")


def _whole_turn(rises: tuple[tuple[float, float, str], ...]) -> tuple[Rise, ...]:
    law_rises = tuple(Rise(*each) for each in rises)
    whole = sum(each.angle for each in law_rises)
    if abs(whole - FULL_TURN) > WHOLE:
        raise Unfit(f"goes over {math.degrees(whole):.10g} deg", "the angles of its rises add up to 360 deg")
    for before, each in pairwise((law_rises[-1], *law_rises)):
        if each.law == "dwell" and each.to != before.to:
            hint = "a dwell stays where the rise before has ended"
            raise Unfit(f"has a dwell that goes from {before.to:g} m to {each.to:g} m", hint)
    return law_rises


RISES: Field[Any] = Converted(List(RowField((PositionAngle(above=0.0), Number("m"), LAW)), None, "rises"), _whole_turn)
LIFT: Record[dict[str, Any]] = Record("a lift law", {"base": LENGTH, "rises": RISES}, dict, ("base", "rises"))


def _unrolled(**keys: float) -> dict[str, float]:
    if not (0.0 < keys["from"] < keys["to"] or keys["from"] < keys["to"] < 0.0):
        hint = "give from and to in increasing order, both above 0 deg or both below: at 0 it has a cusp"
        raise Unfit("has a cusp, or ends before it begins", hint)
    return keys


INVOLUTE: Record[dict[str, float]] = Record(
    "an involute", {"base": LENGTH, "from": PositionAngle(), "to": PositionAngle()}, _unrolled, ("base", "from", "to")
)


def _round(rows: tuple[tuple[float, float], ...]) -> tuple[tuple[float, float], ...]:
    """The rows [angle in rad, radius in m] of a polar table. Raises Unfit where they do not make one turn."""
    if len(rows) < 4:
        raise Unfit(f"has {len(rows)} rows", "give four or more, the last with the radius of the first")
    for (before, _), (after, _) in pairwise(rows):
        if not after > before:
            raise Unfit(f"has {after:g} rad after {before:g} rad", "the angles of its rows must increase")
    if abs(rows[-1][0] - rows[0][0] - FULL_TURN) > WHOLE or rows[-1][1] != rows[0][1]:
        raise Unfit("is not one turn", "its last row is its first again, 360 deg later")
    if min(radius for _, radius in rows) <= 0.0:
        raise Unfit("has a radius that is not positive")
    return rows


KEYS: Mapping[str, Field[Any]] = {
    "points": POINTS,
    "space_points": List(RowField((Number("m"), Number("m"), Number("m"))), None, "points"),
    "polyline": POINTS,
    "circle": LENGTH,
    "ellipse": List(LENGTH, 2, "half axes"),
    "involute": INVOLUTE,
    "table": Converted(List(RowField((PositionAngle(), Number("m"))), None, "rows"), _round),
    "lift": LIFT,
    "closed": Flag(),
    "fillet": LENGTH,
    "roller": LENGTH,
    "flat": Flag(),
    "clockwise": Flag(),
}
SHAPES = ("points", "space_points", "polyline", "circle", "ellipse", "involute", "table", "lift")


def _track(name: str, **keys: Any) -> Track | SpaceTrack:

    return track_of(name, **keys)


CURVE: Record[Track | SpaceTrack] = Record(
    "a curve",
    KEYS,
    _track,
    choices=(OneOf(SHAPES, needed=True), OneOf(("roller", "flat"))),
    named=True,
)


# --- Makes the curves that the keys of the `curves` block describe ----------------------------------------------------


#: The shapes with which a key may stand, by the key.
GOES_WITH: Mapping[str, tuple[str, ...]] = {
    "closed": ("points", "polyline", "space_points"),
    "fillet": ("polyline",),
    "roller": ("lift",),
    "flat": ("lift",),
    "clockwise": ("lift",),
}


def track_of(name: str, **keys: Any) -> Track | SpaceTrack:
    """The curve that these keys give. Raises Unfit where they do not fit each other, or the curve is not sound."""
    for key, shapes in GOES_WITH.items():
        if key in keys and not any(shape in keys for shape in shapes):
            raise Unfit(f"has no use for '{key}'", f"it goes with {' or '.join(shapes)}")
    if "space_points" in keys:
        closed = keys.get("closed", False)
        _refuse_few(keys["space_points"], 3 if closed else 2)
        return SpaceTrack(name, through_space(keys["space_points"], closed))
    radius = keys.get("roller", 0.0)
    followed = CamFollower("flat") if keys.get("flat") else CamFollower("roller" if radius else "point", radius)
    line = _line(keys, followed)
    _refuse(line, radius, followed)
    rows = keys.get("points", keys.get("table", ()))
    return Track(name, line, radius, tuple(rows), followed.kind == "flat")


def _line(keys: Mapping[str, Any], followed: CamFollower) -> PlaneCurve:
    closed = keys.get("closed", False)
    if "points" in keys:
        _refuse_few(keys["points"], 3 if closed else 2)
        return through(keys["points"], closed)
    if "polyline" in keys:
        _refuse_few(keys["polyline"], 3 if closed else 2)
        if "fillet" not in keys and (closed or len(keys["polyline"]) > 2):
            raise Unfit("has corners", "give the radius of their arcs as 'fillet'")
        try:
            return polyline(keys["polyline"], keys.get("fillet", 0.0), closed)
        except ValueError as error:
            where = error.args[0] + 1
            raise Unfit(f"has no room for the arc at its point {where}", "give a smaller 'fillet'") from error
    if "table" in keys:
        return polar(keys["table"])
    if "lift" in keys:
        lift = keys["lift"]
        lowest = lift["base"] + min(each.to for each in lift["rises"])
        if lowest <= 0.0:
            raise Unfit("goes through its axis", "give a larger 'base'")
        return of_law(lift["base"], lift["rises"], followed, keys.get("clockwise", False))
    if "involute" in keys:
        return involute(*(keys["involute"][key] for key in ("base", "from", "to")))
    return ellipse(keys["ellipse"] if "ellipse" in keys else (keys["circle"],) * 2)


def _refuse_few(points: Sequence[tuple[float, ...]], least: int) -> None:
    if len(points) < least:
        raise Unfit(f"has {len(points)} points", f"give {least} or more")
    for number, (one, other) in enumerate(pairwise(points), 2):
        if one == other:
            raise Unfit(f"has the same point twice, as its points {number - 1} and {number}", "leave one of them out")
    if least == 3 and points[0] == points[-1]:
        raise Unfit("is closed and ends with its first point", "leave the last one out")


def _refuse(line: PlaneCurve, roller: float, followed: CamFollower) -> None:
    """Raises Unfit where the curve has a cusp or a corner, crosses itself, or is undercut by its follower."""
    if followed.kind == "flat":
        radius = line.arrays.radius_of_curvature(line.places.s, line.places.piece)
        if radius.min() <= 0.0:
            at = int(radius.argmin())
            angle, more = math.degrees(line.places.s[at]), -radius[at]
            raise Unfit(
                f"is undercut at {angle:.4g} deg: a flat face does not touch it there",
                f"a 'base' larger by {more * 1e3:.4g} mm or more gives a convex cam",
            )
    fault = corner(line)
    if fault is not None:
        raise Unfit(f"has a corner at {place(fault)}", "give a smooth curve")
    fault = crossing(line)
    if fault is not None:
        raise Unfit(f"crosses itself near {place(fault)}", "a point there would have two places on it")
    fault = undercut(line, roller) if roller else None
    if fault is not None:
        hint = "give a larger 'base', a smaller 'roller', or a longer rise"
        raise Unfit(f"is undercut where the roller's centre is at {place(fault)}", hint)


def place(at: At) -> str:
    """A place of a curve as messages show it: [x, y] m."""
    return f"[{at.x:.4g}, {at.y:.4g}] m"
