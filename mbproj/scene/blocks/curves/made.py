"""Makes the curves that the keys of the `curves` block describe."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any

from mbproj.functions.curves.plane_curve import PlaneCurve
from mbproj.functions.curves.shapes import CamFollower, ellipse, involute, of_law, polar, polyline, through
from mbproj.functions.curves.soundness import At, corner, crossing, undercut
from mbproj.functions.curves.space_curve import through_space
from mbproj.functions.curves.track import SpaceTrack, Track
from mbproj.scene.fields.reading import Unfit

#: The shapes with which a key may stand, by the key.
GOES_WITH: Mapping[str, tuple[str, ...]] = {
    "closed": ("points", "polyline", "space_points"),
    "fillet": ("polyline",),
    "roller": ("lift",),
    "flat": ("lift",),
    "clockwise": ("lift",),
}


def track_of(name: str, **given: Any) -> Track | SpaceTrack:
    """The curve that these keys give. Raises Unfit where they do not fit each other, or the curve is not sound."""
    for key, shapes in GOES_WITH.items():
        if key in given and not any(shape in given for shape in shapes):
            raise Unfit(f"has no use for '{key}'", f"it goes with {' or '.join(shapes)}")
    if "space_points" in given:
        closed = given.get("closed", False)
        _refuse_few(given["space_points"], 3 if closed else 2)
        return SpaceTrack(name, through_space(given["space_points"], closed))
    radius = given.get("roller", 0.0)
    followed = CamFollower("flat") if given.get("flat") else CamFollower("roller" if radius else "point", radius)
    line = _line(given, followed)
    _refuse(line, radius, followed)
    rows = given.get("points", given.get("table", ()))
    return Track(name, line, radius, tuple(rows), followed.kind == "flat")


def _line(given: Mapping[str, Any], followed: CamFollower) -> PlaneCurve:
    closed = given.get("closed", False)
    if "points" in given:
        _refuse_few(given["points"], 3 if closed else 2)
        return through(given["points"], closed)
    if "polyline" in given:
        _refuse_few(given["polyline"], 3 if closed else 2)
        if "fillet" not in given and (closed or len(given["polyline"]) > 2):
            raise Unfit("has corners", "give the radius of their arcs as 'fillet'")
        try:
            return polyline(given["polyline"], given.get("fillet", 0.0), closed)
        except ValueError as error:
            where = error.args[0] + 1
            raise Unfit(f"has no room for the arc at its point {where}", "give a smaller 'fillet'") from error
    if "table" in given:
        return polar(given["table"])
    if "lift" in given:
        lift = given["lift"]
        lowest = lift["base"] + min(each.to for each in lift["rises"])
        if lowest <= 0.0:
            raise Unfit("goes through its axis", "give a larger 'base'")
        return of_law(lift["base"], lift["rises"], followed, given.get("clockwise", False))
    if "involute" in given:
        return involute(*(given["involute"][key] for key in ("base", "from", "to")))
    return ellipse(given["ellipse"] if "ellipse" in given else (given["circle"],) * 2)


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
