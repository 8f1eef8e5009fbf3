"""Lift laws of cams: a follower rises from 0 to 1 while x goes from 0 to 1 (Norton 2009, Cam Design, ch. 3)."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, pi, sin
from types import MappingProxyType
from typing import NamedTuple

from mbproj.functions.curves.piece import TERMS, polynomial


class LawPiece(NamedTuple):
    """A piece of a law, from x = `start` on: Σ c_k x^k + a sin(w x + p). `wave` is (a, w, p)."""

    start: float
    coefficients: tuple[float, ...]
    wave: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def numbers(self, first: float, rise: float, duration: float) -> tuple[float, ...]:
        """The numbers of first + rise · law(u / duration) for a `Piece`."""
        c0, *others = [rise * c / duration**k for k, c in enumerate((*self.coefficients, *(0.0,) * TERMS)[:TERMS])]
        a, w, p = self.wave
        return polynomial([c0 + first, *others], (rise * a, w / duration, p))


class Rise(NamedTuple):
    """A part of a lift law: over `angle` in rad the follower moves to the lift `to` in m, by a law of LAWS."""

    angle: float
    to: float
    law: str


class _Acceleration(NamedTuple):
    """y'' = constant + a sin(w x + p) from x = `start` on."""

    start: float
    constant: float
    a: float = 0.0
    w: float = 1.0
    p: float = 0.0


def _by_acceleration(*given: _Acceleration) -> tuple[LawPiece, ...]:
    """The law whose acceleration is proportional to the given one. It is 0 with zero slope at x = 0, and 1 at x = 1."""
    parts, y, slope = [], 0.0, 0.0
    for each, end in zip(given, [*(after.start for after in given[1:]), 1.0], strict=True):
        start, k, (a, w, p) = each.start, each.constant, each[2:]
        wave = (-a / w**2, w, p)
        c1 = slope - k * start + a / w * cos(w * start + p)
        c0 = y - c1 * start - 0.5 * k * start**2 - wave[0] * sin(w * start + p)
        parts.append(LawPiece(start, (c0, c1, 0.5 * k), wave))
        y = c0 + c1 * end + 0.5 * k * end**2 + wave[0] * sin(w * end + p)
        slope = c1 + k * end - a / w * cos(w * end + p)
    return tuple(
        LawPiece(each.start, tuple(c / y for c in each.coefficients), (each.wave[0] / y, *each.wave[1:]))
        for each in parts
    )


_EIGHTH = 0.125
LAWS: Mapping[str, tuple[LawPiece, ...]] = MappingProxyType(
    {
        "dwell": (LawPiece(0.0, ()),),
        "cycloidal": _by_acceleration(_Acceleration(0.0, 0.0, 1.0, 2.0 * pi)),
        "harmonic": _by_acceleration(_Acceleration(0.0, 0.0, 1.0, pi, 0.5 * pi)),
        "polynomial_345": (LawPiece(0.0, (0.0, 0.0, 0.0, 10.0, -15.0, 6.0)),),
        "polynomial_4567": (LawPiece(0.0, (0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0)),),
        "modified_sine": _by_acceleration(
            _Acceleration(0.0, 0.0, 1.0, 4.0 * pi),
            _Acceleration(_EIGHTH, 0.0, 1.0, 4.0 * pi / 3.0, pi / 3.0),
            _Acceleration(7.0 * _EIGHTH, 0.0, 1.0, 4.0 * pi),
        ),
        "modified_trapezoid": _by_acceleration(
            _Acceleration(0.0, 0.0, 1.0, 4.0 * pi),
            _Acceleration(_EIGHTH, 1.0),
            _Acceleration(3.0 * _EIGHTH, 0.0, 1.0, 4.0 * pi, -pi),
            _Acceleration(5.0 * _EIGHTH, -1.0),
            _Acceleration(7.0 * _EIGHTH, 0.0, 1.0, 4.0 * pi),
        ),
    }
)
