"""The joint types, each a list of constraint primitives between two frames: the one place that knows a joint's name.

Body 1 and body 2 carry a point p and a right-handed triad x, y, z each; z1 and z2 are the joint's axes. A row names a
primitive of `joints.primitives` and the points and vectors that it binds; "-y2" is minus y2. A coupling of joints
binds the points and vectors of their coordinates. The rows are those of Haug (1989), ch. 9: `coincident` (3 rows),
`along` (the line from p1 to p2 has no component along a vector) and `distance` in m, `perpendicular` in rad to first
order.

    frame "point"    no axis (the triads are the global axes at the pose of the scene)
          "axis"     z1 = z2 = the axis, x1 = x2 normal to it
          "normal"   the axis is fixed in body 1 alone
          "face"     as "normal", and z2 is the normal of a face of body 2
          "axes"     z1 fixed in body 1, z2 in body 2; x1 is z2 and x2 is z1, made normal to their own z
          "plane"    z1 is the normal of a plane of body 1 through p1, z2 an axis of body 2 through p2
          "line"     as "plane", with the axis in the plane: x1 along it, x2 along the normal; body 2 rolls along -y1
          "joints"   no frame of its own: it couples coordinates of joints
          "path"     no frame: a row of places on any bodies, from which the rows follow

`coordinates` are free coordinates of the joint, each a primitive whose value is the coordinate. A joint without rows
only measures its coordinates. `aligned` lists pairs of vectors that the rows make parallel, and that must not end up
opposite. `constant_rows` are rows that keep their value at the scene's pose, or the value of the parameter that they
name. `parameters` are further keys of the joint; those that no row keeps are required, unless they are optional.
Parameters of primitives are those of the joint with the same names; several numbers are name_1, name_2 and so on. A
primitive on a curve takes the parameter `curve`. A row `coupling` couples coordinates, which the primitives in
`couples` measure; the function `coupling` returns their weights from the parameters. `x_axis`: whether the scene may,
or must, give the direction of x1 and x2. `has_axis`: whether the body on a plane has an axis. A joint that `merges`
makes one rigid body of two, unless its reaction is wanted. With `dry`, dry friction may act on its coordinates, or in
place of these on a `slip`, a row whose rate is that of sliding. `sketch` is the glyph in an animation, by default that
of the frame.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import field, replace
from types import MappingProxyType
from typing import Literal, NamedTuple, TypeAlias

from mbproj.base.dataclass import dataclass
from mbproj.functions.program import COORDINATE, Code, Op, Program, apply, number, variable

# --- The record of a joint type ---------------------------------------------------------------------------------------
# Its rows, its coordinates, its parameters in a scene, and its coupling of coordinates.


class Ratio(NamedTuple):
    """A row Σ kᵢ sᵢ - function(s₀) of coordinates: the `weights` kᵢ, the function, and the `period` of the sum. The
    period None follows from turns of the angles."""

    weights: tuple[float, ...]
    period: float | None
    function: Program | None = None


def thread(pitch: float) -> Ratio:
    """s - pitch φ / 2π in m, with the displacement s along z1 and the angle φ about it.

    `pitch` is the advance a turn in m, positive for a right-handed screw.
    """
    return Ratio((1.0, -pitch / (2.0 * math.pi)), abs(pitch))


def mesh(teeth: tuple[float, float], pressure_angle: float | None = None) -> Ratio:
    """(n1 φ1 + n2 φ2) / max(|n1|, |n2|) in rad, with the angles of two joints, for wheels of n1 and n2 `teeth`.

    Opposite signs of n1 and n2 make an internal gear or a belt. The `pressure_angle` counts in its bearings alone.
    """
    larger = max(abs(number) for number in teeth)
    return Ratio((teeth[0] / larger, teeth[1] / larger), 2.0 * math.pi / larger)


def pinion(radius: float) -> Ratio:
    """s - r φ in m, with the angle φ of a pinion of `radius` and the displacement s of its rack."""
    return Ratio((-radius, 1.0), None)


def wrap(radii: tuple[float, float]) -> Ratio:
    """(r1 φ1 - r2 φ2) / max(|r1|, |r2|) in rad, of two pulleys under a belt; a negative radius crosses it."""
    larger = max(abs(radius) for radius in radii)
    return Ratio((radii[0] / larger, -radii[1] / larger), None)


def tread(radius: float) -> Ratio:
    """s - r φ in m, with the angle φ of a wheel of `radius` and the way s on which it rolls."""
    return Ratio((1.0, -radius), 2.0 * math.pi * radius)


def halve() -> Ratio:
    """φ0 - (φ1 + φ2) / 2 in rad, of the carrier and the two shafts of a differential."""
    return Ratio((1.0, -0.5, -0.5), None)


def geneva(slots: float) -> Ratio:
    """φ2 + f(φ1) in rad, of a driver whose pin is on the line of centres at φ1 = 0, and of its wheel.

    In a slot f = atan2(k sin φ1, 1 - k cos φ1). k = sin(π/n), so that the pin enters the slot along it, where cos φ1 =
    k and f' = 0. Outside of slots f stays ±π/n. A turn of the driver is a step of 2π/n.
    """
    k, φ = math.sin(math.pi / slots), variable(COORDINATE)
    sine, cosine = apply(Op.SIN, φ), apply(Op.COS, φ)
    turned = apply(Op.ATAN2, _times(k, sine), apply(Op.SUBTRACT, number(1.0), _times(k, cosine)))
    # φ minus its distance from ±π, which does not jump at a half turn
    back = apply(Op.ATAN2, apply(Op.NEGATE, sine), apply(Op.NEGATE, cosine))
    stays = _times(1.0 / slots, apply(Op.SUBTRACT, φ, back))
    locked = apply(Op.ADD, number(0.5), _times(0.5, apply(Op.SIGN, apply(Op.SUBTRACT, number(k), cosine))))
    turn = apply(Op.ADD, turned, apply(Op.MULTIPLY, locked, apply(Op.SUBTRACT, stays, turned)))
    return Ratio((0.0, 1.0), None, Program(apply(Op.NEGATE, turn)))


def _times(factor: float, code: Code) -> Code:
    return apply(Op.MULTIPLY, number(factor), code)


#: A primitive's name and the points and vectors it takes, e.g. ("perpendicular", "x1", "z2").
Row = tuple[str, ...]


MayBe: TypeAlias = Literal[
    "any", "positive", "nonzero", "teeth", "slots", "curve", "space_curve", "convex", "side", "pressure"
]


class Parameter(NamedTuple):
    """A parameter of a joint: a number in an SI unit ("": none), or the name of a curve or of a side. With `many` it is
    a list of so many, called `words` in messages. `optional`: whether it may be left out."""

    unit: str
    may_be: MayBe = "any"
    many: int | None = None
    words: str = "numbers"
    optional: bool = False


@dataclass(frozen=True)
class JointType:
    """A joint type. `separate`: the scene gives a point in each body, because the rows do not make them coincide.
    `mbproj.joints.table` describes the fields."""

    frame: str
    rows: tuple[Row, ...]
    coordinates: Mapping[str, Row] = field(default_factory=dict)
    aligned: tuple[tuple[str, str], ...] = ()
    separate: bool = False
    constant_rows: Mapping[int, str | None] = field(default_factory=dict)
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    couples: tuple[str, ...] = ()
    coupling: Callable[..., Ratio] | None = None
    merges: bool = False
    x_axis: Literal["none", "optional", "required"] = "none"
    has_axis: bool = False
    dry: bool = False
    slip: Row = ()
    sketch: str = ""

    @property
    def required_parameters(self) -> tuple[str, ...]:
        """The parameters without a default. A parameter that a row keeps has its value at the scene's pose as default,
        except for a joint on a plane."""
        able = {} if self.is_on_plane else {*self.constant_rows.values()}
        return tuple(name for name, each in self.parameters.items() if not (each.optional or name in able))

    @property
    def is_on_plane(self) -> bool:
        """Whether body 2 is on a plane of body 1."""
        return self.frame in ("plane", "line")

    @property
    def turns(self) -> bool:
        """Whether the joint turns about an axis of both bodies."""
        return "angle" in self.coordinates

    @property
    def is_threaded(self) -> bool:
        """Whether a row couples its own coordinates."""
        return bool(self.couples) and self.frame != "joints"

    @property
    def is_rod(self) -> bool:
        """Whether a rod joins its two points, of constant length or not."""
        return any(row[0] == "distance" for row in (*self.rows, *self.coordinates.values()))


# --- The joint types, each a list of constraint primitives between two frames -----------------------------------------


class PrimitiveType(NamedTuple):
    """A constraint primitive: its `home`, the module and the class that define it, and the SI unit of its value. A
    coordinate that no coupling may use is described as `uncoupled` in messages."""

    home: str
    unit: str
    uncoupled: str = ""


#: The constraint primitives by name.
PRIMITIVE_TYPES: Mapping[str, PrimitiveType] = MappingProxyType(
    {
        "coincident": PrimitiveType("mbproj.joints.primitives.basic:Coincident", "m"),
        "perpendicular": PrimitiveType("mbproj.joints.primitives.basic:Perpendicular", "rad"),
        "along": PrimitiveType("mbproj.joints.primitives.basic:Along", "m"),
        "distance": PrimitiveType("mbproj.joints.primitives.basic:Distance", "m"),
        "angle": PrimitiveType("mbproj.joints.primitives.basic:Angle", "rad"),
        "coupling": PrimitiveType("mbproj.joints.primitives.coupling:Coupling", ""),
        "wheel_height": PrimitiveType("mbproj.joints.primitives.rolling:WheelHeight", "m"),
        "wheel_slip_along": PrimitiveType("mbproj.joints.primitives.rolling:WheelSlipAlong", "m"),
        "wheel_slip_across": PrimitiveType("mbproj.joints.primitives.rolling:WheelSlipAcross", "m"),
        "ball_slip": PrimitiveType("mbproj.joints.primitives.rolling:BallSlip", "m"),
        "edge_slip": PrimitiveType("mbproj.joints.primitives.rolling:EdgeSlip", "m"),
        "ellipsoid_height": PrimitiveType("mbproj.joints.primitives.rolling:EllipsoidHeight", "m"),
        "ellipsoid_slip": PrimitiveType("mbproj.joints.primitives.rolling:EllipsoidSlip", "m"),
        "profile": PrimitiveType("mbproj.joints.primitives.plane_curves:Profile", "m", "a distance from a curve"),
        "arc": PrimitiveType("mbproj.joints.primitives.plane_curves:Arc", "m", "a length along a curve"),
        "lap": PrimitiveType("mbproj.joints.primitives.plane_curves:Lap", "rad"),
        "face": PrimitiveType("mbproj.joints.primitives.plane_curves:Face", "m", "a distance from a curve"),
        "face_place": PrimitiveType("mbproj.joints.primitives.plane_curves:FacePlace", "m", "a place on a face"),
        "face_slip": PrimitiveType("mbproj.joints.primitives.plane_curves:FaceSlip", "m"),
        "two_curves": PrimitiveType("mbproj.joints.primitives.plane_curves:Gap", "m", "a distance from a curve"),
        "place_on_first": PrimitiveType(
            "mbproj.joints.primitives.plane_curves:PlaceOnFirst", "m", "a length along a curve"
        ),
        "place_on_second": PrimitiveType(
            "mbproj.joints.primitives.plane_curves:PlaceOnSecond", "m", "a length along a curve"
        ),
        "slip_of_two": PrimitiveType("mbproj.joints.primitives.plane_curves:SlipOfTwo", "m"),
        "beside_first": PrimitiveType("mbproj.joints.primitives.space_curves:BesideFirst", "m"),
        "beside_second": PrimitiveType("mbproj.joints.primitives.space_curves:BesideSecond", "m"),
        "space_arc": PrimitiveType("mbproj.joints.primitives.space_curves:SpaceArc", "m", "a length along a curve"),
        "surface": PrimitiveType("mbproj.joints.primitives.surfaces:Surface", "m", "a distance from a surface"),
        "meridian": PrimitiveType("mbproj.joints.primitives.surfaces:Meridian", "m", "a length along a curve"),
        "rope": PrimitiveType("mbproj.joints.primitives.rope:Rope", "m", "the length of a rope"),
    }
)
#: Unit of a coordinate by the primitive that measures it.
COORDINATE_UNITS: Mapping[str, str] = MappingProxyType({name: each.unit for name, each in PRIMITIVE_TYPES.items()})
#: Unit of the inertia of a coordinate by that of the coordinate.
INERTIA_UNITS = MappingProxyType({"rad": "kg*m^2", "m": "kg"})


TURN: Row = ("angle", "x1", "y1", "x2")
SLIDE: Row = ("along", "z1", "p1", "p2")
SLIDE_X: Row = ("along", "x1", "p1", "p2")
SLIDE_Y: Row = ("along", "y1", "p1", "p2")
FORWARD: Row = ("along", "-y1", "p1", "p2")
ROLLED: Row = ("angle", "z1", "-y1", "x2")
IN_PLANE: Mapping[str, Row] = MappingProxyType({"displacement_x": SLIDE_X, "displacement_y": SLIDE_Y})
COINCIDENT: Row = ("coincident", "p1", "p2")
ROD: Row = ("distance", "p1", "p2")
AXES_PARALLEL: tuple[Row, ...] = (("perpendicular", "x1", "z2"), ("perpendicular", "y1", "z2"))
NO_TURN: tuple[Row, ...] = (*AXES_PARALLEL, ("perpendicular", "x1", "y2"))
TRIADS: Row = ("p1", "x1", "y1", "z1", "p2", "x2", "y2", "z2")
COUPLED: tuple[Row, ...] = (("coupling",),)
TWO_ANGLES = ("angle", "angle")
LENGTH = Parameter("m", "positive")
ON_CURVE = ("x1", "y1", "p1", "p2")
CURVE = Parameter("", "curve")
#: The parameters of a joint that follows a profile: the curve, the roller, and the side.
FOLLOWS: Mapping[str, Parameter] = MappingProxyType(
    {"curve": CURVE, "roller": LENGTH._replace(optional=True), "side": Parameter("", "side", optional=True)}
)
CONVEX: Mapping[str, Parameter] = MappingProxyType({"curve": Parameter("", "convex")})
PROFILE: Row = ("profile", *ON_CURVE)
FACE: Row = ("face", "x1", "y1", "z2", "p1", "p2")
ARC: Row = ("arc", *ON_CURVE)
TWO_CURVES: Row = ("two_curves", "x1", "y1", "x2", "p1", "p2")
IN_SPACE = ("x1", "y1", "z1", "p1", "p2")
TOUCHED: Mapping[str, Row] = MappingProxyType(
    {"displacement_1": ("place_on_first", *TWO_CURVES[1:]), "displacement_2": ("place_on_second", *TWO_CURVES[1:])}
)
ONE_AXIS, ONE_TRIAD = (("z1", "z2"),), (("z1", "z2"), ("x1", "x2"))


def _following(
    rows: tuple[Row, ...],
    coordinates: Mapping[str, Row],
    parameters: Mapping[str, Parameter] = FOLLOWS,
    constant_rows: Mapping[int, str | None] = MappingProxyType({}),
    *,
    dry: bool = False,
    frame: str = "normal",
    sketch: str = "track",
) -> JointType:
    """A joint whose body 2 follows a curve of body 1."""
    return JointType(
        frame, rows, coordinates, (), True, constant_rows, parameters, x_axis="required", dry=dry, sketch=sketch
    )


def _touching(rows: tuple[Row, ...], coordinates: Mapping[str, Row], slip: Row = ()) -> JointType:
    """A joint whose two bodies have a curve each."""
    parameters = {
        "curves": Parameter("", "curve", 2, "names of curves"),
        "sides": Parameter("", "side", 2, "sides", optional=True),
    }
    touching = JointType("axis", rows, coordinates, (), True, {}, parameters)
    return replace(touching, x_axis="required", dry=bool(slip), slip=slip, sketch="tracks")


JOINTS: Mapping[str, JointType] = MappingProxyType(
    {
        "revolute": JointType("axis", (COINCIDENT, *AXES_PARALLEL), {"angle": TURN}, ONE_AXIS, dry=True),
        "spherical": JointType("point", (COINCIDENT,)),
        "universal": JointType(
            "axes",
            (COINCIDENT, ("perpendicular", "z1", "z2")),
            {"angle_1": ("angle", "x1", "y1", "z2"), "angle_2": ("angle", "x2", "-y2", "z1")},
        ),
        "prismatic": JointType(
            "axis",
            (SLIDE_X, SLIDE_Y, *NO_TURN),
            {"displacement": SLIDE},
            ONE_TRIAD,
            dry=True,
            sketch="slider",
        ),
        "cylindrical": JointType(
            "axis",
            (SLIDE_X, SLIDE_Y, *AXES_PARALLEL),
            {"angle": TURN, "displacement": SLIDE},
            ONE_AXIS,
            dry=True,
            sketch="sleeve",
        ),
        "planar": JointType(
            "axis",
            (SLIDE, *AXES_PARALLEL),
            {**IN_PLANE, "angle": TURN},
            ONE_AXIS,
            x_axis="optional",
            sketch="puck",
        ),
        "fixed": JointType("point", (COINCIDENT, *NO_TURN), aligned=ONE_TRIAD, merges=True, sketch="weld"),
        "distance": JointType(
            "point",
            (ROD,),
            separate=True,
            constant_rows={0: "length"},
            parameters={"length": LENGTH},
            sketch="two_balls",
        ),
        "telescope": JointType("point", (), {"length": ROD}, separate=True, dry=True, sketch="two_balls"),
        "revolute_spherical": JointType(
            "normal",
            (SLIDE, ROD),
            separate=True,
            constant_rows={0: None, 1: "length"},
            parameters={"length": LENGTH},
            sketch="pin_and_ball",
        ),
        "point_in_plane": JointType("normal", (SLIDE,), IN_PLANE, x_axis="optional"),
        "point_on_line": JointType("normal", (SLIDE_X, SLIDE_Y), {"displacement": SLIDE}, sketch="on_line"),
        "cam": _following((PROFILE,), {"displacement": ARC}, dry=True),
        "cam_contact": _following((), {"gap": PROFILE}),
        "flat_follower": replace(
            _following((FACE,), {"displacement": ("face_place", *FACE[1:])}, CONVEX, frame="face", sketch="tappet"),
            dry=True,
            slip=("face_slip", *FACE[1:]),
        ),
        "flat_contact": _following((), {"gap": FACE}, CONVEX, frame="face", sketch="tappet"),
        "space_slot": replace(
            _following(
                (("beside_first", *IN_SPACE), ("beside_second", *IN_SPACE)),
                {"displacement": ("space_arc", *IN_SPACE)},
                {"curve": Parameter("", "space_curve")},
                dry=True,
                frame="axis",
                sketch="wire",
            ),
            separate=True,
        ),
        "curve_on_curve": _touching((TWO_CURVES,), TOUCHED, ("slip_of_two", *TWO_CURVES[1:])),
        "curve_contact": _touching((), {"gap": TWO_CURVES}),
        "slot": _following((PROFILE, SLIDE), {"displacement": ARC}, {"curve": CURVE}, dry=True),
        "ball_on_surface": JointType(
            "normal",
            (("surface", "z1", "p1", "p2"),),
            {"displacement": ("meridian", "z1", "p1", "p2")},
            separate=True,
            parameters=FOLLOWS,
            sketch="wire",
        ),
        "screw": JointType(
            "axis",
            (SLIDE_X, SLIDE_Y, *AXES_PARALLEL, ("coupling", *SLIDE[1:], *TURN[1:])),
            {"angle": TURN, "displacement": SLIDE},
            ONE_AXIS,
            parameters={"pitch": Parameter("m", "nonzero")},
            couples=("along", "angle"),
            coupling=thread,
            dry=True,
            sketch="screw",
        ),
        "rolling_wheel": JointType(
            "plane",
            (("wheel_height", "p1", "z1", "p2", "z2"), ("wheel_slip_along", *TRIADS), ("wheel_slip_across", *TRIADS)),
            IN_PLANE,
            parameters={"radius": LENGTH},
            has_axis=True,
            sketch="wheel",
        ),
        "rolling_ball": JointType(
            "plane",
            (SLIDE, ("ball_slip", *TRIADS), ("ball_slip", "p1", "y1", "-x1", *TRIADS[3:])),
            IN_PLANE,
            constant_rows={0: "radius"},
            parameters={"radius": LENGTH},
            sketch="rolling_ball",
        ),
        "rolling_ellipsoid": JointType(
            "plane",
            (
                ("ellipsoid_height", "p1", "z1", "p2", "x2", "y2", "z2"),
                ("ellipsoid_slip", *TRIADS),
                ("ellipsoid_slip", "p1", "y1", "-x1", *TRIADS[3:]),
            ),
            IN_PLANE,
            parameters={"semi_axes": Parameter("m", "positive", 3, "semi-axes")},
            x_axis="required",
            has_axis=True,
            sketch="ellipsoid",
        ),
        "rolling_on_line": JointType(
            "line",
            (
                ("wheel_height", "p1", "z1", "p2", "z2"),
                SLIDE_X,
                ("perpendicular", "z1", "z2"),
                ("perpendicular", "y1", "z2"),
                ("coupling", *FORWARD[1:], *ROLLED[1:]),
            ),
            {"displacement": FORWARD, "angle": ROLLED},
            (("x1", "z2"),),
            constant_rows={1: None, 4: None},
            parameters={"radius": LENGTH},
            couples=("along", "angle"),
            coupling=tread,
            has_axis=True,
            sketch="wheel",
        ),
        "rolling_on_curve": _following(
            (PROFILE, ("coupling", *ON_CURVE, *TURN[1:])),
            {"displacement": ARC, "lap": ("lap", *ON_CURVE), "angle": TURN},
            {**FOLLOWS, "roller": LENGTH},
            constant_rows={1: None},
        ),
        "knife_edge": JointType("axis", (("edge_slip", *TRIADS),), sketch="blade"),
        "rope": JointType("path", (), {"length": ("rope",)}, sketch="two_balls"),
        "gear": JointType(
            "joints",
            COUPLED,
            parameters={
                "teeth": Parameter("", "teeth", 2, "numbers of teeth"),
                "pressure_angle": Parameter("rad", "pressure", optional=True),
            },
            couples=TWO_ANGLES,
            coupling=mesh,
        ),
        "rack": JointType(
            "joints",
            COUPLED,
            parameters={"radius": Parameter("m", "nonzero")},
            couples=("angle", "along"),
            coupling=pinion,
        ),
        "belt": JointType(
            "joints",
            COUPLED,
            parameters={"radii": Parameter("m", "nonzero", 2, "radii")},
            couples=TWO_ANGLES,
            coupling=wrap,
        ),
        "geneva": JointType(
            "joints",
            COUPLED,
            parameters={"slots": Parameter("", "slots")},
            couples=TWO_ANGLES,
            coupling=geneva,
        ),
        "differential": JointType("joints", COUPLED, couples=(*TWO_ANGLES, "angle"), coupling=halve),
        "coupler": JointType("joints", COUPLED),
    }
)
