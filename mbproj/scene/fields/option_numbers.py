"""Numbers that are given on the command line or from Python: read by the same rules as those of a scene."""

from __future__ import annotations

from typing import TypeVar

from mbproj.errors import InputError, Place
from mbproj.scene.fields.fields import Field
from mbproj.scene.fields.reading import Reading
from mbproj.scene.text.nodes import from_value

Read = TypeVar("Read")


def given_number(text: object, option: str, field: Field[Read]) -> Read:
    """Read `text`, or a number (of NumPy, too), by the field of a scene; the result is in SI units.

    Raises InputError at the option.
    """
    reading = Reading()
    number = field.read(from_value(text, Place(option)), (option,), reading)
    if number is None:
        raise InputError(reading.problems)
    return number
