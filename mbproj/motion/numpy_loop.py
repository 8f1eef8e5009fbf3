"""The paper's time loop in NumPy: explicit steps, fixed or controlled, with the paper's projections.

    step  = stages of the tableau       q'' from Eq. 14, or Eqs. 80-81, at each: `formulations/full.py`
    q     = correct_position(q)         Δq of Eqs. 39, 44, 52, 60, 65 or 73, iterated until C = 0: `projection.py`
    v     = correct_velocity(q, v)      Δq' of the same formula, in one pass (Eq. 46)
    point = q'' and λ at (q, v)         after checks: joints closed, branch kept, turns counted
    h     = size of the next step       the given one, or by the error of this one; steps end at breaks

It draws the paper's figures, and runs plug-ins and installations without a compiler. Contacts, implicit steps,
kinematic steps, events of the state, and rows of energy and momentum are the kernel's.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np

from mbproj.base.arrays import Array, Integers, may_overflow
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import SimulationError
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State, coordinates
from mbproj.equations.curve_checks import off_path, overlapping
from mbproj.equations.forces import action_values
from mbproj.equations.kinematics import pose_of
from mbproj.equations.motions import drive_at
from mbproj.equations.rank.row_policy import in_lengths
from mbproj.equations.samples import Sample
from mbproj.equations.turning import Turning, UncertainTurn, near, turns_of
from mbproj.model.system import System
from mbproj.motion.failures import (
    LostStep,
    TurnsUntold,
    branches_near,
    left_open,
    not_finite,
    of_a_rope,
    off_rope,
    other_branch,
    overlap,
    step_vanished,
    unresolved,
)
from mbproj.motion.formulations.full import Accelerations, FullFormulation
from mbproj.motion.interruption import look
from mbproj.motion.marks import Mark, Marks, restore_tally, resuming, saved_tally
from mbproj.motion.projection import ProjectedState
from mbproj.motion.report import Tally
from mbproj.motion.steppers.runge_kutta import ExplicitRungeKutta, RightHandSide, Step
from mbproj.motion.steppers.tableau import load_tableau
from mbproj.motion.time_events import BreakCursor, Leg

# --- A point between two steps ----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Point:
    """An accepted y at time t, with the `accelerations`, λ and powers there, by its formulation.

    `coordinate` are the joints' coordinates without turns; `turning` are those with turns, and the data from which the
    next step counts them."""

    formulation: FullFormulation
    t: float
    y: Array
    accelerations: Accelerations
    coordinate: Array
    turning: Turning

    @classmethod
    def at(cls, formulation: FullFormulation, y: Array, coordinate: Array, turning: Turning) -> Point:
        """Return the point at y at the time of `turning`."""
        accelerations = formulation.accelerations(turning.t, y, turning.coordinate)
        return cls(formulation, turning.t, y, accelerations, coordinate, turning)

    @cached_property
    def slope(self) -> Array:
        """y'."""
        return self.formulation.slope(self.t, self.y, self.accelerations)

    @property
    def state(self) -> State:
        """The state at this point."""
        turns: Integers = turns_of(self.formulation.system, self.turning.coordinate, self.coordinate)
        return self.formulation.state(self.t, self.y, turns)

    def sample(self, step_size: float, tally: Tally) -> Sample:
        """Return this point as a sample."""
        acceleration, multipliers, power, _ = self.accelerations
        work = self.y[self.formulation.layout["quadratures"]] if len(power) else np.zeros(2)
        rows = multipliers[self.formulation.system.bodies :]
        return Sample(self.state, acceleration, rows, step_size, work, tally.counters())

    def save(self) -> dict[str, Any]:
        """Return this point as plain data."""
        accelerations, turning = self.accelerations, self.turning
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
    def restore(cls, formulation: FullFormulation, saved: Mapping[str, Any]) -> Point:
        """Return the point that was saved. Raises ValueError for that of another system."""
        system, layout = formulation.system, formulation.layout
        joint_coordinates = system.coordinates.size
        sizes = {
            "y": layout.size,
            "acceleration": layout.size_of("velocities"),
            "multipliers": system.constraints,
            "power": layout.size_of("quadratures"),
            "coordinate": joint_coordinates,
            "turned": joint_coordinates,
            "speed": joint_coordinates,
            "prescribed": system.driven,
        }
        for name, size in sizes.items():
            if saved[name].shape != (size,) or not np.isfinite(saved[name]).all():
                raise ValueError(f"an array of {size} numbers is not there")
        t = float(saved["t"])
        accelerations = Accelerations(
            saved["acceleration"], saved["multipliers"], saved["power"], float(saved["nearness"])
        )
        turning = Turning(t, saved["turned"], saved["speed"], saved["prescribed"])
        return cls(formulation, t, saved["y"], accelerations, saved["coordinate"], turning)


