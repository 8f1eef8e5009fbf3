"""Pieces of a plane curve. A piece has two functions, each a polynomial plus a sine, which give its points."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum

from mbproj.dataclass import dataclass

#: Numbers of a function: c0 to c7, then a, w and p of a sin(w u + p).
TERMS = 8
NUMBERS = TERMS + 3


class Form(IntEnum):
    """The form in which two functions f and g of u give a point. The parameter is s = origin + u.

    cartesian  (f, g)
    polar      f (cos s, sin s): f is the radius at the polar angle s
    support    f n + f' t with n = (cos s, sin s), t = (-sin s, cos s): f is the distance of the tangent line from the
               origin, s the direction of its normal; the form of curves that a flat face touches
    """

    CARTESIAN = 0
    POLAR = 1
    SUPPORT = 2


@dataclass(frozen=True)
class Piece:
    """A part of a curve, from the parameter `start` on. Its functions f and g are of u = s - origin and have `NUMBERS`
    numbers each."""

    start: float
    origin: float
    form: Form
    f: tuple[float, ...]
    g: tuple[float, ...] = (0.0,) * NUMBERS


def polynomial(coefficients: Sequence[float], wave: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> tuple[float, ...]:
    """The numbers of the function Σ c_k u^k + a sin(w u + p). `wave` is (a, w, p)."""
    return (*coefficients, *(0.0,) * (TERMS - len(coefficients)), *wave)


def scaled(numbers: Sequence[float], k: float) -> tuple[float, ...]:
    """The numbers of k times the function."""
    *coefficients, a, w, p = numbers
    return (*(k * c for c in coefficients), k * a, w, p)


def mirrored(numbers: Sequence[float]) -> tuple[float, ...]:
    """The numbers of the function of -u."""
    *coefficients, a, w, p = numbers
    return (*((-1.0) ** k * c for k, c in enumerate(coefficients)), a, -w, p)
