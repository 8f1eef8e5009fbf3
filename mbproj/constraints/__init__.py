"""The constraint primitives by name, each defined once (Haug 1989, ch. 9; Nikravesh 1988, ch. 7). This package imports
nothing else of mbproj."""

from collections.abc import Mapping
from types import MappingProxyType

from mbproj.constraints.angle import Angle
from mbproj.constraints.basic import Along, Coincident, Distance, Perpendicular
from mbproj.constraints.coupling import Coupling
from mbproj.constraints.curves.face import Face, FacePlace, FaceSlip
from mbproj.constraints.curves.in_space import BesideFirst, BesideSecond, SpaceArc
from mbproj.constraints.curves.profile import Arc, Lap, Profile
from mbproj.constraints.curves.two_curves import Gap, PlaceOnFirst, PlaceOnSecond, SlipOfTwo
from mbproj.constraints.ellipsoid import EllipsoidHeight, EllipsoidSlip
from mbproj.constraints.primitive import Primitive
from mbproj.constraints.rope import Rope
from mbproj.constraints.slip import BallSlip, EdgeSlip, WheelSlipAcross, WheelSlipAlong
from mbproj.constraints.wheel_height import WheelHeight

PRIMITIVES: Mapping[str, type[Primitive]] = MappingProxyType(
    {
        "coincident": Coincident,
        "perpendicular": Perpendicular,
        "along": Along,
        "distance": Distance,
        "angle": Angle,
        "coupling": Coupling,
        "wheel_height": WheelHeight,
        "wheel_slip_along": WheelSlipAlong,
        "wheel_slip_across": WheelSlipAcross,
        "ball_slip": BallSlip,
        "edge_slip": EdgeSlip,
        "ellipsoid_height": EllipsoidHeight,
        "ellipsoid_slip": EllipsoidSlip,
        "profile": Profile,
        "arc": Arc,
        "lap": Lap,
        "face": Face,
        "face_place": FacePlace,
        "face_slip": FaceSlip,
        "two_curves": Gap,
        "place_on_first": PlaceOnFirst,
        "place_on_second": PlaceOnSecond,
        "slip_of_two": SlipOfTwo,
        "beside_first": BesideFirst,
        "beside_second": BesideSecond,
        "space_arc": SpaceArc,
        "rope": Rope,
    }
)

__all__ = ["PRIMITIVES", "Primitive"]
