"""The types of force that are elements: their keys in a scene, and the elements that these make.

Plug-ins add theirs. The reader, the schema, the reference, the studies and the animation read these tables; nothing
else knows a type.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import field
from functools import partial
from typing import Literal

from mbproj.base.dataclass import dataclass
from mbproj.base.plugins import Registry
from mbproj.functions.elements import Element, Force, State, called
from mbproj.functions.program import CHANNELS, RATE, TIME, Code, Op, Program, apply, number, replaced, variable
from mbproj.functions.standard import combine, reading, within
from mbproj.scene.expressions.compiled import formula
from mbproj.scene.fields.fields import OneOf
from mbproj.scene.fields.functions import Function
from mbproj.scene.fields.quantities import Number

# --- The record of a type of force that is an element -----------------------------------------------------------------


@dataclass(frozen=True)
class ElementType:
    """A type of force that is an element, acting `along` a coordinate in m, which may be the distance of two points, or
    in rad. `keys` are its own keys with their units; those in `required` must be given, those in a group of `choices`
    exclude each other. `make(name, s, **values)` returns the element of this name that acts along the coordinate named
    s, with the values of the keys in SI units. `states` are the units of the states that it may have."""

    along: Literal["m", "rad"]
    keys: Mapping[str, Number | Function]
    make: Callable[..., Element]
    required: tuple[str, ...] = ()
    choices: tuple[OneOf, ...] = ()
    states: Mapping[str, str] = field(default_factory=dict)

    @property
    def units(self) -> Mapping[str, str]:
        """The SI unit of each key."""
        return {name: field.unit or "" for name, field in self.keys.items()}


# --- The force `dc_motor` ---------------------------------------------------------------------------------------------
# A motor whose torque is proportional to a current, as one with brushes, behind a gear.
# Type: dc_motor, joint: pin, voltage: U, resistance: 0.8 ohm, inductance: 2 mH, constant: 2, gear: 50, friction: 0.01


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


# --- The force `hydraulic_cylinder` -----------------------------------------------------------------------------------
# Two chambers of oil, a valve with four edges, a leak.
# Type: hydraulic_cylinder, joint: rail, opening: u, supply: 160 bar, flow: 40 l/min, drop: 35 bar, area: 20 cm^2,
# rod_side: 12 cm^2, stroke: 0.5 m, dead_volume: 100 cm^3, bulk_modulus: 1.4e9 Pa


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


# --- The forces `maxwell` and `torsion_maxwell` -----------------------------------------------------------------------
# A spring and a damper in series, a model of rubber, oil and seals.
# Type: maxwell, points: {ground: [0, 0, 1], arm: [0.2, 0, 0]}, stiffness: 2e4 N/m, damping: 300 N*s/m type:
# torsion_maxwell, joint: B, stiffness: 40, damping: 2


def _maxwell(name: str, s: str, stiffness: float, damping: float, unit: str) -> Element:
    """The element F = -k e with the stretch e of the spring, 0 at the start. c (s' - e') = k e gives e'."""
    rate, stretch = f"{s}_dot", f"{name}.stretch"
    e = called(stretch)
    return Element(
        name,
        reads=(rate, stretch),
        states=(State("stretch", f"{called(rate)} - {stiffness / damping!r}*{e}", unit=unit),),
        forces=(Force(s, f"-{stiffness!r}*{e}", loses=True),),
        stores=f"{0.5 * stiffness!r}*{e}*{e}",
    )


MAXWELL_ELEMENTS = {
    "maxwell": ElementType(
        "m",
        {"stiffness": Number("N/m", above=0.0), "damping": Number("N*s/m", above=0.0)},
        partial(_maxwell, unit="m"),
        ("stiffness", "damping"),
        states={"stretch": "m"},
    ),
    "torsion_maxwell": ElementType(
        "rad",
        {"stiffness": Number("N*m/rad", above=0.0), "damping": Number("N*m*s/rad", above=0.0)},
        partial(_maxwell, unit="rad"),
        ("stiffness", "damping"),
        states={"stretch": "rad"},
    ),
}


