"""How joints couple coordinates: the weights of a sum that stays, from the parameters of the joint."""

from __future__ import annotations

import math
from typing import NamedTuple

from mbproj.functions.program import COORDINATE, Code, Op, Program, apply, number, variable


class Ratio(NamedTuple):
    """The weights of what a row couples, and the period of the sum, None where turns of the angles alone make it; and
    what the sum is less, a function of the first coordinate."""

    weights: tuple[float, ...]
    period: float | None
    function: Program | None = None


def thread(pitch: float) -> Ratio:
    """s - pitch φ / 2π in m, with the displacement s along z1 and the angle φ about it.

    `pitch` is the advance a turn in m, positive for a right-handed screw.
    """
    return Ratio((1.0, -pitch / (2.0 * math.pi)), abs(pitch))


def mesh(teeth: tuple[float, float], pressure_angle: float | None = None) -> Ratio:
    """(n1 φ1 + n2 φ2) / max(|n1|, |n2|) in rad, with the angles of two joints, for wheels of n1 and n2 `teeth`.

    Opposite signs of n1 and n2 make an internal gear or a belt. The `pressure_angle` counts in its bearings alone.
    """
    larger = max(abs(number) for number in teeth)
    return Ratio((teeth[0] / larger, teeth[1] / larger), 2.0 * math.pi / larger)


def pinion(radius: float) -> Ratio:
    """s - r φ in m, with the angle φ of a pinion of `radius` and the displacement s of its rack."""
    return Ratio((-radius, 1.0), None)


def wrap(radii: tuple[float, float]) -> Ratio:
    """(r1 φ1 - r2 φ2) / max(|r1|, |r2|) in rad, of two pulleys under a belt; a negative radius crosses it."""
    larger = max(abs(radius) for radius in radii)
    return Ratio((radii[0] / larger, -radii[1] / larger), None)


def tread(radius: float) -> Ratio:
    """s - r φ in m, with the angle φ of a wheel of `radius` and the way s on which it rolls."""
    return Ratio((1.0, -radius), 2.0 * math.pi * radius)


def halve() -> Ratio:
    """φ0 - (φ1 + φ2) / 2 in rad, of the carrier and the two shafts of a differential."""
    return Ratio((1.0, -0.5, -0.5), None)


def geneva(slots: float) -> Ratio:
    """φ2 + f(φ1) in rad, of a driver whose pin is on the line of centres at φ1 = 0, and of its wheel.

    In a slot f = atan2(k sin φ1, 1 - k cos φ1), with k = sin(π/n) as the pin enters its slot along it: that is where
    cos φ1 = k, and f' = 0. From there on f stays ±π/n, for a step of 2π/n a turn.
    """
    k, φ = math.sin(math.pi / slots), variable(COORDINATE)
    sine, cosine = apply(Op.SIN, φ), apply(Op.COS, φ)
    turned = apply(Op.ATAN2, _times(k, sine), apply(Op.SUBTRACT, number(1.0), _times(k, cosine)))
    # φ less its distance from ±π: that does not jump at a half turn
    back = apply(Op.ATAN2, apply(Op.NEGATE, sine), apply(Op.NEGATE, cosine))
    stays = _times(1.0 / slots, apply(Op.SUBTRACT, φ, back))
    locked = apply(Op.ADD, number(0.5), _times(0.5, apply(Op.SIGN, apply(Op.SUBTRACT, number(k), cosine))))
    found = apply(Op.ADD, turned, apply(Op.MULTIPLY, locked, apply(Op.SUBTRACT, stays, turned)))
    return Ratio((0.0, 1.0), None, Program(apply(Op.NEGATE, found)))


def _times(factor: float, code: Code) -> Code:
    return apply(Op.MULTIPLY, number(factor), code)
