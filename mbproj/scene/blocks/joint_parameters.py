"""The fields that read the parameters of joints."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from mbproj.joints import Parameter
from mbproj.scene.fields.checks import nonzero, slot_count, tooth_count
from mbproj.scene.fields.choices import NameChoice, NameReference
from mbproj.scene.fields.fields import Converted, Field, List
from mbproj.scene.fields.quantities import Number
from mbproj.scene.fields.reading import Unfit

#: The bound of pressure angles, in deg.
STEEPEST = 60.0
#: The sides of a closed curve, and of an open one as seen in its direction.
SIDES = ("outside", "inside", "left", "right")


def _pressure_angle(angle: float) -> float:
    """The angle in rad, or Unfit where teeth cannot have it as their pressure angle."""
    if not 0.0 <= angle < math.radians(STEEPEST):
        raise Unfit("is no pressure angle", f"give one from 0 deg to below {STEEPEST:g} deg; 20 deg is usual")
    return angle


#: The rules on parameters of joints, by the word `may_be` in the joint table.
RULES: Mapping[str, Callable[[float], float]] = {
    "pressure": _pressure_angle,
    "nonzero": nonzero,
    "teeth": tooth_count,
    "slots": slot_count,
}


def parameter(given: Parameter) -> Field[Any]:
    """The field that reads a parameter of the joint table."""
    if given.may_be in ("curve", "space_curve", "convex"):
        return _several(given, NameReference("curve", "curves"))
    if given.may_be == "side":
        return _several(given, NameChoice("side", lambda: SIDES))
    number: Field[float] = Number(given.unit, above=0.0 if given.may_be == "positive" else None)
    if given.may_be in RULES:
        number = Converted(number, RULES[given.may_be])
    return _several(given, number)


def _several(given: Parameter, one: Field[Any]) -> Field[Any]:
    return one if given.many is None else List(one, given.many, given.words)
