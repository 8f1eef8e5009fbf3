"""What dry frictions do from a state on, before anything runs: which stick, which slide, and what those that stick
bear."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.contact.freedom import Freedom, counted_coordinates
from mbproj.integrate.stops.meeting import meet
from mbproj.integrate.stops.met import Met
from mbproj.integrate.stops.rubbing import at_rest, friction_rates, rubbed
from mbproj.integrate.stops.whole import speed_of
from mbproj.model.contacts import Contacts, in_contact
from mbproj.model.system import System


@dataclass(frozen=True, eq=False)
class Resting:
    """The contacts of a state; of each friction the `force` along its coordinate, and the largest, `most`, that it can
    have at rest, (K,) each, in N or N m."""

    contacts: Contacts
    force: Array
    most: Array


class RubsAtStart(TypedDict):
    """The rate of what a friction resists in m/s or rad/s, and the `unit` of that without the s; whether the friction
    sticks, or else the `direction` in which it slides, 1 or -1; its force in N or torque in N m, and the largest that
    it has at rest. In the plane of a stop rate and force are sizes, and the direction is 0 while nothing touches."""

    rate: float
    unit: str
    sticks: bool
    direction: int
    force: float
    static: float


def resting(system: System, state: State) -> Resting:
    """What sticks at a state at which a run begins. Raises SimulationError where neither sticking nor sliding fulfils
    Coulomb's law, and where a stop is driven into."""
    fastest = speed_of(system, state)
    contacts = meet(system, state, Contacts(), Met(fastest=fastest), begins=True).contacts
    bare = in_contact(system, Contacts((), contacts.pushing))
    freedom = Freedom.at(bare, state)
    rests = at_rest(bare, state, contacts, None, fastest)
    touches = np.array(contacts.touching, dtype=np.intp)
    found = rubbed(freedom, freedom.free(counted_coordinates(bare, state)), state, contacts, touches, rests)
    return Resting(contacts, found.force, found.most)


def frictions_at_start(system: System, state: State) -> dict[str, RubsAtStart]:
    """The dry frictions that can stick, by name, those at stops by that of the stop. Raises SimulationError as
    `resting` does."""
    return {} if system.frictions is None else rubs_of(system, state, resting(system, state))


def rubs_of(system: System, state: State, found: Resting) -> dict[str, RubsAtStart]:
    """The same of what was `found` at the state."""
    frictions = system.frictions
    if frictions is None:
        return {}
    rate, contacts = friction_rates(system, state), found.contacts
    shown: dict[str, RubsAtStart] = {}
    for k in filter(frictions.first, range(frictions.size)):
        stop, partner, slides = int(frictions.stop[k]), int(frictions.partner[k]), k in contacts.sliding
        touches = stop < 0 or stop in contacts.touching or stop in contacts.pushing
        speed, force, way = float(rate[k]), float(found.force[k]), int(np.sign(contacts.sliding.get(k, 0.0)))
        if partner >= 0:
            speed, force = float(np.hypot(speed, rate[partner])), float(np.hypot(force, found.force[partner]))
            way = int(slides)
        shown[system.names.frictions[k] if stop < 0 else system.names.stops[stop]] = RubsAtStart(
            rate=speed,
            unit=system.names.friction_units[k],
            sticks=touches and not slides,
            direction=way,
            force=force,
            static=float(found.most[k]),
        )
    return shown
