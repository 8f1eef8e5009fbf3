"""The interface of implicit steppers to the equations of motion: the stages of a step, solved together or one after
another."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import SimulationError


@dataclass(frozen=True, eq=False)
class Stages:
    """Solved stages: y' (s, N) and λ (s, m) at each, the `nearness` of the last to a singular pose, and the number of
    evaluations of the accelerations. `filtered` filters an estimate e (N,) of the error, for stiff forces alone: (e,
    hγ) -> (I - hγ ∂f/∂y)⁻¹ e."""

    k: Array
    multipliers: Array
    nearness: float
    evaluations: int
    filtered: Callable[[Array, float], Array]


class StagesUnsolved(SimulationError):
    """Newton's method did not solve the stages of a step in so many evaluations."""

    evaluations = 0


def branch_untold(t: float, where: str | None = None) -> SimulationError:
    """Return the error of a motion without degrees of freedom, where Newton's method may come to another branch, or to
    none, however short the step."""
    cause = (
        "what the motions prescribe cannot be followed beyond here: the mechanism is at a dead centre, or branches of "
        "its motion cross"
    )
    return SimulationError(t, cause, where=where, hint="turn back before, drive another joint, or change the lengths")


class Equations(Protocol):
    """y' = f(t, y) of a second-order system, as a right-hand side and stage by stage."""

    def __call__(self, t: float, y: Array) -> Array:
        """Return f(t, y)."""

    def of_step(self, t: float, y: Array, h: float) -> StepEquations:
        """Return the equations for the stages of a step of size h from (t, y)."""


class StepEquations(Protocol):
    """The equations for the stages of one step."""

    def solve(self, times: Array, known: Array, weights: Array, first: Array) -> Stages:
        """Return stages at `times` (s,) of y_i = known_i + Σ weights_ij f(t_j, y_j), (s, N), by Newton's method from
        the slope `first` (N,). Raises StagesUnsolved."""
