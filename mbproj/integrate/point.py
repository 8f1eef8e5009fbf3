"""A state of a run between two steps, and the turns of the joints' angles in a step."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State, coordinates
from mbproj.dynamics.equations.forces import action_values
from mbproj.dynamics.equations.motions import drive_at
from mbproj.dynamics.equations.turning import Turning, UncertainTurn, turns_of
from mbproj.dynamics.observe.samples import Sample
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.formulations.terms import Accelerations
from mbproj.integrate.reporting.failures import TurnsUntold
from mbproj.integrate.reporting.tally import Tally
from mbproj.integrate.steppers.runge_kutta import Step
from mbproj.integrate.steppers.tableau import Stepper


@dataclass(frozen=True, eq=False)
class Point:
    """An accepted y at time t, with the accelerations, λ and powers `found` there.

    `coordinate` are the joints' coordinates without turns; `turning` are those with turns, and the data from which the
    next step counts them."""

    t: float
    y: Array
    found: Accelerations
    coordinate: Array
    turning: Turning

    def slope(self, formulation: FullFormulation) -> Array:
        """Return y'."""
        return formulation.slope(self.t, self.y, self.found)

    def turns(self, formulation: FullFormulation) -> Integers:
        """Return the whole turns of the joints' coordinates, (nc,)."""
        return turns_of(formulation.system, self.turning.coordinate, self.coordinate)

    def state(self, formulation: FullFormulation) -> State:
        """Return the state at this point."""
        return formulation.state(self.t, self.y, self.turns(formulation))

    def save(self) -> dict[str, Any]:
        """Return this point as plain data."""
        accelerations, turning = self.found, self.turning
        return {
            "t": self.t,
            "y": self.y,
            "acceleration": accelerations.acceleration,
            "multipliers": accelerations.multipliers,
            "power": accelerations.power,
            "nearness": accelerations.nearness,
            "coordinate": self.coordinate,
            "turned": turning.coordinate,
            "speed": turning.speed,
            "prescribed": turning.prescribed,
        }

    @classmethod
    def restore(cls, saved: Mapping[str, Any]) -> Point:
        """Return the point that was saved."""
        accelerations = Accelerations(
            saved["acceleration"], saved["multipliers"], saved["power"], float(saved["nearness"])
        )
        turning = Turning(float(saved["t"]), saved["turned"], saved["speed"], saved["prescribed"])
        return cls(float(saved["t"]), saved["y"], accelerations, saved["coordinate"], turning)

    def sample(self, formulation: FullFormulation, step_size: float, tally: Tally) -> Sample:
        """Return this point as a sample."""
        acceleration, multipliers, power, _ = self.found
        work = self.y[formulation.layout["quadratures"]] if len(power) else np.zeros(2)
        rows = multipliers[formulation.system.bodies :]
        return Sample(self.state(formulation), acceleration, rows, step_size, work, tally.counters())


def point_at(formulation: FullFormulation, y: Array, coordinate: Array, turning: Turning) -> Point:
    """Return the point at y at the time of `turning`."""
    accelerations = formulation.accelerations(turning.t, y, turning.coordinate)
    return Point(turning.t, y, accelerations, coordinate, turning)


def acted(formulation: FullFormulation, actions: Sequence[int], point: Point) -> Point:
    """Return a point after the controllers' `actions` there. Raises SimulationError that names a controller whose value
    is not finite."""
    system, layout, y = formulation.system, formulation.layout, point.y
    for action in actions:
        sets = system.actions.sets(action)
        states = y[layout["states"]].copy()
        instant = formulation.instant(point.t, y, point.turning.coordinate)
        states[system.actions.state[sets]] = action_values(instant, action)
        y = layout.changed(y, {"states": states})
    return replace(point, y=y)


@dataclass(frozen=True, eq=False)
class Slopes:
    """y' of a formulation as the right-hand side of a step. `watched`: whether its policy records the poses of the
    stages."""

    formulation: FullFormulation
    watched: bool = False

    def __call__(self, t: float, y: Array) -> Array:
        """Return y' at a state."""
        return self.formulation.watched_derivative(t, y) if self.watched else self.formulation.derivative(t, y)


def attempted(stepper: Stepper, formulation: FullFormulation, point: Point, h: float, *, watched: bool = False) -> Step:
    """Return a step of size h from a point. `watched`: whether the policy records the poses of its stages."""
    return stepper.attempt(Slopes(formulation, watched), point.t, point.y, h, point.slope(formulation))


def counted(
    formulation: FullFormulation, stepper: Stepper, before: Point, t: float, step: Step, q: Array, v: Array
) -> tuple[Array, Turning]:
    """Return the joints' coordinates at (q, v) after a step from `before`, without turns and with. Raises TurnsUntold
    where the step is too long to count turns."""
    system, drive = formulation.system, drive_at(formulation.system, t)
    coordinate, speed = coordinates(system, q, v)
    counted, slip = before.turning.count(system, coordinate, before.turning.by_rates(t, speed), drive)
    if slip is not None:
        counted, slip = before.turning.count(system, coordinate, _by_stages(formulation, stepper, before, step), drive)
    if slip is not None:
        raise untold(formulation, before, t, slip)
    return coordinate, Turning(t, counted, speed, drive.value)


def _by_stages(formulation: FullFormulation, stepper: Stepper, before: Point, step: Step) -> Array:
    """Return the change of the joints' coordinates in a step by the rates of its stages, (nc,)."""
    followed = formulation.split(step.y_new)[2]
    if len(followed):
        return followed - before.turning.coordinate
    change = np.zeros_like(before.coordinate)
    for weight, y in stepper.quadrature(step):
        change += step.h * weight * coordinates(formulation.system, *formulation.split(y)[:2])[1]
    return change


def untold(formulation: FullFormulation, before: Point, t: float, slip: UncertainTurn) -> TurnsUntold:
    name, teeth = formulation.system.names.coordinates[slip.coordinate], formulation.system.couplings.size > 0
    return TurnsUntold(t, name, slip.turned, slip.off, (t - before.t) * slip.shorter, teeth=teeth)
