"""The coefficients of an explicit Runge-Kutta method: Butcher's tableau, read from a data file. The tableau of
any integrator by its name in the registry."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.registry import IntegratorEntry, integrators

if TYPE_CHECKING:
    from mbproj.integrate.steppers.implicit_tableau import ImplicitTableau

#: The name of the method of a kinematic run, for `tableau_of`; no scene names it.
QUADRATURE = "quadrature"


@dataclass(frozen=True, eq=False)
class Tableau:
    """Coefficients of an explicit method of s stages (Hairer, Nørsett & Wanner 1993, sect. II.1-II.6).

    `a` (s, s), `b` (s,), `c` (s,). An embedded pair has one or two rows `error` (e, s+1), weights of the stages and of
    f at the new point, and `error_order`. `dense` (s+1+x, d) are the coefficients of θ, θ², … of the continuous
    extension, over the stages, f at the new point, and the x `extra` stages with `extra_a` (x, s+1+x), `extra_c` (x,).
    Arrays of methods without an estimate or an extension are empty.
    """

    name: str
    order: int
    error_order: int
    a: Array
    b: Array
    c: Array
    error: Array
    extra_a: Array
    extra_c: Array
    dense: Array

    @property
    def stages(self) -> int:
        """s, the number of evaluations of a step without an error estimate."""
        return len(self.b)

    @property
    def embedded(self) -> bool:
        """Whether the method estimates its error."""
        return len(self.error) > 0


def load_tableau(name: str) -> Tableau:
    """Return the tableau of an integrator by its name in the registry."""
    return _loaded(name, integrators()[name])


@cache
def _loaded(name: str, entry: IntegratorEntry) -> Tableau:
    data = entry.data()
    stages = len(data["b"])
    extra = data.get("extra_a", [])
    return Tableau(
        name=name,
        order=data["order"],
        error_order=data.get("error_order", 0),
        a=matrix([[], *data["a"]], stages),
        b=vector(data["b"]),
        c=vector(data["c"]),
        error=matrix(data.get("error", []), stages + 1),
        extra_a=matrix(extra, stages + 1 + len(extra)),
        extra_c=vector(data.get("extra_c", [])),
        dense=matrix(data.get("dense", []), len(data["dense"][0]) if "dense" in data else 0),
    )


def vector(numbers: Sequence[str]) -> Array:
    """Return numbers from fractions or decimals."""
    return np.array([_number(text) for text in numbers])


def _number(text: str) -> float:
    """Return the number nearest to p/q, or to a decimal."""
    numerator, _, denominator = text.partition("/")
    return int(numerator) / int(denominator) if denominator else float(numerator)


def matrix(rows: Sequence[Sequence[str]], width: int) -> Array:
    """Return rows of numbers, filled with zeros on the right."""
    values = np.zeros((len(rows), width))
    for index, row in enumerate(rows):
        values[index, : len(row)] = vector(row)
    return values


def tableau_of(integrator: str) -> Tableau | ImplicitTableau:
    """Return the coefficients of an integrator."""
    if integrator == QUADRATURE:
        from mbproj.integrate.steppers.quadrature import quadrature

        return quadrature()
    if not integrators()[integrator].implicit:
        return load_tableau(integrator)
    from mbproj.integrate.steppers.implicit_tableau import load_implicit_tableau

    return load_implicit_tableau(integrator)
