"""The constraint primitives by name, each defined once (Haug 1989, ch. 9; Nikravesh 1988, ch. 7). This package imports
nothing of mbproj but the modules that everybody may import."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import final

from mbproj.base.registry import load
from mbproj.joints.primitives.basic import Primitive

#: The module that defines each primitive, and the primitive's class.
HOMES: Mapping[str, str] = {
    "coincident": "mbproj.joints.primitives.basic:Coincident",
    "perpendicular": "mbproj.joints.primitives.basic:Perpendicular",
    "along": "mbproj.joints.primitives.basic:Along",
    "distance": "mbproj.joints.primitives.basic:Distance",
    "angle": "mbproj.joints.primitives.basic:Angle",
    "coupling": "mbproj.joints.primitives.coupling:Coupling",
    "wheel_height": "mbproj.joints.primitives.rolling:WheelHeight",
    "wheel_slip_along": "mbproj.joints.primitives.rolling:WheelSlipAlong",
    "wheel_slip_across": "mbproj.joints.primitives.rolling:WheelSlipAcross",
    "ball_slip": "mbproj.joints.primitives.rolling:BallSlip",
    "edge_slip": "mbproj.joints.primitives.rolling:EdgeSlip",
    "ellipsoid_height": "mbproj.joints.primitives.rolling:EllipsoidHeight",
    "ellipsoid_slip": "mbproj.joints.primitives.rolling:EllipsoidSlip",
    "profile": "mbproj.joints.primitives.plane_curves:Profile",
    "arc": "mbproj.joints.primitives.plane_curves:Arc",
    "lap": "mbproj.joints.primitives.plane_curves:Lap",
    "face": "mbproj.joints.primitives.plane_curves:Face",
    "face_place": "mbproj.joints.primitives.plane_curves:FacePlace",
    "face_slip": "mbproj.joints.primitives.plane_curves:FaceSlip",
    "two_curves": "mbproj.joints.primitives.plane_curves:Gap",
    "place_on_first": "mbproj.joints.primitives.plane_curves:PlaceOnFirst",
    "place_on_second": "mbproj.joints.primitives.plane_curves:PlaceOnSecond",
    "slip_of_two": "mbproj.joints.primitives.plane_curves:SlipOfTwo",
    "beside_first": "mbproj.joints.primitives.space_curves:BesideFirst",
    "beside_second": "mbproj.joints.primitives.space_curves:BesideSecond",
    "space_arc": "mbproj.joints.primitives.space_curves:SpaceArc",
    "rope": "mbproj.joints.primitives.rope:Rope",
}


@final
class _Primitives(Mapping[str, type[Primitive]]):
    """The classes by name. The module of a primitive is imported when somebody first asks for the primitive."""

    def __getitem__(self, name: str) -> type[Primitive]:
        kind: type[Primitive] = load(HOMES[name])
        return kind

    def __iter__(self) -> Iterator[str]:
        return iter(HOMES)

    def __len__(self) -> int:
        return len(HOMES)


PRIMITIVES: Mapping[str, type[Primitive]] = _Primitives()


_NAMES = {home: name for name, home in HOMES.items()}


def name_of(kind: type[Primitive]) -> str:
    """The name of a primitive, or that of its class where it is none of PRIMITIVES."""
    return _NAMES.get(f"{kind.__module__}:{kind.__name__}", kind.__name__)


__all__ = ["PRIMITIVES", "Primitive", "name_of"]