# --- The force `pneumatic_spring` -------------------------------------------------------------------------------------
# Gas in a closed chamber, as in gas springs, air springs and accumulators.
# Type: pneumatic_spring, joint: rail, area: 50 cm^2, volume: 1000 cm^3, pressure: 6 bar, ambient: 1 bar, exponent:
# 1.3


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


# --- The forces `servo` and `linear_servo` ----------------------------------------------------------------------------
# Drives that hold a position or a speed, within limits.
# Type: servo, joint: pin, position: 30 deg * sin(t), stiffness: 400, damping: 20, max_torque: 60, max_speed: 3 type:
# linear_servo, joint: rail, speed: wanted, damping: 500, max_force: 200, motor_constant: 12


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


def _servo_type(along: Literal["m", "rad"], force: str, limit: str) -> ElementType:
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


SERVOS = {"servo": _servo_type("rad", "N*m", "max_torque"), "linear_servo": _servo_type("m", "N", "max_force")}


# --- The force `speed_torque` -----------------------------------------------------------------------------------------
# A motor or an engine, given by its curve of torque over speed, behind a gear.
# Type: speed_torque, joint: pin, torque: table(speed, 0, 12, 100, 10, 300, 0), command: throttle, gear: 5


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
    driven = curve if command is None else formula("u*T", u=command, T=curve)
    push = formula("n*T - d*rate", n=gear, T=driven, d=friction, rate=rate)
    warms = formula("d*rate*rate", d=friction, rate=rate)
    if motor_constant is not None:
        warms = formula("warm + (T/K)**2", warm=warms, T=driven, K=motor_constant)
    return Element(
        name,
        reads=(f"{s}_dot",),
        states=(State("heat", warms, unit="J", counts=True),),
        forces=(Force(s, push),),
        lost=reading(f"{name}.heat"),
    )


def _at_speed(curve: Program, shaft: Program) -> Program:
    """The program of the curve's torque at the speed that the program `shaft` gives."""
    return combine(lambda torque, turning: replaced(torque, {RATE: turning}), curve, shaft)


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


# --- Springs and dampers whose numbers change in a run ----------------------------------------------------------------
# A `spring_damper` or one of its kin becomes such an element where one of its numbers names the time, a signal or a
# coordinate.
# Type: torsion_spring_damper, joint: pin, stiffness: 40*(1 + grip), damping: 0.5


Varying = float | Program


def _spring(
    name: str, s: str, free: str, stiffness: Varying = 0.0, damping: Varying = 0.0, table: Varying = 0.0, **at: Varying
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


def _spring_type(along: Literal["m", "rad"], force: str, free: str) -> ElementType:
    keys: dict[str, Number | Function] = {
        "stiffness": Number(f"{force}/{along}"),
        "damping": Number(f"{force}*s/{along}"),
        free: Number(along),
        "table": Function(force, ("s",), units=()),
    }
    return ElementType(along, keys, partial(_spring, free=free), states={"heat": "J"})


#: The element types by the type of force that a scene gives.
SPRINGS: Mapping[str, ElementType] = {
    "spring_damper": _spring_type("m", "N", "free_length"),
    "linear_spring_damper": _spring_type("m", "N", "free_displacement"),
    "torsion_spring_damper": _spring_type("rad", "N*m", "free_angle"),
}


# --- The types of force that are elements -----------------------------------------------------------------------------


ELEMENTS: Registry[ElementType] = Registry(
    "force type",
    {
        **MOTORS,
        **CYLINDERS,
        **MAXWELL_ELEMENTS,
        **GAS_SPRINGS,
        **SERVOS,
        **ENGINES,
    },
)


def element_type(name: str) -> ElementType:
    """The element type of the force type `name`; for a spring, the one of springs whose numbers change in a run."""
    return SPRINGS[name] if name in SPRINGS else ELEMENTS[name]
