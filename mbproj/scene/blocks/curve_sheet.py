"""A curve as a table: its profile, its curvature, and the pressure angle of its follower."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, choose_from
from mbproj.functions.curve_soundness import largest_roller, most_bent
from mbproj.functions.space_curve import SpaceTrack, Track

if TYPE_CHECKING:
    from mbproj.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class Sheet:
    """A curve as columns of rows, (m,) each. `x`, `y` in m are the profile, `line_x`, `line_y` the line of the
    follower's point or roller centre. `arc` in m is the length along that line, `angle` in rad and `radius` in m are
    its polar coordinates about the origin.

    `pressure` in rad is the angle between the force on a follower and its motion on a line through the origin; NaN of
    an open curve. `curvature` in 1/m is that of the profile, positive where it bulges outward, or to the left of an
    open one; `bends` are its least and its largest, also between rows. `rollers`: the side and the radius in m of the
    largest roller that fits there, infinite where any does.
    """

    name: str
    closed: bool
    roller: float
    flat: bool
    arc: Array
    x: Array
    y: Array
    line_x: Array
    line_y: Array
    angle: Array
    radius: Array
    pressure: Array
    curvature: Array
    bends: tuple[float, float]
    rollers: dict[str, float]

    def columns(self) -> dict[str, Array]:
        """The columns of the table by their headings, in SI units and radians."""
        by_heading = {"arc length (m)": self.arc, "x (m)": self.x, "y (m)": self.y}
        if self.roller:
            by_heading |= {"centre x (m)": self.line_x, "centre y (m)": self.line_y}
        by_heading |= {"angle (rad)": self.angle, "radius (m)": self.radius}
        if self.closed:
            by_heading["pressure angle (rad)"] = self.pressure
        return by_heading | {"curvature (1/m)": self.curvature}


def sheet_of(scene: Scene, name: str | None, rows: int) -> Sheet:
    """The sheet of the scene's curve of this name; None is the only one. Raises InputError where there is no such
    curve, several and no name, or it is in space."""
    curves = {track.name: track for track in scene.curves}
    if not curves:
        raise InputError(Problem("the scene has no block 'curves'", hint="mbproj help follow_a_curve"))
    if name is None and len(curves) > 1:
        raise InputError(Problem("the scene has several curves", Place("NAME"), f"give one of {', '.join(curves)}"))
    wanted = next(iter(curves)) if name is None else name
    if wanted not in curves:
        raise InputError(Problem(f"unknown curve '{wanted}'", Place("NAME"), choose_from(wanted, list(curves))))
    curve = curves[wanted]
    if isinstance(curve, SpaceTrack):
        said = f"curve '{wanted}' is in space, and has no profile"
        raise InputError(Problem(said, Place("NAME"), "give one in a plane; mbproj animate shows this one"))
    return sheet(curve, rows)


def sheet(track: Track, rows: int) -> Sheet:
    """The sheet of a curve, with `rows` rows from its beginning to its end, evenly spaced by its parameter."""
    line = track.line
    s = np.linspace(line.start, line.end, rows)
    piece = line.at(s)
    (x, y), (x1, y1), (x2, y2), _ = line.derivatives(s, piece)
    speed = np.hypot(x1, y1)
    tx, ty = x1 / speed, y1 / speed
    bend = (x1 * y2 - y1 * x2) / speed**3
    offset = track.roller  # the distance of the profile to the left of the line
    outward = -1.0 if line.closed and not line.turns_left else 1.0
    radius = np.hypot(x, y)
    return Sheet(
        name=track.name,
        closed=line.closed,
        roller=track.roller,
        flat=track.flat,
        arc=np.real(line.length_at(s, piece)),
        x=x - offset * ty,
        y=y + offset * tx,
        line_x=x,
        line_y=y,
        angle=np.unwrap(np.arctan2(y, x)),
        radius=radius,
        pressure=_pressure(x, y, tx, ty, radius, track),
        curvature=outward * bend / (1.0 - bend * offset),
        bends=_bends(track, outward),
        rollers=_rollers(track),
    )


def _pressure(x: Array, y: Array, tx: Array, ty: Array, radius: Array, track: Track) -> Array:
    """The pressure angle (m,) in rad, between the curve's normal and the line from the origin. It is 0 for a flat face,
    which is pushed along its own normal, and NaN for an open curve."""
    if not track.line.closed:
        return np.full(len(x), np.nan)
    if track.flat:
        return np.zeros(len(x))
    along = np.abs(tx * x + ty * y) / radius
    return np.asarray(np.arcsin(np.clip(along, 0.0, 1.0)))


def _bends(track: Track, outward: float) -> tuple[float, float]:
    """The least and the largest curvature in 1/m of the profile, counted as in the column."""
    found = [most_bent(track.line, left) for left in (True, False)]
    profile = [outward * bend / (1.0 - bend * track.roller) for bend in found]
    return min(profile), max(profile)


def _rollers(track: Track) -> dict[str, float]:
    """The radius in m of the largest roller on the profile, by its side."""
    sides = ("outside", "inside") if track.line.closed else ("left", "right")
    return {side: largest_roller(track.line, track.is_left(side), track.roller) for side in sides}
