"""The force `speed_torque`: a motor or an engine, given by its curve of torque over speed, behind a gear.

type: speed_torque, joint: pin, torque: table(speed, 0, 12, 100, 10, 300, 0), command: throttle, gear: 5
"""

from __future__ import annotations

from mbproj.elements import Element, Force, State
from mbproj.functions.program import RATE, TIME, Program, replaced
from mbproj.functions.standard import combine, reading
from mbproj.scene.blocks.elements.element_type import ElementType
from mbproj.scene.expressions.formula import formula
from mbproj.scene.fields.functions import Function
from mbproj.scene.fields.quantities import Number


def _speed_torque(
    name: str,
    s: str,
    torque: Program,
    command: Program | None = None,
    gear: float = 1.0,
    friction: float = 0.0,
    motor_constant: float | None = None,
) -> Element:
    """The motor with the torque n u T(n s') - d s' at the joint. d s'² is heat, and with a motor constant K also
    (u T/K)²."""
    rate = reading(f"{s}_dot")
    shaft = formula("n*rate", n=gear, rate=rate)
    curve = _at_speed(torque, shaft)
    own = curve if command is None else formula("u*T", u=command, T=curve)
    push = formula("n*T - d*rate", n=gear, T=own, d=friction, rate=rate)
    warms = formula("d*rate*rate", d=friction, rate=rate)
    if motor_constant is not None:
        warms = formula("warm + (T/K)**2", warm=warms, T=own, K=motor_constant)
    return Element(
        name,
        reads=(f"{s}_dot",),
        states=(State("heat", warms, unit="J", counts=True),),
        forces=(Force(s, push),),
        lost=reading(f"{name}.heat"),
    )


def _at_speed(curve: Program, shaft: Program) -> Program:
    """The program of the curve's torque at the speed that the program `shaft` gives."""
    return combine(lambda own, turning: replaced(own, {RATE: turning}), curve, shaft)


ENGINES = {
    "speed_torque": ElementType(
        "rad",
        {
            "torque": Function("N*m", ("t", "speed"), (TIME, RATE), ("s", "rad/s"), names_channels=True),
            "command": Function("", names_channels=True),
            "gear": Number("", above=0.0),
            "friction": Number("N*m*s/rad", minimum=0.0),
            "motor_constant": Number("N*m/W^0.5", above=0.0),
        },
        _speed_torque,
        ("torque",),
        states={"heat": "J"},
    ),
}
