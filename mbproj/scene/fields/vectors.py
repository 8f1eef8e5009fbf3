"""Fields of three numbers: points, directions, the rows of a matrix."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, final

from mbproj.dataclass import dataclass
from mbproj.scene.fields.checks import direction
from mbproj.scene.fields.fields import Converted, Field, List, Schema
from mbproj.scene.fields.quantities import Number
from mbproj.scene.fields.reading import Reading
from mbproj.scene.records import KeyPath, Vector
from mbproj.scene.text.nodes import Node, ScalarNode

#: Directions by name, as x or -z.
NAMED: Mapping[str, Vector] = MappingProxyType(
    {
        "x": (1.0, 0.0, 0.0),
        "y": (0.0, 1.0, 0.0),
        "z": (0.0, 0.0, 1.0),
        "-x": (-1.0, 0.0, 0.0),
        "-y": (0.0, -1.0, 0.0),
        "-z": (0.0, 0.0, -1.0),
    }
)


def vector(unit: str | None) -> List[float]:
    """The field of three numbers in `unit` (see `Number`)."""
    return List(Number(unit), 3)


POINT: Field[Any] = vector("m")


_BY_NUMBERS = Converted(vector(None), direction)


@final
@dataclass(frozen=True)
class Direction(Field[Vector]):
    """A unit vector, given by three numbers of any length or by the name of an axis. Messages ask for numbers."""

    @property
    def expects(self) -> str:
        return _BY_NUMBERS.expects

    def takes(self, node: Node) -> bool:
        return _is_name(node) or _BY_NUMBERS.takes(node)

    def fits(self, node: Node) -> bool:
        return _is_name(node) or _BY_NUMBERS.fits(node)

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Vector | None:
        if not isinstance(node, ScalarNode) or not node.text:
            return _BY_NUMBERS.read(node, path, reading)
        if node.text not in NAMED:
            hint = f"give {self.expects}, or {', '.join(NAMED)}"
            reading.report(f"unknown direction '{node.text}'", node.place, hint)
        return NAMED.get(node.text)

    def schema(self) -> Schema:
        return {"description": self.expects, "anyOf": [_BY_NUMBERS.schema(), {"enum": list(NAMED)}]}


def _is_name(node: Node) -> bool:
    return isinstance(node, ScalarNode) and bool(node.text)


DIRECTION: Field[Any] = Direction()


def rows(unit: str) -> List[tuple[float, ...]]:
    """The field of the rows of a 3 x 3 matrix."""
    return List(vector(unit), 3, "rows of 3 numbers")
