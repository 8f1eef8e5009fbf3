"""The time loop: step, project, check, record; with a fixed step, or with the step that the error allows."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array, may_overflow
from mbproj.dynamics.assembly.assemble import State, coordinates
from mbproj.dynamics.equations.motions import drive_at
from mbproj.dynamics.equations.teeth import near
from mbproj.dynamics.equations.turning import Turning
from mbproj.dynamics.observe.samples import Sample
from mbproj.errors import SimulationError
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.loop.step_size import Controller, error_norm, first_step
from mbproj.integrate.outcome.failures import TurnsUntold, left_open, not_finite, step_vanished, unresolved
from mbproj.integrate.outcome.tally import Tally
from mbproj.integrate.point import Point, counted, untold
from mbproj.integrate.steppers.runge_kutta import RightHandSide, Step, continuous_extension, error_estimates, rk_step
from mbproj.integrate.steppers.tableau import Tableau, load_tableau
from mbproj.model.system import System
from mbproj.scene.sampling import output_every, output_times, whole_steps
from mbproj.thresholds import THRESHOLDS


def march(formulation: FullFormulation, state: State, tally: Tally) -> Iterator[Sample]:
    """Samples from the start to the end of the duration. Raises SimulationError where the run cannot go on."""
    settings = formulation.settings
    tableau = load_tableau(settings.integrator)
    start = _first(formulation, state, tally)
    by_error = settings.tolerance is not None
    yield from (_by_error if by_error else _fixed)(formulation, tableau, start, tally)


def _fixed(formulation: FullFormulation, tableau: Tableau, point: Point, tally: Tally) -> Iterator[Sample]:
    """Steps of one size; the time of step k is t0 + k h, so that it does not drift. The last step may be shorter."""
    settings, start = formulation.settings, point.t
    h, end = _required(settings.step), start + _required(settings.duration)
    steps, every = whole_steps(settings), output_every(settings)
    yield point.sample(formulation, h, tally)
    for k in range(1, steps + 1):
        t = end if k == steps else start + k * h
        step = rk_step(formulation.watched_derivative, tableau, point.t, point.y, t - point.t, point.slope)
        tally.count_evaluations(tableau.stages - 1)
        point = _accept(formulation, tableau, tally, point, t, step)
        if k % every == 0 or k == steps:
            yield point.sample(formulation, step.h, tally)


def _by_error(formulation: FullFormulation, tableau: Tableau, point: Point, tally: Tally) -> Iterator[Sample]:
    """Steps as large as the error estimate allows; outputs in between by the continuous extension."""
    settings, f = formulation.settings, formulation.watched_derivative
    end, tolerance = point.t + _required(settings.duration), _required(settings.tolerance)
    scale, times = _absolute_scale(formulation), output_times(settings, point.t)
    h = first_step(f, tableau.order, point.t, point.y, point.slope, tolerance, scale, end - point.t)
    tally.count_evaluations(1)
    control, lost = Controller(tableau.error_order), None
    yield point.sample(formulation, h, tally)
    done = 1
    while done < len(times):
        if _vanishes(h, point.t, end):
            raise lost or step_vanished(point.t)
        h = _fitted(h, point.t, end)
        t = end if h == end - point.t else point.t + h
        formulation.policy.begin()
        tried = _attempt(f, tableau, point, h, t, tolerance, scale)
        tally.count_evaluations(tableau.stages)
        if isinstance(tried, SimulationError) or not tried.error <= 1.0:
            tally.rejected_steps += 1
            lost = tried if isinstance(tried, SimulationError) else None
            h, control = control.after_rejected(np.nan if isinstance(tried, SimulationError) else tried.error, h)
            continue
        step, last, error = tried
        try:
            before, point = point, _accept(formulation, tableau, tally, point, t, step)
        except TurnsUntold as untold:
            tally.reject_accepted()
            h = untold.step
            continue
        between = times[done : bisect_left(times, t, done)]
        if between:
            yield from _in_between(formulation, tableau, tally, before, point, step, last, between)
        done += len(between)
        if done < len(times) and times[done] == t:
            yield point.sample(formulation, h, tally)
            done += 1
        h, control = control.after_accepted(error, h)


class _Attempt(NamedTuple):
    """A step, f at its end, and the norm of its error."""

    step: Step
    last: Array
    error: float


def _attempt(
    f: RightHandSide, tableau: Tableau, point: Point, h: float, t: float, tolerance: float, scale: Array
) -> _Attempt | SimulationError:
    """A step from a point over h to t, or why its equations have no solution: a step that is too large may lead to
    where a function has no value, or beyond what numbers can hold."""
    try:
        with may_overflow():
            step = rk_step(f, tableau, point.t, point.y, h, point.slope)
            last = f(t, step.y_new)
            error = error_norm(error_estimates(tableau, step, last), step.y, step.y_new, tolerance, scale)
    except SimulationError as lost:
        return lost
    return _Attempt(step, last, error) if np.isfinite(error) else not_finite(t)


def _in_between(
    formulation: FullFormulation,
    tableau: Tableau,
    tally: Tally,
    before: Point,
    after: Point,
    step: Step,
    last: Array,
    times: list[float],
) -> Iterator[Sample]:
    """Samples inside a step: the extension's value, of which a copy is projected; the integration does not see it."""
    tally.count_evaluations(len(tableau.extra_c) + len(times))
    extension = continuous_extension(formulation.derivative, tableau, step, last)
    system = formulation.system
    for t in times:
        y = formulation.project_copy(t, formulation.lead(t, extension((t - step.t) / step.h)))
        coordinate, speed = coordinates(system, *formulation.parts(y)[:2])
        expected = formulation.parts(y)[3]
        if not formulation.followed:
            expected = before.turning.between(system, after.turning, t, drive_at(system, t))
        turning = Turning(t, near(system, coordinate, expected), speed, after.turning.prescribed)
        yield _point(formulation, y, coordinate, turning).sample(formulation, step.h, tally)


