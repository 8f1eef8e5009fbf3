"""One leg of a run with its contacts and frictions: from a state to a time, or to where it halts."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array, Flags
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.observe.samples import Samples, stack
from mbproj.integrate.automatic.march import Automatic
from mbproj.integrate.events.halts import Watched
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.loop.compiled_march import march as march_compiled
from mbproj.integrate.loop.march import march
from mbproj.integrate.loop.pauses import Pauses, Standing
from mbproj.integrate.loop.stop_watch import StopWatch
from mbproj.integrate.reporting.marks import Marks
from mbproj.integrate.reporting.tally import Tally
from mbproj.integrate.stiff.modes_at_a_step import FastModes
from mbproj.integrate.stops.inside import Inside
from mbproj.integrate.stops.variants import Variant
from mbproj.registry import is_implicit
from mbproj.scene.records import Settings
from mbproj.scene.sampling import SampleTimes
from mbproj.thresholds import THRESHOLDS


def samples_of(
    variant: Variant,
    state: State,
    settings: Settings,
    leg: Leg,
    tally: Tally,
    watched: Watched | None = None,
    marks: Marks | None = None,
    pauses: Pauses | None = None,
    inside: Inside | None = None,
) -> Iterator[Samples | None]:
    """The samples of a leg, as the variant has them, to where a pause ends it. Raises Halted where it has met something
    that is watched, and SimulationError."""
    choice = variant.choice
    if choice.compiled is not None:
        yield from march_compiled(choice.compiled, state, settings, tally, marks, pauses, leg, watched, inside)
        return
    formulation = FullFormulation.of(variant.system, state, settings, choice.redundant)
    watch = None if watched is None else StopWatch(formulation, watched)
    for sample in march(formulation, state, tally, marks, pauses, leg, watch):
        yield stack([sample])


def chosen(
    variant: Variant,
    state: State,
    settings: Settings,
    leg: Leg,
    tally: Tally,
    watched: Watched | None,
    marks: Marks,
    automatic: Automatic | None,
    inside: Inside | None = None,
) -> Iterator[Samples | None]:
    """The same by the methods that `automatic` chooses; by that of the settings on a single step to an event, where
    nothing is watched."""
    if automatic is None or (watched is None and inside is None):
        return samples_of(variant, state, settings, leg, tally, watched, marks, inside=inside)

    def by(method: str, own: Marks, counted: Tally, pauses: Pauses | None) -> Iterator[Samples | None]:
        is_trial = pauses is not None and not pauses.sampled
        meets = replace(inside, halts=True) if inside is not None and is_trial else inside
        of_method = replace(settings, integrator=method)
        return samples_of(variant, state, of_method, leg, counted, watched, own, pauses, meets)

    def modes(standing: Standing) -> FastModes:
        there = variant if inside is None else inside.variant(standing.mark["contacts"], standing.state())
        return FastModes(there.choice, there.system)

    return automatic.march(variant.system, modes, by, leg, tally, marks)


@dataclass(frozen=True, eq=False)
class Reached:
    """The end of one step: the state, and λ of the variant's rows (m,)."""

    state: State
    multipliers: Array


def one_step(variant: Variant, state: State, settings: Settings, whole: Leg, h: float, tally: Tally) -> Reached:
    """A single step of size h, tried. Raises SimulationError where there is none. Newton's method of an implicit step
    ends at the tolerance. It must end here as in the run, or the gap would not be that which was found; but for steps
    near round-off, which error control refuses."""
    leg = Leg(state.t, h, whole.interval, whole.breaks, step=h, count=1).after_actions(state.t)
    single = replace(settings, duration=h, step=h, tolerance=None)
    grain = float(np.finfo(float).eps) * max(abs(state.t), whole.interval)
    if whole.step is None and is_implicit(settings.integrator) and h > 4.0 * THRESHOLDS.fewest_grains * grain:
        leg = replace(leg, step=None, count=0, times=SampleTimes(state.t, state.t + h, state.t, h), first=h)
        single = replace(settings, duration=h)
    own = Tally()
    blocks = [block for block in samples_of(variant, state, single, leg, own) if block is not None]
    tally.count_evaluations(own.evaluations)
    return end_of(blocks[-1])


def end_of(samples: Samples) -> Reached:
    """The last of some samples."""
    return Reached(samples.state(-1), samples.multipliers[-1])


def only(samples: Samples, which: Flags) -> Samples:
    """Some of the samples."""
    if which.all():
        return samples
    press, rub = samples.press, samples.rub
    return replace(
        samples,
        **{name: getattr(samples, name)[which] for name in ("t", "y", "acceleration", "carried", "step_size", "work")},
        solved=lambda _: samples.multipliers[which],
        counters={name: values[which] for name, values in samples.counters.items()},
        press=None if press is None else lambda: press()[which],
        rub=None if rub is None else lambda: (rub()[0][which], rub()[1][which]),
    )