def first_point(formulation: FullFormulation, state: State, tally: Tally) -> Point:
    """Return the start as a point, with the turns of the state."""
    tally.count_evaluations(1)
    system, layout, drive = formulation.system, formulation.layout, drive_at(formulation.system, state.t)
    coordinate, speed = coordinates(system, state.q, state.v)
    turning = Turning(state.t, coordinate + 2.0 * np.pi * state.turns, speed, drive.value)
    tally.watch(*formulation.violations(state.t, state.q, state.v, turning.coordinate), _joint_rows(system), state.t)
    formulation.check_regular(state.t, state.q)
    formulation.arrive(state.q)
    followed = turning.coordinate[: layout.size_of("followed")]
    y = layout.vector_of(state.layout.common_blocks(state.y, layout) | {"followed": followed})
    return Point.at(formulation, y, coordinate, turning)


def _joint_rows(system: System) -> slice:
    """Return the slice of the joints' rows in C."""
    return slice(system.bodies, system.bodies + system.joints.size)


# --- The loop ---------------------------------------------------------------------------------------------------------


def march(formulation: FullFormulation, state: State, tally: Tally, marks: Marks | None = None) -> Iterator[Sample]:
    """Yield samples from the start, or from a mark on. Raises SimulationError where the run cannot continue."""
    loop = _Loop(formulation, state, tally, marks or Marks())
    try:
        yield from loop.controlled() if loop.leg.step is None else loop.fixed()
    except SimulationError as failure:
        why = failure
        if loop.newest is not None:
            why = of_a_rope(formulation.system, loop.newest.state, loop.leg.step or 0.0, failure)
        if why is failure:
            raise
        raise why from failure


