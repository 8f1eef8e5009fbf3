"""Elements that tests use: a controller, a rack, a cam."""

from __future__ import annotations

from mbproj.functions.elements import Element, Force, Row, State
from mbproj.functions.program import CHANNELS, Op, Program, apply, number, variable


def pi_controller(
    name: str, coordinate: str, target: Program, gains: tuple[float, float, float], lag: float
) -> Element:
    """F = P e + I ∫e - D f with the error e = target(t) - s and the rate f' = (s' - f)/lag that a filter sees; `gains`
    P, I and D, `lag` in s."""
    s, rate, integral, filtered = (variable(CHANNELS + channel) for channel in range(4))
    error = apply(Op.SUBTRACT, target.code, s)
    proportional, whole, slowed = (number(gain) for gain in gains)
    push = apply(Op.ADD, apply(Op.MULTIPLY, proportional, error), apply(Op.MULTIPLY, whole, integral))
    push = apply(Op.SUBTRACT, push, apply(Op.MULTIPLY, slowed, filtered))
    return Element(
        name,
        reads=(coordinate, f"{coordinate}_dot", f"{name}.integral", f"{name}.filtered"),
        states=(
            State("integral", Program(error)),
            State("filtered", Program(apply(Op.DIVIDE, apply(Op.SUBTRACT, rate, filtered), number(lag)))),
        ),
        forces=(Force(coordinate, Program(push)),),
    )


def rack(name: str, angle: str, displacement: str, radius: float) -> Element:
    """s - r φ = const of two joint coordinates; `radius` r in m, negative where they go opposite ways."""
    return Element(name, rows=(Row("mesh", {displacement: 1.0, angle: -radius}),))


def cam(name: str, angle: str, follower: str, lift: Program) -> Element:
    """s - f(φ) = const of two joint coordinates, with the `lift` f of COORDINATE in m or rad. It repeats with each turn
    and is twice differentiable, as tables that are `periodic`."""
    return Element(name, rows=(Row("law", {angle: 0.0, follower: 1.0}, lift),))


def spring(name: str, coordinate: str, stiffness: float) -> Element:
    """F = -k s, which keeps ½ k s²; `stiffness` k in N/m or N m/rad."""
    s = variable(CHANNELS)
    kept = apply(Op.MULTIPLY, number(0.5 * stiffness), apply(Op.MULTIPLY, s, s))
    push = Program(apply(Op.MULTIPLY, number(-stiffness), s))
    return Element(name, reads=(coordinate,), forces=(Force(coordinate, push),), stores=Program(kept))


def motor(name: str, angle: str, voltage: float, winding: tuple[float, float], constant: float) -> Element:
    """Torque k i with L i' = U - R i - k ω: it keeps ½ L i² and loses R i²; `winding` R in Ω and L in H."""
    resistance, inductance = winding
    rate, current, heat = (variable(CHANNELS + channel) for channel in range(3))
    square = apply(Op.MULTIPLY, current, current)
    drop = apply(Op.ADD, apply(Op.MULTIPLY, number(resistance), current), apply(Op.MULTIPLY, number(constant), rate))
    grows = apply(Op.DIVIDE, apply(Op.SUBTRACT, number(voltage), drop), number(inductance))
    return Element(
        name,
        reads=(f"{angle}_dot", f"{name}.current", f"{name}.heat"),
        states=(
            State("current", Program(grows), unit="A"),
            State("heat", Program(apply(Op.MULTIPLY, number(resistance), square)), unit="J"),
        ),
        forces=(Force(angle, Program(apply(Op.MULTIPLY, number(constant), current))),),
        stores=Program(apply(Op.MULTIPLY, number(0.5 * inductance), square)),
        lost=Program(heat),
    )
