"""The forces `servo` and `linear_servo`: drives that hold a position or a speed, within limits.

type: servo, joint: pin, position: 30 deg * sin(t), stiffness: 400, damping: 20, max_torque: 60, max_speed: 3
type: linear_servo, joint: rail, speed: wanted, damping: 500, max_force: 200, motor_constant: 12
"""

from __future__ import annotations

from typing import Literal

from mbproj.elements import Element, Force, State
from mbproj.functions.program import Program
from mbproj.functions.standard import reading, within
from mbproj.scene.blocks.elements.element_type import ElementType
from mbproj.scene.expressions.formula import formula
from mbproj.scene.fields.containers import OneOf
from mbproj.scene.fields.functions import Function
from mbproj.scene.fields.quantities import Number


def _servo(
    name: str,
    s: str,
    damping: float,
    position: Program | None = None,
    speed: Program | None = None,
    stiffness: float = 0.0,
    max_speed: float | None = None,
    motor_constant: float | None = None,
    **limit: float,
) -> Element:
    """The drive with the push d (v - s'), within its limit. v is the wanted speed, or (k/d) (position - s) within
    `max_speed`. With a motor constant K, (push/K)² is heat, which the drive supplies beside its mechanical power."""
    rate, wanted = reading(f"{s}_dot"), speed
    if position is not None:
        wanted = formula("ratio*(position - s)", ratio=stiffness / damping, position=position, s=reading(s))
    assert wanted is not None
    if max_speed is not None:
        wanted = within(wanted, -max_speed, max_speed)
    push = formula("d*(v - rate)", d=damping, v=wanted, rate=rate)
    for most in limit.values():
        push = within(push, -most, most)
    heat = heat_of(name, push, motor_constant)
    lost = reading(f"{name}.heat") if heat else None
    return Element(name, reads=(s, f"{s}_dot"), states=heat, forces=(Force(s, push),), lost=lost)


def heat_of(name: str, push: Program, motor_constant: float | None) -> tuple[State, ...]:
    """The state "heat" of the windings, whose rate is (push/K)²; () without a motor constant."""
    if motor_constant is None:
        return ()
    return (State("heat", formula("(push/K)**2", push=push, K=motor_constant), unit="J", counts=True),)


def _type(along: Literal["m", "rad"], force: str, limit: str) -> ElementType:
    return ElementType(
        along,
        {
            "position": Function(along, names_channels=True),
            "speed": Function(f"{along}/s", names_channels=True),
            "stiffness": Number(f"{force}/{along}", above=0.0),
            "damping": Number(f"{force}*s/{along}", above=0.0),
            "max_speed": Number(f"{along}/s", above=0.0),
            limit: Number(force, above=0.0),
            "motor_constant": Number(f"{force}/W^0.5", above=0.0),
        },
        _servo,
        ("damping",),
        (
            OneOf(("position", "speed"), needed=True, hint="a servo holds one of them"),
            OneOf(("stiffness", "speed"), needed=True, hint="a position is held with a stiffness, a speed without"),
        ),
        states={"heat": "J"},
    )


SERVOS = {"servo": _type("rad", "N*m", "max_torque"), "linear_servo": _type("m", "N", "max_force")}
