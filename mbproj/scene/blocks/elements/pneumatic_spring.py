"""The force `pneumatic_spring`: gas in a closed chamber, as in gas springs, air springs and accumulators.

type: pneumatic_spring, joint: rail, area: 50 cm^2, volume: 1000 cm^3, pressure: 6 bar, ambient: 1 bar, exponent: 1.3
"""

from __future__ import annotations

from mbproj.elements import Element, Force, State
from mbproj.functions.program import Program
from mbproj.functions.standard import reading
from mbproj.scene.blocks.elements.element_type import ElementType
from mbproj.scene.expressions.formula import formula
from mbproj.scene.fields.quantities import Number


def _pneumatic_spring(
    name: str,
    s: str,
    area: float,
    volume: float,
    pressure: float,
    ambient: float,
    exponent: float = 1.4,
    at: float = 0.0,
    damping: float = 0.0,
) -> Element:
    """The spring with the push A (p - ambient) - d s' and V = volume + A (s - at). p Vⁿ is constant; p = `pressure` at
    s = `at`. The gas stores the work that it could do; d s'² is heat."""
    place, rate = reading(s), reading(f"{s}_dot")
    V = formula("V + A*(s - at)", V=volume, A=area, s=place, at=at)
    p = formula("p*(V0/V)**n", p=pressure, V0=volume, V=V, n=exponent)
    push = formula("A*(p - around) - d*rate", A=area, p=p, around=ambient, d=damping, rate=rate)
    states = (State("heat", formula("d*rate*rate", d=damping, rate=rate), unit="J", counts=True),) if damping else ()
    return Element(
        name,
        reads=(s, f"{s}_dot"),
        states=states,
        forces=(Force(s, push),),
        stores=_stored(V, volume, pressure, ambient, exponent),
        lost=reading(f"{name}.heat") if damping else None,
    )


def _stored(V: Program, volume: float, pressure: float, ambient: float, n: float) -> Program:
    """The energy in J that the gas and the ambient air have taken up since the gas had the volume `volume`."""
    around = formula("p*(V - V0)", p=ambient, V=V, V0=volume)
    if n == 1.0:
        return formula("p*V0*log(V0/V) + around", p=pressure, V0=volume, V=V, around=around)
    text = "p*V0/(n - 1)*((V0/V)**(n - 1) - 1) + around"
    return formula(text, p=pressure, V0=volume, V=V, n=n, around=around)


GAS_SPRINGS = {
    "pneumatic_spring": ElementType(
        "m",
        {
            "area": Number("m^2", above=0.0),
            "volume": Number("m^3", above=0.0),
            "pressure": Number("Pa", above=0.0),
            "ambient": Number("Pa", minimum=0.0),
            "exponent": Number("", minimum=1.0),
            "at": Number("m"),
            "damping": Number("N*s/m", minimum=0.0),
        },
        _pneumatic_spring,
        ("area", "volume", "pressure", "ambient"),
        states={"heat": "J"},
    ),
}