class _Loop:
    """One run. `exact` evaluates functions of time at the time itself, `inside` within the window of the current
    step."""

    def __init__(self, formulation: FullFormulation, state: State, tally: Tally, marks: Marks) -> None:
        self.leg = Leg.whole(formulation.system, formulation.settings, state.t)
        self.breaks = BreakCursor(self.leg.breaks, self.leg.start, self.leg.interval)
        self.stepper = ExplicitRungeKutta(load_tableau(formulation.settings.integrator))
        self.exact, self.inside = formulation, formulation.seen_within(self.breaks.window)
        self.state, self.tally = state, tally
        #: Whether the run's end has influenced a step: a longer run might make another one.
        self.shaped = False
        self.newest: Point | None = None
        self._marks, self._mark = marks, marks.resumed
        marks.newest = lambda: self._mark

    def fixed(self) -> Iterator[Sample]:
        """Yield the samples of steps of one size. The time of step k is t0 + k h, so that it does not drift. The last
        step may be shorter, and a step with a break in it is split."""
        leg, h = self.leg, self.leg.step
        assert h is not None
        if self._marks.resumed:
            with resuming():
                point, first = self._resume(self._marks.resumed), int(self._marks.resumed["grid"])
        else:
            point, first = first_point(self.exact, self.state, self.tally), 1
            yield point.sample(h, self.tally)
            if self.breaks.passed:
                point = self._cross_break(point)
        for k in range(first, leg.count + 1):
            grid = leg.end if k == leg.count else leg.start + k * h
            self._keep_mark(point, grid=k)
            self.shaped = k == leg.count
            while point.t != grid:
                t = self.breaks.next if self.breaks.cuts(grid) else grid
                self.tally.count_evaluations(self.stepper.attempt_cost)
                step = attempted(self.stepper, self.inside.watched_derivative, point, t - point.t)
                point = self._accept(point, t, step)
                if t == grid and (k % leg.every == 0 or k == leg.count):
                    yield point.sample(step.h, self.tally)
                if self.breaks.is_at(t) and t < leg.end:
                    point = self._cross_break(point)

    def controlled(self) -> Iterator[Sample]:
        """Yield the samples of steps by error control. Samples within a step come from the continuous extension."""
        leg, tally, times, lost = self.leg, self.tally, self.leg.times, None
        assert times is not None
        forgetful = StepSizeController(self.stepper.error_order)  # without memory, for a first step
        if mark := self._marks.resumed:
            with resuming():
                point, h = self._resume(mark), float(mark["h"])
                control = replace(
                    forgetful, previous_error=float(mark["previous_error"]), rejected=bool(mark["rejected"])
                )
        else:
            point, control = first_point(self.exact, self.state, tally), forgetful
            h = self._first_step(point)
            yield point.sample(h, tally)
            if self.breaks.passed:
                point = self._cross_break(point)
                h = self._first_step(point)
        done = bisect_right(times, point.t)
        while done < len(times):
            if not h >= THRESHOLDS.fewest_grains * self._grain(point.t):
                raise lost or step_vanished(point.t)
            self._keep_mark(point, h=h, previous_error=control.previous_error, rejected=control.rejected)
            h, t = self._target(h, point.t)
            try:
                step, error = self._attempt(point, h, t)
            except SimulationError as failure:  # a function may have no value where a step that is too large leads
                step, error, lost = None, np.nan, failure
            if step is None or not error <= 1.0:
                lost = lost if step is None else None
                tally.rejected_steps += 1
                h, control = control.after_rejected(error, h)
                continue
            try:
                before, point = point, self._accept(point, t, step)
            except TurnsUntold as untold:
                tally.reject_accepted()
                h = untold.step
                continue
            last = bisect_left(times, t, done)
            if last > done:
                yield from self._in_between(before, point, step, times[done:last])
            if last < len(times) and times[last] == t:
                yield point.sample(step.h, tally)
                last += 1
            done = last
            h, control = control.after_accepted(error, step.h)
            if self.breaks.is_at(t) and t < leg.end:
                point, control = self._cross_break(point), forgetful
                h = self._first_step(point)

    def _attempt(self, point: Point, h: float, t: float) -> tuple[Step, float]:
        """Return a step from a point over h to t, and the norm of its error. Raises SimulationError where its equations
        have no solution, or overflow."""
        inside, stepper = self.inside, self.stepper
        inside.policy.begin()
        self.tally.count_evaluations(stepper.attempt_cost + stepper.error_cost)
        with may_overflow():
            step = attempted(stepper, inside.watched_derivative, point, h)
            step, estimates = stepper.error(inside.watched_derivative, t, step)
            error = error_norm(estimates, step.y, step.y_new, self._tolerance, inside.layout.scale)
        if not np.isfinite(error):
            raise not_finite(t)
        return step, error

    def _accept(self, before: Point, t: float, step: Step) -> Point:
        """Return the point after a step: projected, checked, with turns, and evaluated; at a break at the time itself,
        as it is recorded. Raises SimulationError where the run cannot go on from it."""
        look()
        self.newest = before
        inside, y = self.inside, self.inside.lead(t, step.y_new)
        if not np.all(np.isfinite(y)):
            raise not_finite(t)
        with may_overflow():
            y, coordinate, turning = self._projected(before, t, step, y)
            if inside.arrive(inside.split(y)[0]) < THRESHOLDS.close_to_singular:
                self._check_by_halves(before, t, y)
            point = Point.at(self.exact if self.breaks.is_at(t) else inside, y, coordinate, turning)
            inside.policy.keep(point.accelerations.multipliers)
        if not np.all(np.isfinite(point.slope)):
            raise not_finite(t)
        self.newest = point
        return point

    def _projected(self, before: Point, t: float, step: Step, y: Array) -> tuple[Array, Array, Turning]:
        """Return the projected y after a step, and the joints' coordinates there, without turns and with."""
        inside, tally, system = self.inside, self.tally, self.inside.system
        tally.steps += 1
        tally.count_evaluations(1)
        projected = inside.project(tally.steps, t, y)
        tally.count_projection(projected)
        try:
            self._check_branch(t, t - before.t, y, projected)
        except SimulationError as error:  # a step too long to count turns may come to any branch, crossing or not
            raise _too_far(before, t) or error from None
        expected = inside.split(y)[2]
        position, velocity = inside.violations(t, projected.q, projected.v, expected)
        if not _is_closed(system, position, projected):
            raise _too_far(before, t) or _left_open(inside, t, position, projected)
        if (trouble := off_path(system, pose_of(projected.q))) is not None:
            raise off_rope(t, system, *trouble)
        if (joint := overlapping(system, pose_of(projected.q))) is not None:
            raise overlap(t, joint)
        coordinate, turning = self._counted(before, t, step, projected.q, projected.v)
        tally.watch(position, velocity, _joint_rows(system), t)
        closed = {"positions": projected.q, "velocities": projected.v, "followed": turning.coordinate[: len(expected)]}
        return inside.layout.changed(y, closed), coordinate, turning

    def _counted(self, before: Point, t: float, step: Step, q: Array, v: Array) -> tuple[Array, Turning]:
        """Return the joints' coordinates at (q, v) after a step from `before`, without turns and with. Raises
        TurnsUntold where the step is too long to count turns."""
        system, drive = self.inside.system, drive_at(self.inside.system, t)
        coordinate, speed = coordinates(system, q, v)
        turned, slip = before.turning.count(system, coordinate, before.turning.by_rates(t, speed), drive)
        if slip is not None:
            turned, slip = before.turning.count(system, coordinate, self._by_stages(before, step), drive)
        if slip is not None:
            raise _untold(before, t, slip)
        return coordinate, Turning(t, turned, speed, drive.value)

    def _by_stages(self, before: Point, step: Step) -> Array:
        """Return the change of the joints' coordinates in a step by the rates of its stages, (nc,)."""
        followed = self.inside.split(step.y_new)[2]
        if len(followed):
            return followed - before.turning.coordinate
        change = np.zeros_like(before.coordinate)
        for weight, y in self.stepper.quadrature(step):
            change += step.h * weight * coordinates(self.inside.system, *self.inside.split(y)[:2])[1]
        return change

    def _check_branch(self, t: float, h: float, y: Array, projected: ProjectedState) -> None:
        """Raise SimulationError where the step has lost the motion. Near a pose at which C_q loses its rank, branches
        of the motion may cross at an angle. The projection may then change the velocities of y by more than a step of
        size h can err, or leave rows without a gradient open: both count as lost."""
        system, v, nearest = self.inside.system, self.inside.split(y)[1], self.inside.policy.nearest
        part = _change(system, v, projected.v)
        moved = float(np.linalg.norm(in_lengths(system, projected.v - v))) * h
        if nearest < THRESHOLDS.near_singular and part > THRESHOLDS.branch_change and moved > THRESHOLDS.at_rest:
            raise other_branch(t, part)
        if part > THRESHOLDS.lost_velocity and moved > THRESHOLDS.lost_way and not system.driven:
            raise LostStep(t, part)  # driven coordinates cannot lose their motions
        if projected.left_open > THRESHOLDS.least_violation or (
            projected.failures and nearest < THRESHOLDS.near_singular
        ):
            raise branches_near(t)

    def _check_by_halves(self, before: Point, t: float, y: Array) -> None:
        """Raise SimulationError where a step near a singular pose and two half steps reach different velocities. The
        step may have left its branch of the motion, with velocities of another one."""
        inside, h, half = self.inside, 0.5 * (t - before.t), before
        for time in (before.t + h, t):
            step = attempted(self.stepper, inside.derivative, half, time - half.t)
            closed, _ = inside.project_between(time, inside.lead(time, step.y_new))
            turned = self._counted(half, time, step, *inside.split(closed)[:2])
            half = Point.at(inside, closed, *turned)
        off = _change(inside.system, inside.split(y)[1], inside.split(half.y)[1])
        if not off <= THRESHOLDS.branch_change:
            raise unresolved(t, off)

    def _in_between(self, before: Point, after: Point, step: Step, times: Sequence[float]) -> Iterator[Sample]:
        """Yield samples inside a step: values of the extension, projected. The integration goes on from values that are
        not projected."""
        self.tally.count_evaluations(self.stepper.extend_cost + len(times))
        inside, system = self.inside, self.inside.system
        extension = self.stepper.extend(inside.derivative, step)
        for t in times:
            y, projected = inside.project_between(t, inside.lead(t, extension.at((t - step.t) / step.h)))
            q, v, expected = inside.split(y)
            position, velocity = inside.violations(t, q, v, expected)
            if not _is_closed(system, position, projected):
                raise _left_open(inside, t, position, projected)
            self.tally.watch(position, velocity, _joint_rows(system), t)
            coordinate, speed = coordinates(system, q, v)
            if not len(expected):
                expected = before.turning.between(system, after.turning, t, drive_at(system, t))
            turning = Turning(t, near(system, coordinate, expected), speed, after.turning.prescribed)
            yield Point.at(inside, y, coordinate, turning).sample(step.h, self.tally)

    def _cross_break(self, point: Point) -> Point:
        """Return the point at a break after the controllers' actions there, as it is evaluated from the other side.
        Raises SimulationError that names a controller whose value is not finite."""
        self._pass_break(point.t)
        system, layout, y = self.inside.system, self.inside.layout, point.y
        for action in self.breaks.take_actions():
            sets, states = system.actions.sets(action), y[layout["states"]].copy()
            instant = self.inside.instant(point.t, y, point.turning.coordinate)
            states[system.actions.state[sets]] = action_values(instant, action)
            y = layout.changed(y, {"states": states})
        self.tally.count_evaluations(1)
        point = Point.at(self.inside, y, point.coordinate, point.turning)
        self.inside.policy.keep(point.accelerations.multipliers)
        return point

    def _pass_break(self, t: float) -> None:
        """Pass a break: functions of time are evaluated from its other side from here on."""
        self.breaks.pass_break(t)
        self.inside = self.exact.seen_within(self.breaks.window)

    def _keep_mark(self, point: Point, **rest: Any) -> None:
        """Keep the mark before a step, from which a longer run can continue, unless the run's end has influenced the
        way here. `rest` is the caller's part of it."""
        if self._marks.wanted and not self.shaped:
            policy = self.exact.policy.save()
            self._mark = {**point.save(), **saved_tally(self.tally), "policy": policy, **rest}

    def _resume(self, mark: Mark) -> Point:
        """Return the point from which a run continues. Raises ValueError for a mark of another system."""
        self._pass_break(float(mark["t"]))
        self.breaks.take_actions()  # these were done before the mark
        restore_tally(self.tally, mark)
        self.exact.policy.restore(mark["policy"])
        return Point.restore(self.inside, mark)

    @property
    def _tolerance(self) -> float:
        return self.exact.settings.tolerance or 0.0

    def _grain(self, t: float) -> float:
        """Return the resolution of times near t, and near the next sample."""
        return float(np.finfo(float).eps * max(abs(t), self.leg.interval))

    def _way_left(self, t: float) -> tuple[float, bool]:
        """Return the time from t to where steps must end, and whether that is the run's end."""
        return min(self.breaks.next, self.leg.end) - t, not self.breaks.next < self.leg.end

    def _target(self, h: float, t: float) -> tuple[float, float]:
        """Return the size of the next step from t, at most h, and its end. Where one more step would be tiny, it is
        half of the rest."""
        left, is_last = self._way_left(t)
        self.shaped = self.shaped or (is_last and 2.0 * h > left)
        if h >= left:
            return left, min(self.breaks.next, self.leg.end)
        size = 0.5 * left if 2.0 * h > left > 1.01 * h else h
        return size, t + size

    def _first_step(self, point: Point) -> float:
        """Return an initial step size at a point."""
        self.tally.count_evaluations(1)
        left, is_last = self._way_left(point.t)
        f, scale = point.formulation.watched_derivative, self.exact.layout.scale
        h, limited = first_step(f, self.stepper.order, point, self._tolerance, scale, left)
        self.shaped = self.shaped or (limited and is_last)
        return max(h, THRESHOLDS.fewest_grains * self._grain(point.t))  # round-off of y may require a shorter one


