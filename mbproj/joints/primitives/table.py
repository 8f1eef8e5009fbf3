"""The constraint primitives by name, each defined once (Haug 1989, ch. 9; Nikravesh 1988, ch. 7). This package imports
nothing of mbproj but the modules that everybody may import."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import final

from mbproj.base.registry import load
from mbproj.joints.primitives.basic import Primitive
from mbproj.joints.table import PRIMITIVE_TYPES


@final
class _Primitives(Mapping[str, type[Primitive]]):
    """The classes by name. The module of a primitive is imported when somebody first asks for the primitive."""

    def __getitem__(self, name: str) -> type[Primitive]:
        kind: type[Primitive] = load(PRIMITIVE_TYPES[name].home)
        return kind

    def __iter__(self) -> Iterator[str]:
        return iter(PRIMITIVE_TYPES)

    def __len__(self) -> int:
        return len(PRIMITIVE_TYPES)


PRIMITIVES: Mapping[str, type[Primitive]] = _Primitives()


_NAMES = {each.home: name for name, each in PRIMITIVE_TYPES.items()}


def name_of(kind: type[Primitive]) -> str:
    """The name of a primitive, or that of its class where it is none of PRIMITIVES."""
    return _NAMES.get(f"{kind.__module__}:{kind.__name__}", kind.__name__)


__all__ = ["PRIMITIVES", "Primitive", "name_of"]
