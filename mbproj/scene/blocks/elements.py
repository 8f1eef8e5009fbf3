"""The force `hydraulic_cylinder`: two chambers of oil, a valve with four edges, a leak.

type: hydraulic_cylinder, joint: rail, opening: u, supply: 160 bar, flow: 40 l/min, drop: 35 bar,
area: 20 cm^2, rod_side: 12 cm^2, stroke: 0.5 m, dead_volume: 100 cm^3, bulk_modulus: 1.4e9 Pa
"""

from __future__ import annotations

from mbproj.elements import Element, Force, State
from mbproj.functions.program import Program
from mbproj.functions.standard import reading, within
from mbproj.scene.blocks.elements.element_type import ElementType
from mbproj.scene.expressions.formula import formula
from mbproj.scene.fields.functions import Function
from mbproj.scene.fields.quantities import Number

#: Where the flow turns laminar, as a share of the supply pressure. Below it the flow is proportional to the pressure
#: drop, and far above to its square root.
LAMINAR = 1e-3
#: The scale of the absolute tolerance of a pressure, in Pa.
PRESSURE_SCALE = 1e5


def _hydraulic_cylinder(
    name: str,
    s: str,
    opening: Program,
    supply: float,
    flow: float,
    drop: float,
    area: float,
    stroke: float,
    dead_volume: float,
    bulk_modulus: float,
    rod_side: float | None = None,
    retracted: float = 0.0,
    leak: float = 0.0,
    damping: float = 0.0,
    pressure_1: float = 0.0,
    pressure_2: float = 0.0,
) -> Element:
    """The cylinder with the push A₁ p₁ - A₂ p₂ - d s' and p₁' = E/V₁ (Q₁ - A₁ s'), p₂' = E/V₂ (Q₂ + A₂ s'). The oil in
    a chamber stores the work of compression; the losses of throttling, leak and damping are heat. So the power that the
    element supplies is that of the pump."""
    p1, p2, place, rate = (reading(each) for each in (f"{name}.pressure_1", f"{name}.pressure_2", s, f"{s}_dot"))
    A1, A2, E = area, area if rod_side is None else rod_side, bulk_modulus
    u = within(opening, -1.0, 1.0)
    inlet, outlet = formula("max(u, 0)", u=u), formula("max(-u, 0)", u=u)
    K, ε = flow / drop**0.5, LAMINAR * supply

    def through(open: Program, before: float | Program, after: float | Program) -> Program:
        """The flow through an edge, smooth where the pressures are equal."""
        text = "K*u*(before - after)/((before - after)**2 + small)**0.25"
        return formula(text, K=K, u=open, before=before, after=after, small=ε**2)

    edges = {  # flows in m³/s: s is the supply, t the tank, 1 and 2 the chambers; "s1" flows from s to 1
        "s1": through(inlet, supply, p1),
        "1t": through(outlet, p1, 0.0),
        "s2": through(outlet, supply, p2),
        "2t": through(inlet, p2, 0.0),
        "12": formula("c*(p1 - p2)", c=leak, p1=p1, p2=p2),
    }
    flows = {f"q{key}": edge for key, edge in edges.items()}
    V1 = formula("V0 + A*(s - s0)", V0=dead_volume, A=A1, s=place, s0=retracted)
    V2 = formula("V0 + A*(L + s0 - s)", V0=dead_volume, A=A2, L=stroke, s=place, s0=retracted)
    rate_1 = formula("E/V*(qs1 - q1t - q12 - A*rate)", E=E, V=V1, A=A1, rate=rate, **flows)
    rate_2 = formula("E/V*(qs2 - q2t + q12 + A*rate)", E=E, V=V2, A=A2, rate=rate, **flows)
    heads = {"hs": _head(supply, E), "h1": _head(p1, E), "h2": _head(p2, E)}
    lost = "qs1*(hs - h1) + q1t*h1 + qs2*(hs - h2) + q2t*h2 + q12*(h1 - h2) + d*rate*rate"
    return Element(
        name,
        reads=(s, f"{s}_dot"),
        states=(
            State("pressure_1", rate_1, pressure_1, PRESSURE_SCALE, "Pa"),
            State("pressure_2", rate_2, pressure_2, PRESSURE_SCALE, "Pa"),
            State("heat", formula(lost, d=damping, rate=rate, **flows, **heads), unit="J", counts=True),
        ),
        forces=(Force(s, formula("A1*p1 - A2*p2 - d*rate", A1=A1, p1=p1, A2=A2, p2=p2, d=damping, rate=rate)),),
        stores=formula("V1*u1 + V2*u2", V1=V1, V2=V2, u1=_energy(p1, E), u2=_energy(p2, E)),
        lost=reading(f"{name}.heat"),
    )


def _energy(p: float | Program, E: float) -> Program:
    """The energy that oil at the pressure p stores, in J/m³, with a density proportional to exp(p/E)."""
    return formula("E*(exp(p/E) - 1) - p", p=p, E=E)


def _head(p: float | Program, E: float) -> Program:
    """The energy that flowing oil carries, in J/m³: its pressure and its stored energy."""
    return formula("E*(exp(p/E) - 1)", p=p, E=E)


CYLINDERS = {
    "hydraulic_cylinder": ElementType(
        "m",
        {
            "opening": Function("", names_channels=True),
            "supply": Number("Pa", above=0.0),
            "flow": Number("m^3/s", above=0.0),
            "drop": Number("Pa", above=0.0),
            "area": Number("m^2", above=0.0),
            "rod_side": Number("m^2", above=0.0),
            "stroke": Number("m", above=0.0),
            "retracted": Number("m"),
            "dead_volume": Number("m^3", above=0.0),
            "bulk_modulus": Number("Pa", above=0.0),
            "leak": Number("m^3/(s*Pa)", minimum=0.0),
            "damping": Number("N*s/m", minimum=0.0),
            "pressure_1": Number("Pa"),
            "pressure_2": Number("Pa"),
        },
        _hydraulic_cylinder,
        ("opening", "supply", "flow", "drop", "area", "stroke", "dead_volume", "bulk_modulus"),
        states={"pressure_1": "Pa", "pressure_2": "Pa", "heat": "J"},
    ),
}
