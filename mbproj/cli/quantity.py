"""Options whose text is a number with a unit, read by the rules of the scene: "1e-6", "1 mm", "2 min"."""

from __future__ import annotations

from typing import Any

import click

from mbproj.errors import InputError, Place


class Positive(click.ParamType):  # type: ignore[type-arg]  # generic in the newest click alone
    """A positive number in the SI unit `unit`."""

    def __init__(self, unit: str) -> None:
        self.unit = self.name = unit

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """The number in SI. Raises InputError at the option."""
        from mbproj.scene.nodes import from_value
        from mbproj.scene.quantities import Number
        from mbproj.scene.reading import Reading

        option = param.opts[0] if param is not None else ""
        reading = Reading()
        key = option.removeprefix("--")
        number = Number(self.unit, above=0.0).read(from_value(value, Place(option)), (key,), reading)
        if number is None:
            raise InputError(reading.problems)
        return number
