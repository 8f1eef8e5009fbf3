"""The constraint primitives by name, each defined once (Haug 1989, ch. 9; Nikravesh 1988, ch. 7). This package imports
nothing of mbproj but the modules that everybody may import."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import final

from mbproj.constraints.primitive import Primitive
from mbproj.registry import load

#: The module of this package that defines each primitive, and the primitive's class.
HOMES: Mapping[str, str] = {
    "coincident": "basic:Coincident",
    "perpendicular": "basic:Perpendicular",
    "along": "basic:Along",
    "distance": "basic:Distance",
    "angle": "basic:Angle",
    "coupling": "coupling:Coupling",
    "wheel_height": "wheel_height:WheelHeight",
    "wheel_slip_along": "slip:WheelSlipAlong",
    "wheel_slip_across": "slip:WheelSlipAcross",
    "ball_slip": "slip:BallSlip",
    "edge_slip": "slip:EdgeSlip",
    "ellipsoid_height": "ellipsoid:EllipsoidHeight",
    "ellipsoid_slip": "ellipsoid:EllipsoidSlip",
    "profile": "curves.profile:Profile",
    "arc": "curves.profile:Arc",
    "lap": "curves.profile:Lap",
    "face": "curves.face:Face",
    "face_place": "curves.face:FacePlace",
    "face_slip": "curves.face:FaceSlip",
    "two_curves": "curves.two_curves:Gap",
    "place_on_first": "curves.two_curves:PlaceOnFirst",
    "place_on_second": "curves.two_curves:PlaceOnSecond",
    "slip_of_two": "curves.two_curves:SlipOfTwo",
    "beside_first": "curves.in_space:BesideFirst",
    "beside_second": "curves.in_space:BesideSecond",
    "space_arc": "curves.in_space:SpaceArc",
    "rope": "rope:Rope",
}


@final
class _Primitives(Mapping[str, type[Primitive]]):
    """The classes by name. The module of a primitive is imported when somebody first asks for the primitive."""

    def __getitem__(self, name: str) -> type[Primitive]:
        kind: type[Primitive] = load(f"mbproj.constraints.{HOMES[name]}")
        return kind

    def __iter__(self) -> Iterator[str]:
        return iter(HOMES)

    def __len__(self) -> int:
        return len(HOMES)


PRIMITIVES: Mapping[str, type[Primitive]] = _Primitives()


_NAMES = {home: name for name, home in HOMES.items()}


def name_of(kind: type[Primitive]) -> str:
    """The name of a primitive, or that of its class where it is none of PRIMITIVES."""
    return _NAMES.get(f"{kind.__module__.removeprefix('mbproj.constraints.')}:{kind.__name__}", kind.__name__)


__all__ = ["PRIMITIVES", "Primitive", "name_of"]
