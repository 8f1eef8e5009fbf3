"""The end of a step: the state is projected, checked, and evaluated, and turns are counted."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, may_overflow
from mbproj.dynamics.assembly.assemble import State, coordinates
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.equations.motions import drive_at
from mbproj.dynamics.equations.turning import Turning
from mbproj.dynamics.off_path import off_path
from mbproj.dynamics.overlap import overlapping
from mbproj.errors import SimulationError
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.point import Point, attempted, counted, point_at, untold
from mbproj.integrate.reporting.failures import left_open, not_finite, off_rope, overlap, unresolved
from mbproj.integrate.reporting.tally import Tally
from mbproj.integrate.steppers.runge_kutta import Step
from mbproj.integrate.steppers.tableau import Stepper
from mbproj.model.system import System
from mbproj.projection import ProjectedState
from mbproj.thresholds import THRESHOLDS


def accept(
    inside: FullFormulation,
    at_end: FullFormulation,
    stepper: Stepper,
    tally: Tally,
    before: Point,
    t: float,
    step: Step,
) -> Point:
    """Return the point after a step made with the formulation `inside`: projected, checked, with turns, and evaluated
    with `at_end`. Raises SimulationError where it overflows."""
    y = inside.lead(t, step.y_new)
    if not np.all(np.isfinite(y)):
        raise not_finite(t)
    with may_overflow():
        y, coordinate, turning = _project(inside, stepper, tally, before, t, step, y)
        if inside.arrive(inside.split(y)[0]) < THRESHOLDS.close_to_singular and step.stages is None:
            _check_by_halves(inside, stepper, before, t, y)
        point = point_at(at_end, y, coordinate, turning)
        inside.policy.keep(point.found.multipliers)
    if not np.all(np.isfinite(point.slope(at_end))):
        raise not_finite(t)
    return point


def _project(
    formulation: FullFormulation,
    stepper: Stepper,
    tally: Tally,
    before: Point,
    t: float,
    step: Step,
    y: Array,
) -> tuple[Array, Array, Turning]:
    """Return the projected state after a step, and the joints' coordinates there, without turns and with."""
    tally.steps += 1
    tally.count_evaluations(1)
    projected = formulation.project(tally.steps, t, before.y, y)
    tally.count_projection(projected)
    try:
        formulation.check_branch(t, t - before.t, y, projected)
    except SimulationError as error:  # a step too long to count turns may come to any branch, crossing or not
        raise _too_far(formulation, before, t) or error from None
    expected = formulation.split(y)[2]
    position, velocity = formulation.violations(t, projected.q, projected.v, expected)
    if not is_closed(formulation, position, projected):
        raise _open(formulation, before, t, position, projected)
    if (trouble := off_path(formulation.system, pose_of(projected.q))) is not None:
        raise off_rope(t, formulation.system, *trouble)
    if (joint := overlapping(formulation.system, pose_of(projected.q))) is not None:
        raise overlap(t, joint)
    coordinate, turning = counted(formulation, stepper, before, t, step, projected.q, projected.v)
    tally.watch(position, velocity, _joint_rows(formulation.system), t)
    closed = {"positions": projected.q, "velocities": projected.v, "followed": turning.coordinate[: len(expected)]}
    return formulation.layout.changed(y, closed), coordinate, turning


def _open(
    formulation: FullFormulation, before: Point, t: float, position: Array, projected: ProjectedState
) -> SimulationError:
    """Return the error for a step to t that has left |C| at `position`."""
    return _too_far(formulation, before, t) or left_open_at(formulation, t, position, projected)


def _too_far(formulation: FullFormulation, before: Point, t: float) -> SimulationError | None:
    """Return the error for a step to t whose rates turn a joint too far to count turns; None where they do not."""
    far = before.turning.far(formulation.system, t)
    return None if far is None else untold(formulation, before, t, far)


def is_closed(formulation: FullFormulation, position: Array, projected: ProjectedState) -> bool:
    """Return whether |C| at `position`, as a projection has left it, counts as closed; NaN does not."""
    limit = THRESHOLDS.open_limit if projected.failures else THRESHOLDS.lost_limit
    return bool(np.all(position <= limit * formulation.system.row_scale))


def left_open_at(formulation: FullFormulation, t: float, position: Array, projected: ProjectedState) -> SimulationError:
    """Return the error for the joint that a projection has left open most."""
    system, row = formulation.system, int(np.argmax(position / formulation.system.row_scale))
    if not np.isfinite(position[row]):
        return not_finite(t)
    where, method = system.row_owner(row), formulation.settings.projection
    passes, failed = projected.position_iterations, projected.failures > 0
    return left_open(t, where, position[row], passes, projection=method, failed=failed)


def _check_by_halves(formulation: FullFormulation, stepper: Stepper, before: Point, t: float, y: Array) -> None:
    """Raise SimulationError where a step near a singular pose and two half steps reach different velocities. The step
    may have left its branch of the motion, with velocities of another one."""
    h, half = 0.5 * (t - before.t), before
    for time in (before.t + h, t):
        step = attempted(stepper, formulation, half, time - half.t)
        closed, _ = formulation.project_copy(time, formulation.lead(time, step.y_new))
        turned = counted(formulation, stepper, half, time, step, *formulation.split(closed)[:2])
        half = point_at(formulation, closed, *turned)
    v = formulation.split(y)[1]
    off = formulation.change(v, formulation.split(half.y)[1])
    if not off <= THRESHOLDS.branch_change:
        raise unresolved(t, off)


def first_point(formulation: FullFormulation, state: State, tally: Tally) -> Point:
    """Return the start as a point, with the turns of the state."""
    tally.count_evaluations(1)
    system, drive = formulation.system, drive_at(formulation.system, state.t)
    coordinate, speed = coordinates(system, state.q, state.v)
    turning = Turning(state.t, coordinate + 2.0 * np.pi * state.turns, speed, drive.value)
    violations = formulation.violations(state.t, state.q, state.v, turning.coordinate)
    tally.watch(*violations, _joint_rows(system), state.t)
    formulation.check_regular(state.t, state.q)
    formulation.arrive(state.q)
    layout = formulation.layout
    followed = turning.coordinate[: layout.size_of("followed")]
    y = layout.vector_of(state.layout.common_blocks(state.y, layout) | {"followed": followed})
    if formulation.balance is not None:
        formulation.balance.begin(formulation, state.t, y)
    accelerations = formulation.accelerations(state.t, y, turning.coordinate)
    return Point(state.t, y, accelerations, coordinate, turning)


def _joint_rows(system: System) -> slice:
    """Return the slice of the joints' rows in C."""
    return slice(system.bodies, system.bodies + system.joints.size)
