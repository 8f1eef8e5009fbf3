"""The record of a type of force that is an element."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Literal

from mbproj.dataclass import dataclass
from mbproj.elements import Element
from mbproj.scene.fields.containers import OneOf
from mbproj.scene.fields.functions import Function
from mbproj.scene.fields.quantities import Number


@dataclass(frozen=True)
class ElementType:
    """A type of force that is an element, acting `along` a coordinate in m, which may be the distance of two points, or
    in rad. `keys` are its own keys with their units; those in `required` must be given, those in a group of `choices`
    exclude each other. `make(name, s, **values)` returns the element of this name that acts along the coordinate named
    s, with the values of the keys in SI units. `states` are the units of the states that it may have."""

    along: Literal["m", "rad"]
    keys: Mapping[str, Number | Function]
    make: Callable[..., Element]
    required: tuple[str, ...] = ()
    choices: tuple[OneOf, ...] = ()
    states: Mapping[str, str] = field(default_factory=dict)

    @property
    def units(self) -> Mapping[str, str]:
        """The SI unit of each key."""
        return {name: field.unit or "" for name, field in self.keys.items()}
