"""The coefficients of an implicit Runge-Kutta method for stiff equations, read from a data file."""

from __future__ import annotations

from functools import cache

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.integrate.steppers.tableau import matrix, vector
from mbproj.registry import IntegratorEntry, integrators


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
    return _loaded(name, integrators()[name])


@cache
def _loaded(name: str, entry: IntegratorEntry) -> ImplicitTableau:
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
