"""The stepper and the tableau of an integrator by its name in the registry."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from mbproj.integrate.steppers.implicit_tableau import ImplicitTableau, load_implicit_tableau
from mbproj.integrate.steppers.tableau import Tableau, load_tableau
from mbproj.registry import integrators

if TYPE_CHECKING:
    from mbproj.integrate.steppers.implicit_runge_kutta import ImplicitRungeKutta
    from mbproj.integrate.steppers.runge_kutta import ExplicitRungeKutta

Stepper: TypeAlias = "ExplicitRungeKutta | ImplicitRungeKutta"


def tableau_of(integrator: str) -> Tableau | ImplicitTableau:
    """The coefficients of an integrator."""
    return (load_implicit_tableau if integrators()[integrator].implicit else load_tableau)(integrator)


def stepper_of(integrator: str) -> Stepper:
    """What makes its steps, where the kernel does not."""
    from mbproj.integrate.steppers.implicit_runge_kutta import ImplicitRungeKutta
    from mbproj.integrate.steppers.runge_kutta import ExplicitRungeKutta

    tableau = tableau_of(integrator)
    return ImplicitRungeKutta(tableau) if isinstance(tableau, ImplicitTableau) else ExplicitRungeKutta(tableau)
