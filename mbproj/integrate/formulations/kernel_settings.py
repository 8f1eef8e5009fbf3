"""The settings of a run in the kernel's classes: its tableau, its steps, and the times at which they end."""

from __future__ import annotations

from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from mbproj.integrate.events.leg import Leg
from mbproj.integrate.steppers.tableau import Tableau
from mbproj.scene.records import Settings

if TYPE_CHECKING:
    from mbproj.integrate.steppers.implicit_tableau import ImplicitTableau


def kernel_tableau(core: ModuleType, tableau: Tableau | ImplicitTableau, *, kinematic: bool) -> Any:
    """Return a tableau as the kernel's class."""
    if isinstance(tableau, Tableau):
        parts = (tableau.a, tableau.b, tableau.c, tableau.error, tableau.extra_a, tableau.extra_c, tableau.dense)
        made = core.Tableau(tableau.order, tableau.error_order, *(np.ascontiguousarray(part) for part in parts))
        made.kinematic = kinematic
        return made
    names = ("a", "b", "c", "error", "dense", "splitting")
    coefficients = {name: np.ascontiguousarray(getattr(tableau, name)) for name in names}
    return core.Tableau.implicit(tableau.order, tableau.error_order, tableau.gamma, **coefficients)


def kernel_breaks(leg: Leg) -> list[tuple[Any, ...]]:
    """Return the times at which steps end, as the kernel takes them."""
    return [(*each[:3], list(each.actions), each.asks) for each in leg.breaks]


def kernel_steps(core: ModuleType, settings: Settings, leg: Leg) -> Any:
    """Return the steps of a run as the kernel's class: fixed, or by error control."""
    breaks = kernel_breaks(leg)
    if leg.step is not None:
        return core.Steps.fixed(leg.start, leg.duration, leg.step, leg.count, leg.every, breaks)
    assert leg.times is not None
    samples = (leg.times.origin, leg.times.interval, leg.times.offset, leg.times.number)
    return core.Steps.by_error(leg.start, leg.duration, settings.tolerance, samples, breaks)
