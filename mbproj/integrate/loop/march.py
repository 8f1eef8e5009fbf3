"""The time loop in NumPy: step, project, check, record; with fixed steps, or by error control. Steps end at the breaks
of a run."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.observe.samples import Sample
from mbproj.errors import SimulationError
from mbproj.integrate.events.crossing import Crossing
from mbproj.integrate.events.law_switches import LawSwitches, switches_of
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.loop.carried import attempted
from mbproj.integrate.loop.error_control import ErrorControl
from mbproj.integrate.loop.passes import Passes
from mbproj.integrate.loop.pauses import Pauses
from mbproj.integrate.loop.run import Run
from mbproj.integrate.loop.state_events import StateEvents
from mbproj.integrate.loop.step_end import first_point
from mbproj.integrate.point import Point
from mbproj.integrate.reporting.failures import halved_in_vain
from mbproj.integrate.reporting.marks import Mark, Marks, resuming
from mbproj.integrate.reporting.tally import Tally
from mbproj.integrate.steppers.runge_kutta import Step
from mbproj.integrate.steppers.stages import StagesUnsolved
from mbproj.thresholds import THRESHOLDS


def march(
    formulation: FullFormulation,
    state: State,
    tally: Tally,
    marks: Marks | None = None,
    pauses: Pauses | None = None,
) -> Iterator[Sample]:
    """Yield samples from the start, or from a mark on. With error control `pauses` may end it. Raises SimulationError
    where the run cannot go on."""
    marks, leg = marks or Marks(), Leg.whole(formulation.system, formulation.settings, state.t)
    leg = leg if pauses is None or pauses.sampled else leg.without_samples
    run = Run(formulation, leg, tally, marks, pauses)
    switches = switches_of(formulation.system)
    if leg.step is None:
        assert formulation.settings.tolerance is not None
        control = ErrorControl(run, formulation.settings.tolerance, switches)
        begin, go_on = control.samples, control.resumed
    else:
        fixed = FixedSteps(run, switches)
        begin, go_on = fixed.samples, fixed.resumed
    try:
        yield from go_on(marks.resumed) if marks.resumed else begin(first_point(formulation, state, tally))
    except SimulationError as failure:
        why = run.why(failure)
        if why is failure:
            raise
        raise why from failure


class FixedSteps:
    """Scratch of a run with steps of one size. The time of step k is t0 + k h, so that it does not drift. The last step
    may be shorter, and a step with a break or a state event in it is split. `passes` records switches at which no step
    ends."""

    def __init__(self, run: Run, switches: LawSwitches | None) -> None:
        self.run = run
        self.passes = None if switches is None else Passes(run, switches)
        self.events = None if switches is None else StateEvents(run, switches, passes=self.passes)

    def samples(self, point: Point) -> Iterator[Sample]:
        """Yield samples from a point at the start to the end."""
        run = self.run
        assert run.leg.step is not None
        yield point.sample(run.exact, run.leg.step, run.tally)
        yield from self.steps(1, self.cross_break(point) if run.breaks.passed or self.events is not None else point)

    def resumed(self, mark: Mark) -> Iterator[Sample]:
        """Yield samples from a mark on. Raises InputError where it is not of this scene."""
        with resuming():
            point, first = self.run.resume(mark), int(mark["grid"])
            if self.passes is not None:
                self.passes.restore(mark["told"])
            if self.events is not None:
                self.events.restore(mark["events"])
        yield from self.steps(first, point)

    def _before_step(self, k: int) -> Mark:
        """Return what step number k depends on beside the point, for its mark."""
        told = {} if self.passes is None else {"told": self.passes.save()}
        return {"grid": k, **told, **({} if self.events is None else {"events": self.events.save()})}

    def cross_break(self, point: Point) -> Point:
        """Return the point at a break as it is evaluated from the other side."""
        h = self.run.leg.step
        assert h is not None
        return self.run.cross_break(point) if self.events is None else self.events.cross_break(point, h)

    def steps(self, first: int, point: Point) -> Iterator[Sample]:
        """Yield the samples of step number `first` and all that follow."""
        run = self.run
        steps, every, h = run.leg.count, run.leg.every, run.leg.step
        assert h is not None
        for k in range(first, steps + 1):
            grid = run.end if k == steps else run.start + k * h
            run.mark(point, partial(self._before_step, k))
            run.shaped = k == steps
            while point.t != grid:
                t = run.breaks.next if run.breaks.cuts(grid) else grid
                point, made = self.through(point, t)
                if t == grid and (k % every == 0 or k == steps):
                    yield point.sample(run.exact, made, run.tally)
                if run.breaks.is_at(t) and t < run.end:
                    point = self.cross_break(point)

    def attempt(self, point: Point, t: float) -> tuple[Step, float, Crossing | None]:
        """Return a step from a point to t, or to the first event before t, and its end. No step can end at a point's
        own time: there the event is `at_once`."""
        step = self._stages(point, t - point.t)
        crossing = None if self.events is None else self.events.first(step, estimated=False)
        if self.events is None or crossing is None or crossing.at_once:
            return step, t, crossing
        whole, end, at = step.h, t, point.t + crossing.theta * step.h
        for _ in range(THRESHOLDS.most_polishing if end - at > self.events.slack(end, whole) else 0):
            self.run.inside.policy.begin()
            step, t = self._stages(point, at - point.t), at
            again = self.events.next_try(crossing, step, at, whole, end)
            if again is None:
                break
            at = again
        return step, t, crossing

    def _stages(self, point: Point, h: float) -> Step:
        run = self.run
        step = attempted(run.stepper, run.inside, point, h, watched=True)
        run.tally.count_evaluations(run.stepper.attempt_cost + step.evaluations)
        return step

    def through(self, point: Point, end: float) -> tuple[Point, float]:
        """Make the steps from a point to `end`. Return the point there, and the size of the last step.

        A step whose equations are not solved is made in halves, and these in halves again. The parts are numbered as
        the nodes of a binary tree: 1 is the whole, 2n and 2n + 1 are the halves of n."""
        run, start, part = self.run, point.t, 1
        while True:
            count = 1 << (part.bit_length() - 1)
            goal = end if part + 1 == 2 * count else start + (part - count + 1) / count * (end - start)
            try:
                step, t, crossing = self.attempt(point, goal)
            except StagesUnsolved as unsolved:
                h = goal - point.t
                run.tally.count_evaluations(run.stepper.attempt_cost + unsolved.evaluations)
                if count >= 1 << THRESHOLDS.most_halvings or 0.5 * h < THRESHOLDS.fewest_grains * run.grain(point.t):
                    raise halved_in_vain(unsolved, h) from unsolved
                run.tally.halve(unsolved.where or "", point.t)
                run.inside.policy.begin()
                part *= 2
                continue
            if crossing is None or not crossing.at_once:
                point = run.accept(point, t, step)
                if self.passes is not None:
                    self.passes.watch(point)
            if crossing is not None:
                assert self.events is not None
                point = self.events.cross(point, crossing, step.h)
            elif self.events is not None:
                self.events.tell(point)
            if point.t != goal:
                continue
            while part > 1 and part % 2:
                part //= 2
            if part == 1:
                return point, step.h
            part += 1
