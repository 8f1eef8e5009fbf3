"""The constraint primitives (Haug 1989, ch. 9; Nikravesh 1988, ch. 7), each once, by name. Imports nothing of ours."""

from collections.abc import Mapping
from types import MappingProxyType

from mbproj.constraints.along import Along
from mbproj.constraints.angle import Angle
from mbproj.constraints.coincident import Coincident
from mbproj.constraints.coupling import Coupling
from mbproj.constraints.distance import Distance
from mbproj.constraints.perpendicular import Perpendicular
from mbproj.constraints.primitive import Primitive

PRIMITIVES: Mapping[str, type[Primitive]] = MappingProxyType(
    {
        "coincident": Coincident,
        "perpendicular": Perpendicular,
        "along": Along,
        "distance": Distance,
        "angle": Angle,
        "coupling": Coupling,
    }
)

__all__ = ["PRIMITIVES", "Primitive"]
