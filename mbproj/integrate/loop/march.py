"""The time loop: step, project, check, record; with a fixed step, or with the step that the error allows. Steps end at
the breaks of a run."""

from __future__ import annotations

from collections.abc import Iterator

from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.observe.samples import Sample
from mbproj.integrate.events.law_switches import switches_of
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.loop.error_control import ErrorControl
from mbproj.integrate.loop.passes import Passes
from mbproj.integrate.loop.run import Run
from mbproj.integrate.loop.step_end import first_point
from mbproj.integrate.outcome.tally import Tally
from mbproj.integrate.point import Point
from mbproj.scene.sampling import output_every, whole_steps


def march(formulation: FullFormulation, state: State, tally: Tally) -> Iterator[Sample]:
    """Samples from the start to the end of the duration. Raises SimulationError where the run cannot go on."""
    run, switches = Run(formulation, state.t, tally), switches_of(formulation.system.forces)
    start = first_point(formulation, state, tally)
    if formulation.settings.tolerance is not None:
        yield from ErrorControl(run, formulation.settings.tolerance, switches).samples(start)
    else:
        yield from fixed_steps(run, start, None if switches is None else Passes(run, switches))


def fixed_steps(run: Run, point: Point, passes: Passes | None) -> Iterator[Sample]:
    """Steps of one size; the time of step k is t0 + k h, so that it does not drift. The last step may be shorter, and
    one with a break in it is split. `passes` takes note of what they do not end at."""
    settings, start = run.exact.settings, point.t
    steps, every, h = whole_steps(settings), output_every(settings), settings.step
    assert h is not None
    yield point.sample(run.exact, h, run.tally)
    if passes is not None:
        passes.watch(point)
    point = run.cross_break(point) if run.breaks.passed else point
    for k in range(1, steps + 1):
        grid = run.end if k == steps else start + k * h
        while point.t != grid:
            t = run.breaks.next if run.breaks.cuts(grid) else grid
            step = run.stepper.attempt(run.inside.watched_derivative, point.t, point.y, t - point.t, point.slope)
            run.tally.count_evaluations(run.stepper.attempt_cost)
            point = run.accept(point, t, step)
            if passes is not None:
                passes.watch(point)
            if t == grid and (k % every == 0 or k == steps):
                yield point.sample(run.exact, step.h, run.tally)
            if run.breaks.is_at(t) and t < run.end:
                point = run.cross_break(point)
