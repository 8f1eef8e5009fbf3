"""Dry frictions at an initial state: which of them stick, which slide, and their forces. The kernel decides, as at the
start of a run."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.friction.changing import frictions_at
from mbproj.dynamics.observe.bearings import load, supports
from mbproj.integrate.formulations.choice import choose
from mbproj.integrate.stops.inside import Inside, contacts_of
from mbproj.integrate.stops.rubbing import friction_rates
from mbproj.model.contacts import Contacts
from mbproj.model.system import System
from mbproj.scene.records import Settings
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class Resting:
    """The contacts of a state; the `force` of each friction along its coordinate, and its largest force at rest,
    `most`, (K,) each, in N or N m."""

    contacts: Contacts
    force: Array
    most: Array


class RubsAtStart(TypedDict):
    """A dry friction at the start. `rate`: that of its coordinate in `unit`/s, m/s or rad/s. `direction`: that of
    sliding, 1 or -1, and 0 while it sticks or its stop is open. `force` and `static`: its force and its largest force
    at rest, in N or N m. At a stop `rate` and `force` are magnitudes in its plane."""

    rate: float
    unit: str
    sticks: bool
    direction: int
    force: float
    static: float


def resting(system: System, state: State) -> Resting:
    """Return the contacts and the frictions' forces at an initial state. Raises SimulationError where neither sticking
    nor sliding fulfils Coulomb's law, and where a stop is driven into; InputError without a kernel."""
    frictions, short = system.frictions, THRESHOLDS.same_written  # a run so short that motions have no effect
    settings = Settings(duration=short, step=short, output_step=short)
    assert frictions is not None
    choice = choose(system, state, settings)
    inside = Inside(choice, system, state, 1.0)
    run = inside.compiled.run(state, settings)
    inside.begin(run)
    block = run.advance(1, 1.0)
    if not len(block["t"]):
        raise inside.failure(run) or inside.compiled.failure(run, settings) or AssertionError("a run ends as it begins")
    samples = inside.samples(inside.compiled.samples(block, {}), block)
    pushes, force = np.split(block["pushes"][0], [len(system.names.stops)])
    most, bearings = frictions_at(system, state).static.copy(), system.bearings
    if bearings is not None:
        loads = load(bearings, supports(system, bearings, pose_of(state.q), samples.multipliers[0]))
        most *= np.where(frictions.bearing >= 0, loads[frictions.bearing], 1.0)
    most *= np.where(frictions.stop >= 0, np.append(pushes, 1.0)[frictions.stop], 1.0)
    return Resting(contacts_of(system, run.contacts), force, most)


def frictions_at_start(system: System, state: State) -> dict[str, RubsAtStart]:
    """Return the dry frictions that can stick, by name; those at a stop have the stop's name. Raises SimulationError as
    `resting` does."""
    return {} if system.frictions is None else rubs_of(system, state, resting(system, state))


def rubs_of(system: System, state: State, rests: Resting) -> dict[str, RubsAtStart]:
    """Return the result of `frictions_at_start` from the contacts `rests` at the state."""
    frictions = system.frictions
    if frictions is None:
        return {}
    rate, contacts = friction_rates(system, state), rests.contacts
    shown: dict[str, RubsAtStart] = {}
    for k in filter(frictions.first, range(frictions.size)):
        stop, partner, slides = int(frictions.stop[k]), int(frictions.partner[k]), k in contacts.sliding
        touches = stop < 0 or stop in contacts.touching or stop in contacts.pushing
        speed, force, way = float(rate[k]), float(rests.force[k]), int(np.sign(contacts.sliding.get(k, 0.0)))
        if partner >= 0:
            speed, force = float(np.hypot(speed, rate[partner])), float(np.hypot(force, rests.force[partner]))
            way = int(slides)
        shown[system.names.frictions[k] if stop < 0 else system.names.stops[stop]] = RubsAtStart(
            rate=speed,
            unit=system.names.friction_units[k],
            sticks=touches and not slides,
            direction=way,
            force=force,
            static=float(rests.most[k]),
        )
    return shown
