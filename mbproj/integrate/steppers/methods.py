"""Returns the stepper and the tableau of an integrator by its name in the registry."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from mbproj.integrate.steppers.implicit_tableau import ImplicitTableau, load_implicit_tableau
from mbproj.integrate.steppers.quadrature import QUADRATURE, quadrature
from mbproj.integrate.steppers.tableau import Tableau, load_tableau
from mbproj.registry import integrators

if TYPE_CHECKING:
    from mbproj.integrate.steppers.kinematic_steps import KinematicSteps
    from mbproj.integrate.steppers.runge_kutta import ExplicitRungeKutta

Stepper: TypeAlias = "ExplicitRungeKutta | KinematicSteps"


def tableau_of(integrator: str) -> Tableau | ImplicitTableau:
    """Return the coefficients of an integrator."""
    if integrator == QUADRATURE:
        return quadrature()
    return (load_implicit_tableau if integrators()[integrator].implicit else load_tableau)(integrator)


def stepper_of(integrator: str, *, kinematic: bool = False) -> Stepper:
    """Return the stepper of an explicit method for runs in NumPy. `kinematic`: whether steps close the bodies at each
    stage."""
    from mbproj.integrate.steppers.runge_kutta import ExplicitRungeKutta

    tableau = tableau_of(integrator)
    assert isinstance(tableau, Tableau)
    if not kinematic:
        return ExplicitRungeKutta(tableau)
    from mbproj.integrate.steppers.kinematic_steps import KinematicSteps

    return KinematicSteps(tableau)
