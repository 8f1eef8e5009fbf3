"""Numbers of a reference as a reader would write them, 0.5, sqrt(2)/2, -45 deg, and others with all their digits."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, degrees, pi, sqrt
from string import ascii_uppercase

#: What is this near, relative to 1, is the same number.
SAME = 2e-15
ROOTS = {"sqrt(2)": sqrt(2.0), "sqrt(2)/2": sqrt(0.5)}
#: What nameless joints are called in their order: A, B, .., Z, AA, AB, .., ZZ.
LETTERS = (*ascii_uppercase, *(a + b for a in ascii_uppercase for b in ascii_uppercase))


def number(value: float) -> str:
    """A number as an expression that the scene reader evaluates to it, to round-off."""
    if abs(value) < SAME:
        return "0"
    for text, root in ROOTS.items():
        if abs(abs(value) - root) < SAME:
            return text if value > 0 else f"-{text}"
    short = f"{value:.12g}"
    return short if abs(float(short) - value) <= SAME * abs(value) else repr(value)


def vector(values: Sequence[float]) -> str:
    """A list of numbers."""
    return f"[{', '.join(number(value) for value in values)}]"


def orientation(quaternion: Sequence[float]) -> str | None:
    """An axis and an angle where the axis is a coordinate axis, else the Euler parameters; None: the identity."""
    scalar, *turn = quaternion
    length = sqrt(sum(x * x for x in turn))
    if length < SAME:
        return None
    axis = [x / length for x in turn]
    if max(abs(x) for x in axis) < 1.0 - SAME:
        return f"{{quaternion: {vector(quaternion)}}}"
    sign = 1.0 if sum(axis) > 0 else -1.0
    angle = sign * 2.0 * atan2(length, scalar)
    return f"{{axis: {vector([abs(round(x)) for x in axis])}, angle: {_angle(angle)}}}"


def _angle(value: float) -> str:
    whole = round(degrees(value))
    return f"{whole} deg" if abs(value - whole * pi / 180.0) < SAME else number(value)
