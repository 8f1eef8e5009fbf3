"""The coefficients of an explicit Runge-Kutta method: Butcher's tableau, read from a data file. The tableau of
any integrator by its name in the registry.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.registry import IntegratorEntry, integrators

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
        return quadrature()
    if not integrators()[integrator].implicit:
        return load_tableau(integrator)

    return load_implicit_tableau(integrator)


# --- The quadrature of a kinematic run --------------------------------------------------------------------------------
# Quantities along the motion are integrated over a step from seven values. The nodes are those of Kronrod's
# extension, of order 10, of Lobatto's rule with four points (Gander & Gautschi 2000). That rule, of order 6, gives
# the error estimate. Stages, extension and predictions are integrals of the polynomials through the values.


#: The nodes on [-1, 1]; every second one is a node of Lobatto's rule.
NODES = np.array([-1.0, -np.sqrt(2.0 / 3.0), -np.sqrt(0.2), 0.0, np.sqrt(0.2), np.sqrt(2.0 / 3.0), 1.0])
LOBATTO = (0, 2, 4, 6)
ORDER, ERROR_ORDER = 10, 6


@cache
def quadrature() -> Tableau:
    """Return the quadrature as an explicit method: each stage is predicted from those before it, and none depends on
    its own value."""
    c = 0.5 * (1.0 + NODES)
    stages = len(c)
    a = np.zeros((stages, stages))
    for stage in range(1, stages):
        a[stage, :stage] = integrals(c[:stage], c[stage])
    b, dense = integrals(c, 1.0), np.zeros((stages + 1, stages))
    dense[:-1] = lagrange(c) / np.arange(1, stages + 1)
    error = np.zeros((1, stages + 1))
    error[0, :-1] = b
    error[0, list(LOBATTO)] -= integrals(c[list(LOBATTO)], 1.0)
    nothing = np.zeros((0, stages + 1))
    return Tableau(QUADRATURE, ORDER, ERROR_ORDER, a, b, c, error, nothing, np.zeros(0), dense)


def lagrange(nodes: Array) -> Array:
    """Return the coefficients (s, s) of 1, x, x², … in the polynomials that are 1 at a node (s,) and 0 at the
    others."""
    return np.asarray(np.linalg.inv(np.vander(nodes, increasing=True)).T)


def integrals(nodes: Array, end: float) -> Array:
    """Return the weights (s,) of values at the nodes in the integral of the polynomial through them from 0 to `end`."""
    powers = np.arange(1, len(nodes) + 1)
    return np.asarray(lagrange(nodes) @ (end**powers / powers))


# --- Coefficients of implicit methods ---------------------------------------------------------------------------------
# The coefficients of an implicit Runge-Kutta method for stiff equations, read from a data file.


@dataclass(frozen=True, eq=False)
class ImplicitTableau:
    """Coefficients of a stiffly accurate method of s stages. The first stage is f at the start of the step, carried
    over from the step before (Hairer & Wanner 1996, sect. IV.5, IV.6 and IV.8).

    `a` (s, s), `b` (s,) is its last row, `c` (s,). `error` (s,): weights of the stages in the estimate of the local
    error, which is filtered by (I - h `gamma` ∂f/∂y)⁻¹; it is of order `error_order` + 1 in h. `dense` (s, d): the
    coefficients of θ, θ², … of the continuous extension, over the stages. `splitting` (s, s): the lower triangular
    matrix, with `gamma` on its diagonal, by which the kernel solves the stages; `a` itself where no stage needs a later
    one.
    """

    name: str
    order: int
    error_order: int
    gamma: float
    a: Array
    b: Array
    c: Array
    error: Array
    dense: Array
    splitting: Array

    @property
    def stages(self) -> int:
        """s, the number of stages with the first."""
        return len(self.b)


def load_implicit_tableau(name: str) -> ImplicitTableau:
    """Return the tableau of an implicit method by its name."""
    return _implicit_loaded(name, integrators()[name])


@cache
def _implicit_loaded(name: str, entry: IntegratorEntry) -> ImplicitTableau:
    data = entry.data()
    stages = len(data["b"])
    return ImplicitTableau(
        name=name,
        order=data["order"],
        error_order=data["error_order"],
        gamma=float(vector([data["gamma"]])[0]),
        a=matrix([[], *data["a"]], stages),
        b=vector(data["b"]),
        c=vector(data["c"]),
        error=vector(data["error"]),
        dense=matrix(data["dense"], len(data["dense"][0])),
        splitting=matrix([[], *data.get("splitting", data["a"])], stages),
    )