def attempted(stepper: ExplicitRungeKutta, f: RightHandSide, point: Point, h: float) -> Step:
    """Return a step of size h from a point by y' = f(t, y)."""
    return stepper.attempt(f, point.t, point.y, h, point.slope)


def _change(system: System, v: Array, to: Array) -> float:
    """Return the difference of two velocities divided by the first, with lengths in units of the mechanism's."""
    size = np.linalg.norm(in_lengths(system, v))
    return float(np.linalg.norm(in_lengths(system, to - v)) / max(size, np.finfo(float).tiny))


def _is_closed(system: System, position: Array, projected: ProjectedState) -> bool:
    """Return whether |C| at `position`, as a projection has left it, counts as closed; NaN does not."""
    limit = THRESHOLDS.open_limit if projected.failures else THRESHOLDS.lost_limit
    return bool(np.all(position <= limit * system.row_scale))


def _left_open(formulation: FullFormulation, t: float, position: Array, projected: ProjectedState) -> SimulationError:
    """Return the error for the joint that a projection has left open most."""
    system, row = formulation.system, int(np.argmax(position / formulation.system.row_scale))
    if not np.isfinite(position[row]):
        return not_finite(t)
    method, failed = formulation.settings.projection, projected.failures > 0
    where, passes = system.row_owner(row), projected.position_iterations
    return left_open(t, where, position[row], passes, projection=method, failed=failed)