def _accept(formulation: FullFormulation, tableau: Tableau, tally: Tally, before: Point, t: float, step: Step) -> Point:
    """The point after a step: projected, checked, counted. Raises SimulationError where it overflows."""
    y = formulation.lead(t, step.y_new)
    if not np.all(np.isfinite(y)):
        raise not_finite(t)
    with may_overflow():
        found = _accepted(formulation, tableau, tally, before, t, step, y)
    if not np.all(np.isfinite(found.slope)):
        raise not_finite(t)
    return found


def _accepted(
    formulation: FullFormulation, tableau: Tableau, tally: Tally, before: Point, t: float, step: Step, y: Array
) -> Point:
    """The same, which may overflow."""
    tally.steps += 1
    tally.count_evaluations(1)
    projected = formulation.project(tally.steps, t, y)
    tally.count_projection(projected)
    formulation.check_branch(t, t - before.t, y, projected)
    *_, integrals, expected = formulation.parts(y)
    position, velocity = formulation.violations(t, projected.q, projected.v, expected)
    limit = THRESHOLDS.open_limit if projected.failures else THRESHOLDS.lost_limit
    if not np.all(position <= limit * formulation.system.row_scale):
        far = before.turning.far(formulation.system, t)
        if far is not None:
            raise untold(formulation, before, t, far)
        system, row = formulation.system, int(np.argmax(position / formulation.system.row_scale))
        if not np.isfinite(position[row]):
            raise not_finite(t)
        where, method = system.row_owner(row), formulation.settings.projection
        passes, failed = projected.position_iterations, projected.failures > 0
        raise left_open(t, where, position[row], passes, projection=method, failed=failed)
    coordinate, turning = counted(formulation, tableau, before, t, step, projected.q, projected.v)
    tally.watch(position, velocity, _joint_rows(formulation.system), t)
    y = np.concatenate([projected.q, projected.v, integrals, turning.coordinate[: formulation.followed]])
    if formulation.arrive(projected.q) < THRESHOLDS.close_to_singular:
        _check_by_halves(formulation, tableau, before, t, y)
    found = _point(formulation, y, coordinate, turning)
    formulation.policy.keep(found.found.multipliers)
    return found


def _check_by_halves(formulation: FullFormulation, tableau: Tableau, before: Point, t: float, y: Array) -> None:
    """Raises SimulationError where a step that came near a singular pose reaches other velocities than two half steps:
    it may have left its branch of the motion with velocities that belong to another one."""
    h, half = 0.5 * (t - before.t), before
    for time in (before.t + h, t):
        step = rk_step(formulation.derivative, tableau, half.t, half.y, time - half.t, half.slope)
        closed = formulation.project_copy(time, formulation.lead(time, step.y_new))
        turned = counted(formulation, tableau, half, time, step, *formulation.parts(closed)[:2])
        half = _point(formulation, closed, *turned)
    v = formulation.parts(y)[1]
    off = formulation.change(v, formulation.parts(half.y)[1])
    if not off <= THRESHOLDS.branch_change:
        raise unresolved(t, off)


def _first(formulation: FullFormulation, state: State, tally: Tally) -> Point:
    """The start as a point: its turns are those of the state."""
    tally.count_evaluations(1)
    system, drive = formulation.system, drive_at(formulation.system, state.t)
    coordinate, speed = coordinates(system, state.q, state.v)
    prescribed = np.zeros(0) if drive is None else drive.value
    turning = Turning(state.t, coordinate + 2.0 * np.pi * state.turns, speed, prescribed)
    violations = formulation.violations(state.t, state.q, state.v, turning.coordinate)
    tally.watch(*violations, _joint_rows(system), state.t)
    formulation.check_regular(state.t, state.q)
    formulation.arrive(state.q)
    found = formulation.accelerations(state.t, state.q, state.v, turning.coordinate)
    followed = turning.coordinate[: formulation.followed]
    y = np.concatenate([state.q, state.v, np.zeros(formulation.quadratures), followed])
    return Point(state.t, y, found, coordinate, turning)


def _point(formulation: FullFormulation, y: Array, coordinate: Array, turning: Turning) -> Point:
    """The point at y at the time of `turning`."""
    q, v, *_ = formulation.parts(y)
    found = formulation.accelerations(turning.t, q, v, turning.coordinate)
    return Point(turning.t, y, found, coordinate, turning)


def _joint_rows(system: System) -> slice:
    """The rows of C that are the joints'."""
    return slice(system.bodies, system.bodies + system.joints.size)


def _absolute_scale(formulation: FullFormulation) -> Array:
    """What the absolute tolerance is relative to, (14n + integrals,): the system's length (per s) for r (r'), 1 (per s)
    for Λ; without bound for work and dissipation, which do not steer the step."""
    coordinates = np.tile([formulation.system.length] * 3 + [1.0] * 4, 2 * formulation.system.bodies)
    return np.concatenate([coordinates, np.full(formulation.quadratures + formulation.followed, np.inf)])


def _vanishes(h: float, t: float, end: float) -> bool:
    """Whether time cannot resolve steps of this size."""
    return not h >= 16.0 * np.finfo(float).eps * max(abs(t), abs(end))


def _fitted(h: float, t: float, end: float) -> float:
    """h, or what is left to the end, or half of that where one step more would be tiny."""
    left = end - t
    if h >= left:
        return left
    return 0.5 * left if 2.0 * h > left > 1.01 * h else h


def _required(value: float | None) -> float:
    assert value is not None  # settings_to_run has seen to it
    return value
