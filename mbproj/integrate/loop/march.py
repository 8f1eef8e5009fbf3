"""The time loop in NumPy, by explicit steps: step, project, check, record; with fixed steps, or by error control. Steps
end at the breaks of a run."""

from __future__ import annotations

from collections.abc import Iterator

from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.observe.samples import Sample
from mbproj.errors import SimulationError
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.loop.error_control import ErrorControl
from mbproj.integrate.loop.run import Run
from mbproj.integrate.loop.step_end import first_point
from mbproj.integrate.point import Point, attempted
from mbproj.integrate.reporting.marks import Mark, Marks, resuming
from mbproj.integrate.reporting.tally import Tally


def march(formulation: FullFormulation, state: State, tally: Tally, marks: Marks | None = None) -> Iterator[Sample]:
    """Yield samples from the start, or from a mark on. Raises SimulationError where the run cannot continue."""
    marks, leg = marks or Marks(), Leg.whole(formulation.system, formulation.settings, state.t)
    run = Run(formulation, leg, tally, marks)
    steps = ErrorControl(run) if leg.step is None else FixedSteps(run)
    try:
        if marks.resumed:
            yield from steps.resumed(marks.resumed)
        else:
            yield from steps.samples(first_point(formulation, state, tally))
    except SimulationError as failure:
        why = run.why(failure)
        if why is failure:
            raise
        raise why from failure


class FixedSteps:
    """One run with steps of one size. The time of step k is t0 + k h, so that it does not drift. The last step may be
    shorter, and a step with a break in it is split."""

    def __init__(self, run: Run) -> None:
        self.run = run

    def samples(self, point: Point) -> Iterator[Sample]:
        """Yield samples from a point at the start to the end."""
        run = self.run
        assert run.leg.step is not None
        yield point.sample(run.exact, run.leg.step, run.tally)
        yield from self.steps(1, run.cross_break(point) if run.breaks.passed else point)

    def resumed(self, mark: Mark) -> Iterator[Sample]:
        """Yield samples from a mark on. Raises InputError where it is not of this scene."""
        with resuming():
            point, first = self.run.resume(mark), int(mark["grid"])
        yield from self.steps(first, point)

    def steps(self, first: int, point: Point) -> Iterator[Sample]:
        """Yield the samples of step number `first` and all that follow."""
        run = self.run
        steps, every, h = run.leg.count, run.leg.every, run.leg.step
        assert h is not None
        for k in range(first, steps + 1):
            grid = run.end if k == steps else run.start + k * h
            run.mark(point, grid=k)
            run.shaped = k == steps
            while point.t != grid:
                t = run.breaks.next if run.breaks.cuts(grid) else grid
                run.tally.count_evaluations(run.stepper.attempt_cost)
                step = attempted(run.stepper, run.inside, point, t - point.t, watched=True)
                point = run.accept(point, t, step)
                if t == grid and (k % every == 0 or k == steps):
                    yield point.sample(run.exact, step.h, run.tally)
                if run.breaks.is_at(t) and t < run.end:
                    point = run.cross_break(point)
