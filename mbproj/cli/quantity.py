"""Types of options that are a number with a unit, read by the rules of the scene: "1e-6", "1 mm", "2 min"."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import click


class AnyNumber(click.ParamType):  # type: ignore[type-arg]  # generic in the newest click alone
    """A number in the SI unit `unit`."""

    bounds: ClassVar[Mapping[str, float]] = {}

    def __init__(self, unit: str) -> None:
        self.unit = self.name = unit

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number in SI. Raises InputError at the option."""
        from mbproj.scene.fields.option_numbers import given_number
        from mbproj.scene.fields.quantities import Number

        return given_number(value, param.opts[0] if param is not None else "", Number(self.unit, **self.bounds))


class Positive(AnyNumber):
    """A positive number in the SI unit `unit`."""

    bounds: ClassVar[Mapping[str, float]] = {"above": 0.0}


class NotNegative(AnyNumber):
    """A number in the SI unit `unit` that is not below 0."""

    bounds: ClassVar[Mapping[str, float]] = {"minimum": 0.0}


class PositiveList(Positive):
    """Several positive numbers in the SI unit `unit`: "0.01,5 ms"."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the numbers in SI, a tuple. Raises InputError at the option."""
        return tuple(super(PositiveList, self).convert(part, param, ctx) for part in value.split(","))


class Times(NotNegative):
    """Several times in s, not below 0: "0,0.5,200 ms"."""

    def __init__(self) -> None:
        super().__init__("s")
        self.name = "times"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the times in s, a tuple. Raises InputError at the option."""
        return tuple(super(Times, self).convert(part, param, ctx) for part in value.split(","))


class Millimetres(click.ParamType):  # type: ignore[type-arg]
    """A width in mm, or a width and a height: "85", "85,60", "85 mm, 60 mm"."""

    name = "millimetres"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[float, ...]:
        """Return the numbers in mm, a tuple of one or two."""
        if isinstance(value, tuple):
            return value
        from mbproj.plain_number import plain_number

        try:
            lengths = tuple(plain_number(part.strip().removesuffix("mm")) for part in value.split(","))
        except ValueError:
            lengths = ()
        if len(lengths) not in (1, 2):
            self.fail(f"'{value}' is no width in mm, nor a width and a height, as 85 or 85,60", param, ctx)
        return lengths


class QuantityNames(click.ParamType):  # type: ignore[type-arg]
    """Several names: "gopm,gpopm"."""

    name = "names"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[str, ...]:
        """Return the names, a tuple."""
        return tuple(part.strip() for part in value.split(","))


class Corners(QuantityNames):
    """Three markers, of which the second is the corner of an angle."""

    name = "corners"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the three names. Raises InputError where there are not three."""
        from mbproj.errors import InputError, Place, Problem

        names = super().convert(value, param, ctx)
        if len(set(names)) != 3 or len(names) != 3:
            place = Place(param.opts[0] if param is not None else "")
            raise InputError(Problem(f"'{value}' is not three markers", place, "give FIRST,CORNER,SECOND"))
        return names