def _too_far(before: Point, t: float) -> SimulationError | None:
    """Return the error for a step to t whose rates turn a joint too far to count turns; None where they do not."""
    far = before.turning.far(before.formulation.system, t)
    return None if far is None else _untold(before, t, far)


def _untold(before: Point, t: float, slip: UncertainTurn) -> TurnsUntold:
    system = before.formulation.system
    name, teeth = system.names.coordinates[slip.coordinate], system.couplings.size > 0
    return TurnsUntold(t, name, slip.turned, slip.off, (t - before.t) * slip.shorter, teeth=teeth)


# --- The size of a step (Hairer, Nørsett & Wanner 1993, II.4) ---------------------------------------------------------


def error_norm(estimates: Array, y: Array, y_new: Array, tolerance: float, scale: Array) -> float:
    """Return the root mean square of error / (tolerance × (scale + max(|y|, |y_new|))): 1 is just acceptable.

    Of two estimates (DOP853) the first is of higher order. They are combined as in the authors' code: |e5|² /
    sqrt(|e5|² + 0.01 |e3|²).
    """
    weighted = estimates / (tolerance * (scale + np.maximum(np.abs(y), np.abs(y_new))))
    norms = np.sqrt(np.mean(weighted * weighted, axis=1))
    if len(norms) == 1 or norms[0] == 0.0:
        return float(norms[0])
    return float(norms[0] ** 2 / np.hypot(norms[0], 0.1 * norms[1]))


