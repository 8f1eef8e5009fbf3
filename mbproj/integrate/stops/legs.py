"""One leg of a run with its contacts: from a state to a time, or to where it halts; samples are those of the whole
mechanism, in which contacts are forces of stops."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array, Flags
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.gaps import gap_rates, gaps, pressing, stored_energy
from mbproj.dynamics.equations.kinematics import pose_of, twist_of
from mbproj.dynamics.observe.samples import Samples, stack
from mbproj.integrate.events.halts import Watched
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.formulations.full import FullFormulation
from mbproj.integrate.loop.compiled_march import march as march_compiled
from mbproj.integrate.loop.march import march
from mbproj.integrate.loop.stop_watch import StopWatch
from mbproj.integrate.outcome.marks import Marks
from mbproj.integrate.outcome.tally import Tally
from mbproj.integrate.stops.variants import Variant
from mbproj.model.contacts import Contacts
from mbproj.model.system import System
from mbproj.scene.records import Settings

#: What samples have one of each.
ARRAYS = ("t", "q", "v", "acceleration", "turns", "step_size", "work")


def samples_of(
    variant: Variant,
    state: State,
    settings: Settings,
    leg: Leg,
    tally: Tally,
    watched: Watched | None = None,
    marks: Marks | None = None,
) -> Iterator[Samples | None]:
    """The samples of a leg, as the variant has them. Raises Halted where it has met something that is watched, and
    SimulationError."""
    choice = variant.choice
    if choice.compiled is not None:
        yield from march_compiled(choice.compiled, state, settings, tally, marks, None, leg, watched)
        return
    formulation = FullFormulation.of(variant.system, state, settings, choice.redundant)
    watch = None if watched is None else StopWatch(variant.system, watched)
    for sample in march(formulation, state, tally, marks, None, leg, watch):
        yield stack([sample])


@dataclass(frozen=True, eq=False)
class Reached:
    """The end of one step: the state, and λ of the variant's rows (m,)."""

    state: State
    multipliers: Array


def one_step(variant: Variant, state: State, settings: Settings, whole: Leg, h: float, tally: Tally) -> Reached:
    """A single step of size h, tried. Raises SimulationError where there is none."""
    leg = Leg(state.t, h, whole.interval, whole.breaks, step=h, count=1)
    single = replace(settings, duration=h, step=h, tolerance=None)
    own = Tally()
    blocks = [block for block in samples_of(variant, state, single, leg, own) if block is not None]
    tally.count_evaluations(own.evaluations)
    return end_of(blocks[-1])


def end_of(samples: Samples) -> Reached:
    """The last of some samples."""
    state = State(float(samples.t[-1]), samples.q[-1], samples.v[-1], samples.turns[-1])
    return Reached(state, samples.multipliers[-1])


def of_the_whole(variant: Variant, samples: Samples) -> Samples:
    """Samples of a variant as those of the mechanism itself: rows of contacts become forces of stops, (T, S)."""
    stops, held = variant.system.stops, variant.contacts.held
    assert stops is not None
    rows = variant.system.joints.size
    own = np.arange(rows - len(held), rows)

    def press() -> Array:
        pose = pose_of(samples.q)
        gap, rate = gaps(stops, pose, samples.turns), gap_rates(stops, pose, twist_of(pose, samples.v))
        damping = np.zeros(stops.size)
        for stop, c in variant.contacts.pushing.items():
            damping[stop] = c
        found = pressing(stops, damping, gap, rate)
        found[:, list(held)] = -stops.side[list(held)] * samples.multipliers[:, own]
        return found

    return replace(samples, solved=lambda: np.delete(samples.multipliers, own, axis=1), press=press)


def stored_in_stops(variant: Variant, samples: Samples) -> Array:
    """What compliant stops keep at samples, (T,), in J."""
    stops = variant.system.stops
    assert stops is not None
    return np.asarray(stored_energy(stops, gaps(stops, pose_of(samples.q), samples.turns)))


def row_of_the_whole(system: System, contacts: Contacts, row: int, before: int) -> int:
    """The row of the mechanism's own C for one of a variant's, where `before` rows come before the joints'; those of
    contacts come after all others, in the order of the stops."""
    number, held = row - before - system.joints.size, len(contacts.held)
    if number < 0:
        return row
    return system.constraints + contacts.held[number] if number < held else row - held


def only(samples: Samples, which: Flags) -> Samples:
    """Some of the samples."""
    if which.all():
        return samples
    press = samples.press
    return replace(
        samples,
        **{
            name: getattr(samples, name)[which]
            for name in ("t", "q", "v", "acceleration", "turns", "step_size", "work")
        },
        solved=lambda: samples.multipliers[which],
        counters={name: values[which] for name, values in samples.counters.items()},
        press=None if press is None else lambda: press()[which],
    )
