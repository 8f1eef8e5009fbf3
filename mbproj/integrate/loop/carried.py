"""The data that a step hands on. After an explicit step the accelerations are evaluated anew; after an implicit one
they and the multipliers are those of its last stage."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from mbproj.arrays import Array
from mbproj.dynamics.equations.forces import action_values
from mbproj.dynamics.equations.turning import Turning
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.formulations.stage_equations import StageEquations
from mbproj.integrate.formulations.terms import Accelerations
from mbproj.integrate.point import Point
from mbproj.integrate.reporting.tally import Tally
from mbproj.integrate.steppers.implicit_runge_kutta import ImplicitRungeKutta
from mbproj.integrate.steppers.methods import Stepper
from mbproj.integrate.steppers.runge_kutta import Step


def acted(formulation: FullFormulation, actions: Sequence[int], point: Point) -> Point:
    """Return a point after the controllers' `actions` there. Raises SimulationError that names a controller whose value
    is not finite."""
    system, layout, y = formulation.system, formulation.layout, point.y
    for action in actions:
        sets = system.actions.sets(action)
        states = y[layout["states"]].copy()
        states[system.actions.state[sets]] = action_values(
            formulation.instant(point.t, y, point.turning.coordinate), action
        )
        y = layout.changed(y, {"states": states})
    return replace(point, y=y)


def attempted(stepper: Stepper, formulation: FullFormulation, point: Point, h: float, *, watched: bool = False) -> Step:
    """Return a step of size h from a point. `watched`: whether the policy records the poses of its stages."""
    equations = StageEquations(formulation, watched)
    return stepper.attempt(equations, point.t, point.y, h, point.slope(formulation), point.found.multipliers)


def point_at(formulation: FullFormulation, y: Array, coordinate: Array, turning: Turning) -> Point:
    """Return the point at y at the time of `turning`."""
    found = formulation.accelerations(turning.t, y, turning.coordinate)
    return Point(turning.t, y, found, coordinate, turning)


def point_after(
    inside: FullFormulation,
    at_end: FullFormulation,
    tally: Tally,
    step: Step,
    y: Array,
    coordinate: Array,
    turning: Turning,
) -> Point:
    """Return the point at y after a step made with the formulation `inside`, as the formulation `at_end` evaluates
    it."""
    if step.multipliers is None:
        return point_at(at_end, y, coordinate, turning)
    found = _of_slope(inside, step.k[-1], step.multipliers[-1], step.nearness)
    point = Point(turning.t, y, found, coordinate, turning)
    if at_end is inside:
        return point
    return replace(point, found=jumped(found, seen_by(inside, point, tally), seen_by(at_end, point, tally)))


def point_within(
    formulation: FullFormulation, stepper: Stepper, step: Step, y: Array, coordinate: Array, turning: Turning
) -> Point:
    """Return the point at y within a step."""
    if not isinstance(stepper, ImplicitRungeKutta):
        return point_at(formulation, y, coordinate, turning)
    slope = stepper.within(step, (turning.t - step.t) / step.h)
    stages = StageEquations(formulation).of_step(step.t, step.y, step.h)
    found = stages.beside(turning.t, y, step.h * stepper.tableau.gamma, slope)
    return Point(turning.t, y, found, coordinate, turning)


def seen_by(formulation: FullFormulation, point: Point, tally: Tally) -> Accelerations:
    """Return the accelerations at a point in a formulation."""
    tally.count_evaluations(1)
    return formulation.accelerations(point.t, point.y, point.turning.coordinate)


def jumped(carried: Accelerations, before: Accelerations, after: Accelerations) -> Accelerations:
    """Return the accelerations carried on, plus the jump from `before` to `after`. The accelerations `after` alone
    would contain the force that a correction of the positions makes in stiff springs."""
    acceleration, multipliers, power = (
        kept + (new - old) for kept, old, new in zip(carried[:3], before[:3], after[:3], strict=True)
    )
    return Accelerations(acceleration, multipliers, power, after.nearness)


def _of_slope(formulation: FullFormulation, slope: Array, multipliers: Array, nearness: float) -> Accelerations:
    """Return the accelerations contained in a slope y'."""
    layout = formulation.layout
    return Accelerations(slope[layout["velocities"]], multipliers, slope[layout["quadratures"]], nearness)
