"""The joint types, each a list of constraint primitives between two frames: the one place that knows a joint's name.

Body 1 and body 2 carry a point p and a right-handed triad x, y, z each; z1 and z2 are the joint's axes. A row names a
primitive of `mbproj.constraints` and the points and vectors that it binds. The rows are those of Haug (1989), ch. 9:
three `coincident` rows in m, `perpendicular` rows in rad to first order, `along` rows (the line from p1 to p2 has no
component along a vector) in m.

    frame "point"    no axis (the triads are the global axes at the pose of the scene)
          "axis"     z1 = z2 = the axis, x1 = x2 normal to it
          "axes"     z1 fixed in body 1, z2 in body 2; x1 is z2 and x2 is z1, made normal to their own z

`coordinates` are what the joint leaves free and can be counted, each a primitive whose value is the coordinate.
`aligned` lists pairs of vectors that the rows make parallel, and that must not end up opposite.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

#: A primitive's name and the points and vectors it takes, e.g. ("perpendicular", "x1", "z2"); "-y2" is minus y2.
Row = tuple[str, ...]

#: Unit of a coordinate by the primitive that measures it.
COORDINATE_UNITS = MappingProxyType({"angle": "rad", "along": "m"})


@dataclass(frozen=True)
class JointType:
    """One kind of joint: frame ("point", "axis" or "axes"), constraint rows, coordinates by name, aligned vectors."""

    frame: str
    rows: tuple[Row, ...]
    coordinates: Mapping[str, Row] = field(default_factory=dict)
    aligned: tuple[tuple[str, str], ...] = ()


TURN: Row = ("angle", "x1", "y1", "x2")
SLIDE: Row = ("along", "z1", "p1", "p2")
AXES_PARALLEL: tuple[Row, ...] = (("perpendicular", "x1", "z2"), ("perpendicular", "y1", "z2"))
ON_THE_AXIS: tuple[Row, ...] = (("along", "x1", "p1", "p2"), ("along", "y1", "p1", "p2"))
COINCIDENT: Row = ("coincident", "p1", "p2")

JOINTS: Mapping[str, JointType] = MappingProxyType(
    {
        "revolute": JointType("axis", (COINCIDENT, *AXES_PARALLEL), {"angle": TURN}, (("z1", "z2"),)),
        "spherical": JointType("point", (COINCIDENT,)),
        "universal": JointType(
            "axes",
            (COINCIDENT, ("perpendicular", "z1", "z2")),
            {"angle_1": ("angle", "x1", "y1", "z2"), "angle_2": ("angle", "x2", "-y2", "z1")},
        ),
        "prismatic": JointType(
            "axis",
            (*ON_THE_AXIS, *AXES_PARALLEL, ("perpendicular", "x1", "y2")),
            {"displacement": SLIDE},
            (("z1", "z2"), ("x1", "x2")),
        ),
    }
)
