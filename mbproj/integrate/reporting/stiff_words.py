"""The effect of stiffness on a run, in words, with remedies."""

from __future__ import annotations

from math import floor, log10, pi

from mbproj.dataclass import dataclass
from mbproj.errors import SimulationError
from mbproj.integrate.steppers.stability_region import reach
from mbproj.integrate.steppers.tableau import tableau_of
from mbproj.registry import explicit_integrators, implicit_integrators
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True)
class Stiffness:
    """The mode that limited the step.

    `where` is its cause ("force 'coil'", "state 'current'"), `omega_h` |hλ| with the `step` h in s. `limit` is the
    largest |hλ| at which the integrator is stable along the `direction` of λ. `growth` is that of an error in a
    step."""

    where: str
    omega_h: float
    limit: float
    growth: float
    step: float
    direction: complex
    integrator: str

    @property
    def what(self) -> str:
        """|hλ|, with the symbol of its kind, and the limit, in words."""
        name = "ω h" if abs(self.direction.imag) > 0.5 else "c h / m"
        on = " on the masses that it moves"
        if not self.is_of_forces:
            name = "|λ| h" if self.is_of_states else "α h"
            on = f" at {self.omega_h / self.step:.3g} 1/s" if self.is_of_states else ""
        return f"{name} = {self.omega_h:.3g}{on}, and {self.integrator} is stable up to {self.limit:.3g}"

    @property
    def is_of_forces(self) -> bool:
        """Whether forces cause the mode."""
        return self.where.startswith("force")

    @property
    def is_of_states(self) -> bool:
        """Whether states of elements cause the mode."""
        return self.where.startswith("state")

    def with_verb(self, one: str, several: str) -> str:
        """Return the cause with its verb, `one` or `several`."""
        return f"{self.where} {several if self.where.startswith(('forces', 'states')) else one}"

    @property
    def grows(self) -> str:
        """The growth of an error in a step, in words."""
        size = (
            f"{self.growth:.3g}-fold"
            if self.growth < THRESHOLDS.spoilt**2
            else f"more than {THRESHOLDS.spoilt**2:.0e}-fold"
        )
        return f"errors grow {size} in each step"

    @property
    def stable_step(self) -> str:
        """The advice of a stable step, with two digits."""
        step = THRESHOLDS.safety * self.limit / self.omega_h * self.step
        unit = 10.0 ** (floor(log10(step)) - 1)
        return f"take steps of {unit * floor(step / unit):.2g} s or less"

    @property
    def remedies(self) -> str:
        """The advice of other methods, or a softer mechanism."""
        softer = "a softer force" if self.is_of_forces else "slower states" if self.is_of_states else "smaller gains"
        limits = {name: reach(tableau_of(name), self.direction) for name in explicit_integrators()}
        best = max(limits, key=lambda name: limits[name])
        larger = f"{best}, which is stable up to {limits[best]:.3g}, or " if limits[best] > 1.2 * self.limit else ""
        implicit = " or ".join(implicit_integrators())
        return f"{larger}{softer}; {implicit} is not held up by it"


def too_stiff(stopped: SimulationError, stiffness: Stiffness) -> SimulationError:
    """Return the error of a run that stopped because a force or a state is too stiff for its step."""
    cause = f"stiff: {stiffness.what}, so that {stiffness.grows} of {stiffness.step:.3g} s"
    return SimulationError(
        stopped.time, cause, where=stiffness.where, hint=f"{stiffness.stable_step}, {stiffness.remedies}"
    )


def grows(stiffness: Stiffness) -> str:
    """Return the note on a run that has ended with errors that grew."""
    return (
        f"{stiffness.with_verb('is', 'are')} too stiff for steps of {stiffness.step:.3g} s: {stiffness.what}, so that "
        f"{stiffness.grows} and the motion is not to be trusted; {stiffness.stable_step}, {stiffness.remedies}"
    )


def holds(stiffness: Stiffness) -> str:
    """Return the note on a run with error control that made small steps for stability alone."""
    return (
        f"{stiffness.with_verb('is stiff and holds', 'are stiff and hold')} the step at "
        f"{stiffness.step:.2g} s for stability alone ({stiffness.what}), "
        f"where accuracy would allow larger ones; quicker would be {stiffness.remedies}"
    )


def damps(stiffness: Stiffness) -> str:
    """Return the note on an implicit run that has damped a vibration which the mechanism itself hardly damps."""
    frequency, lost = stiffness.omega_h / stiffness.step / (2.0 * pi), 100.0 * (1.0 - min(stiffness.growth, 1.0))
    follows = 0.5 * THRESHOLDS.unresolved_vibration * stiffness.step / stiffness.omega_h
    on = " on the masses that it moves" if stiffness.is_of_forces else ""
    where = (
        ". The energy that it loses so is in the energy drift, not in the dissipation" if stiffness.is_of_forces else ""
    )
    return (
        f"{stiffness.with_verb('vibrates', 'vibrate')} with {frequency:.3g} Hz{on}; {stiffness.integrator} damps that "
        f"by {lost:.2g} % in a step of {stiffness.step:.2g} s (ω h = {stiffness.omega_h:.3g}); "
        f"steps of {follows:.2g} s would follow it{where}"
    )