@dataclass(frozen=True)
class StepSizeController:
    """PI controller: h_new = 0.9 h err^(-a) err_old^b with b = 0.2/k, a = 1/k - 0.75 b, k the estimate's order + 1.

    For k = 5 these are the constants of DOPRI5.
    """

    error_order: int
    previous_error: float = THRESHOLDS.least_error_before
    rejected: bool = False

    def after_accepted(self, error: float, h: float) -> tuple[float, StepSizeController]:
        """Return the size of the next step, and the controller for it."""
        k = self.error_order + 1
        integral = 0.2 / k
        reached = max(error, THRESHOLDS.least_error)
        factor = THRESHOLDS.safety * reached ** (0.75 * integral - 1.0 / k) * self.previous_error**integral
        largest = 1.0 if self.rejected else THRESHOLDS.largest_change
        factor = min(max(factor, THRESHOLDS.smallest_change), largest)
        return h * factor, StepSizeController(self.error_order, max(error, THRESHOLDS.least_error_before))

    def after_rejected(self, error: float, h: float) -> tuple[float, StepSizeController]:
        """Return the size to try again with, and the controller for it. An error that is not finite shrinks the step
        most."""
        k = self.error_order + 1
        factor = THRESHOLDS.safety * error ** (0.15 / k - 1.0 / k) if np.isfinite(error) else 0.0
        return h * max(factor, THRESHOLDS.smallest_change), StepSizeController(
            self.error_order, self.previous_error, rejected=True
        )


def _bend(
    f: RightHandSide, t: float, y: Array, slope: Array, h: float, norm: Callable[[Array], float]
) -> tuple[float, float]:
    """Return h, reduced where f overflows, and the norm of the derivative of f along f, by a difference over this h."""
    while True:
        try:
            with may_overflow():
                bend = norm(f(t + h, y + h * slope) - slope) / h
        except SimulationError:
            if h < np.finfo(float).tiny:
                raise
            bend = np.inf
        if np.isfinite(bend) or h < np.finfo(float).tiny:
            return h, bend
        h *= 0.1


def first_step(
    f: RightHandSide, order: int, point: Point, tolerance: float, scale: Array, longest: float
) -> tuple[float, bool]:
    """Return a first step size from f and an estimate of f', at most `longest` (Hairer's hinit), and whether `longest`
    has limited it.

    The trial step for f' is shortened while f overflows, or has no value, at its end. Raises SimulationError where that
    does not help."""
    y, slope = point.y, point.slope
    weight = tolerance * (scale + np.abs(y))

    def norm(vector: Array) -> float:
        return float(np.sqrt(np.mean((vector / weight) ** 2)))

    size, speed = norm(y), norm(slope)
    wanted = 1e-6 if min(size, speed) <= 1e-5 else 0.01 * size / speed
    h, bend = _bend(f, point.t, y, slope, min(wanted, longest), norm)
    steepest = max(speed, bend)
    trial = max(1e-6, h * 1e-3) if steepest <= 1e-15 else (0.01 / steepest) ** (1.0 / (order + 1))
    first = min(100.0 * h, trial)
    return float(min(first, longest)), wanted > longest or first > longest
