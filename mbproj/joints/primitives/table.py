"""The constraint primitives by name, each defined once (Haug 1989, ch. 9; Nikravesh 1988, ch. 7). This package imports
nothing of mbproj but the modules that everybody may import."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import final

from mbproj.constraints.primitive import Primitive
from mbproj.registry import load

#: The module that defines each primitive, and the primitive's class.
HOMES: Mapping[str, str] = {
    "coincident": "mbproj.constraints.basic:Coincident",
    "perpendicular": "mbproj.constraints.basic:Perpendicular",
    "along": "mbproj.constraints.basic:Along",
    "distance": "mbproj.constraints.basic:Distance",
    "angle": "mbproj.constraints.basic:Angle",
    "coupling": "mbproj.constraints.coupling:Coupling",
    "wheel_height": "mbproj.constraints.wheel_height:WheelHeight",
    "wheel_slip_along": "mbproj.constraints.slip:WheelSlipAlong",
    "wheel_slip_across": "mbproj.constraints.slip:WheelSlipAcross",
    "ball_slip": "mbproj.constraints.slip:BallSlip",
    "edge_slip": "mbproj.constraints.slip:EdgeSlip",
    "ellipsoid_height": "mbproj.constraints.ellipsoid:EllipsoidHeight",
    "ellipsoid_slip": "mbproj.constraints.ellipsoid:EllipsoidSlip",
    "profile": "mbproj.constraints.curves.profile:Profile",
    "arc": "mbproj.constraints.curves.profile:Arc",
    "lap": "mbproj.constraints.curves.profile:Lap",
    "face": "mbproj.constraints.curves.face:Face",
    "face_place": "mbproj.constraints.curves.face:FacePlace",
    "face_slip": "mbproj.constraints.curves.face:FaceSlip",
    "two_curves": "mbproj.constraints.curves.two_curves:Gap",
    "place_on_first": "mbproj.constraints.curves.two_curves:PlaceOnFirst",
    "place_on_second": "mbproj.constraints.curves.two_curves:PlaceOnSecond",
    "slip_of_two": "mbproj.constraints.curves.two_curves:SlipOfTwo",
    "beside_first": "mbproj.constraints.curves.in_space:BesideFirst",
    "beside_second": "mbproj.constraints.curves.in_space:BesideSecond",
    "space_arc": "mbproj.constraints.curves.in_space:SpaceArc",
    "rope": "mbproj.constraints.rope:Rope",
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
