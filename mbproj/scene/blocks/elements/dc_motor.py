"""The force `dc_motor`: a motor whose torque is proportional to a current, as one with brushes, behind a gear.

type: dc_motor, joint: pin, voltage: U, resistance: 0.8 ohm, inductance: 2 mH, constant: 2, gear: 50, friction: 0.01
"""

from __future__ import annotations

from mbproj.elements import Element, Force, State, called
from mbproj.functions.program import CHANNELS, Code, Op, Program, apply, number, variable
from mbproj.scene.blocks.elements.element_type import ElementType
from mbproj.scene.fields.functions import Function
from mbproj.scene.fields.quantities import Number


def _dc_motor(
    name: str,
    s: str,
    voltage: Program,
    resistance: float,
    inductance: float,
    constant: float,
    gear: float = 1.0,
    friction: float = 0.0,
) -> Element:
    """The motor L i' = U - R i - k n s' with the torque n k i - d s'. The coil stores ½ L i², and R i² + d s'² is heat.
    So the power that the motor supplies is U i."""
    rate, current, heat = f"{s}_dot", f"{name}.current", f"{name}.heat"
    i, turning, k = called(current), called(rate), gear * constant
    return Element(
        name,
        reads=(rate, current, heat),
        states=(
            State("current", _changes(voltage, rate, current, resistance, inductance, k), unit="A"),
            State("heat", f"{resistance!r}*{i}*{i} + {friction!r}*{turning}*{turning}", unit="J", counts=True),
        ),
        forces=(Force(s, f"{k!r}*{i} - {friction!r}*{turning}"),),
        stores=f"{0.5 * inductance!r}*{i}*{i}",
        lost=called(heat),
    )


def _changes(voltage: Program, rate: str, current: str, R: float, L: float, k: float) -> Program:
    """The program of i', which reads the channels of the voltage, the rate s' and the current i."""
    reads = (*voltage.reads, rate, current)

    def scaled(at: int, factor: float) -> Code:
        return apply(Op.MULTIPLY, number(factor), variable(CHANNELS + len(voltage.reads) + at))

    left = apply(Op.SUBTRACT, apply(Op.SUBTRACT, voltage.code, scaled(0, k)), scaled(1, R))
    return Program(apply(Op.DIVIDE, left, number(L)), voltage.text, reads)


MOTORS = {
    "dc_motor": ElementType(
        "rad",
        {
            "voltage": Function("V", names_channels=True),
            "resistance": Number("ohm", minimum=0.0),
            "inductance": Number("H", above=0.0),
            "constant": Number("N*m/A"),
            "gear": Number("", above=0.0),
            "friction": Number("N*m*s/rad", minimum=0.0),
        },
        _dc_motor,
        ("voltage", "resistance", "inductance", "constant"),
        states={"current": "A", "heat": "J"},
    ),
}
