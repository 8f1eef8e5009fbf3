"""Springs and dampers whose numbers change in a run: a `spring_damper` or one of its kin becomes such an element where
one of its numbers names the time, a signal or a coordinate.

type: torsion_spring_damper, joint: pin, stiffness: 40*(1 + grip), damping: 0.5
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Literal

from mbproj.elements import Element, Force, State
from mbproj.functions.program import Program
from mbproj.functions.standard import reading
from mbproj.scene.blocks.elements.element_type import ElementType
from mbproj.scene.expressions.formula import formula
from mbproj.scene.fields.functions import Function
from mbproj.scene.fields.quantities import Number

Given = float | Program


def _spring(
    name: str, s: str, free: str, stiffness: Given = 0.0, damping: Given = 0.0, table: Given = 0.0, **at: Given
) -> Element:
    """The spring F = table(s) - k (s - free) - c s'. It stores k (s - free)²/2, so that a change of k or of the free
    length does work. The work of c is heat."""
    place, rate, rest = reading(s), reading(f"{s}_dot"), at.get(free, 0.0)
    push, stores, heat = formula("T", T=table), None, tuple[State, ...]()
    if stiffness != 0.0:
        push = formula("T - k*(s - s0)", T=push, k=stiffness, s=place, s0=rest)
        stores = formula("k*(s - s0)**2/2", k=stiffness, s=place, s0=rest)
    if damping != 0.0:
        push = formula("T - c*rate", T=push, c=damping, rate=rate)
        heat = (State("heat", formula("c*rate**2", c=damping, rate=rate), unit="J", counts=True),)
    lost = reading(f"{name}.heat") if heat else None
    return Element(name, reads=(s, f"{s}_dot"), states=heat, forces=(Force(s, push),), stores=stores, lost=lost)


def _type(along: Literal["m", "rad"], force: str, free: str) -> ElementType:
    keys: dict[str, Number | Function] = {
        "stiffness": Number(f"{force}/{along}"),
        "damping": Number(f"{force}*s/{along}"),
        free: Number(along),
        "table": Function(force, ("s",), units=()),
    }
    return ElementType(along, keys, partial(_spring, free=free), states={"heat": "J"})


#: The element types by the type of force that a scene gives.
SPRINGS: Mapping[str, ElementType] = {
    "spring_damper": _type("m", "N", "free_length"),
    "linear_spring_damper": _type("m", "N", "free_displacement"),
    "torsion_spring_damper": _type("rad", "N*m", "free_angle"),
}
