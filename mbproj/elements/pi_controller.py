"""A controller with an integral and a filtered rate, which drives a joint coordinate."""

from __future__ import annotations

from mbproj.elements.element import Element, Force, State
from mbproj.functions.program import CHANNELS, Code, Op, Program, apply, number, variable


def pi_controller(
    name: str, coordinate: str, target: Program, gains: tuple[float, float, float], lag: float
) -> Element:
    """F = P e + I ∫e - D f with the error e = target(t) - s and the rate f' = (s' - f)/lag that a filter sees; `gains`
    P, I and D, `lag` in s."""
    s, rate, integral, filtered = (variable(CHANNELS + channel) for channel in range(4))
    error = apply(Op.SUBTRACT, target.code, s)
    proportional, whole, slowed = (number(gain) for gain in gains)
    push: Code = apply(Op.ADD, apply(Op.MULTIPLY, proportional, error), apply(Op.MULTIPLY, whole, integral))
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
