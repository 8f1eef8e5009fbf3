"""How joints couple coordinates: the weights of a sum that stays, from the parameters of the joint."""

from __future__ import annotations

import math
from typing import NamedTuple


class Ratio(NamedTuple):
    """The weights of what a row couples, and the period of the sum, None where turns of the angles alone make it."""

    weights: tuple[float, ...]
    period: float | None


def thread(pitch: float) -> Ratio:
    """s - pitch φ / 2π in m, with the displacement s along z1 and the angle φ about it.

    `pitch` is the advance a turn in m, positive for a right-handed screw.
    """
    return Ratio((1.0, -pitch / (2.0 * math.pi)), abs(pitch))


def mesh(teeth: tuple[float, float]) -> Ratio:
    """(n1 φ1 + n2 φ2) / max(|n1|, |n2|) in rad, with the angles of two joints, for wheels of n1 and n2 `teeth`.

    Opposite signs of n1 and n2 make an internal gear or a belt.
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
