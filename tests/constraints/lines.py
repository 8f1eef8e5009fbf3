"""Curves of each form, primitives on them, and primitives with numbers."""

from __future__ import annotations

from math import pi

from mbproj.functions.plane_curve import CamFollower, Rise, ellipse, of_law, polar, polyline, through
from mbproj.functions.space_curve import through_space
from mbproj.joints.primitives.basic import Primitive
from mbproj.joints.primitives.plane_curves import (
    Arc,
    Face,
    FacePlace,
    FaceSlip,
    Gap,
    Lap,
    PlaceOnFirst,
    PlaceOnSecond,
    Profile,
    SlipOfTwo,
)
from mbproj.joints.primitives.space_curves import BesideFirst, BesideSecond, SpaceArc

CORNERS = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 0.6), (0.0, 1.0)]
RISES = [
    Rise(2.0 * pi / 3.0, 0.3, "cycloidal"),
    Rise(pi / 3.0, 0.3, "dwell"),
    Rise(2.0 * pi / 3.0, 0.0, "modified_sine"),
    Rise(pi / 3.0, 0.0, "dwell"),
]
TABLE = [(0.0, 1.0), (0.5 * pi, 1.2), (pi, 1.0), (4.5, 0.9), (2.0 * pi, 1.0)]


def made(kind: type[Primitive]) -> Primitive:
    """One of this kind with parameters that differ."""
    return kind(**{name: 0.7 + 0.2 * at for at, name in enumerate(kind.parameters)})


#: Of sizes about 1 m.
LINES = {
    "spline": through([(1.0, 0.0), (0.2, 0.8), (-0.7, 0.3), (-0.4, -0.8)], closed=True),
    "open spline": through([(0.0, 0.0), (1.0, 0.2), (2.0, 0.0)], closed=False),
    "ellipse": ellipse((0.7, 0.4)),
    "large": ellipse((3.0, 2.8)),
    "polyline": polyline(CORNERS, 0.1, closed=True),
    "open polyline": polyline(CORNERS[:3], 0.1, closed=False),
    "table": polar(TABLE),
    "roller": of_law(0.6, RISES, CamFollower("roller", 0.1), clockwise=False),
    "clockwise": of_law(0.6, RISES, CamFollower("point"), clockwise=True),
    "flat": of_law(0.9, RISES, CamFollower("flat"), clockwise=False),
    "flat, clockwise": through([(1.0, 0.0), (0.1, -0.9), (-0.8, 0.1), (0.0, 0.8)], closed=True),
}
WIRES = {
    "wire": through_space([(1.0, 0.0, 0.2), (0.2, 0.8, -0.3), (-0.7, 0.3, 0.4), (-0.4, -0.8, 0.0)], closed=True),
    "open wire": through_space([(0.0, 0.0, 0.0), (1.0, 0.2, 0.3), (2.0, 0.0, -0.1)], closed=False),
}
ON_CURVES = {
    "first beside a wire": BesideFirst(WIRES["wire"]),
    "second beside a wire": BesideSecond(WIRES["wire"]),
    "along a wire": SpaceArc(WIRES["wire"]),
    "outside": Profile(LINES["spline"], side=-1.0, reach=0.1),
    "inside": Profile(LINES["ellipse"], side=1.0),
    "held": Profile(LINES["ellipse"], piece=0, side=-1.0, reach=0.2),
    "arc": Arc(LINES["roller"]),
    "lap": Lap(LINES["spline"], offset=-0.1, scale=0.8),
    "lap on a piece": Lap(LINES["ellipse"], piece=0, offset=0.1, scale=1.3),
    "face": Face(LINES["flat"]),
    "face of an ellipse": Face(LINES["ellipse"]),
    "place on a face": FacePlace(LINES["flat"]),
    "place on a face, clockwise": FacePlace(LINES["flat, clockwise"]),
    "slip of a face": FaceSlip(LINES["flat"]),
    "slip of a face, clockwise": FaceSlip(LINES["flat, clockwise"]),
    "face on a piece": Face(LINES["ellipse"], piece=0),
    "two curves": Gap(LINES["ellipse"], LINES["flat"], side=-1.0, other_side=-1.0, reach=0.1),
    "one in the other": Gap(LINES["large"], LINES["ellipse"], side=1.0, other_side=-1.0),
    "two curves on pieces": Gap(LINES["ellipse"], LINES["large"], piece=0, other_piece=0, side=-1.0, other_side=-1.0),
    "place on the first": PlaceOnFirst(LINES["ellipse"], LINES["flat"], side=-1.0, other_side=-1.0),
    "place on the second": PlaceOnSecond(LINES["flat"], LINES["flat, clockwise"], side=-1.0, other_side=1.0),
    "slip of two": SlipOfTwo(LINES["ellipse"], LINES["flat"], side=-1.0, other_side=-1.0),
    "slip of two, clockwise": SlipOfTwo(LINES["flat"], LINES["flat, clockwise"], side=-1.0, other_side=1.0),
    "place on the first, hollow": PlaceOnFirst(LINES["spline"], LINES["ellipse"], side=-1.0, other_side=-1.0),
    "arc of an open one": Arc(LINES["open polyline"]),
}
