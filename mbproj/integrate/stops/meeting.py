"""What happens when stops are met or frictions change: impacts, contacts that begin and end, bounces that come to rest,
sticking and sliding."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.contact.freedom import Freedom, counted_coordinates
from mbproj.dynamics.contact.impact import LAWS, Impact, Struck, contact_pushes
from mbproj.dynamics.contact.touch import Touch
from mbproj.dynamics.friction.shares import held_by, shares_of
from mbproj.integrate.events.time_events import Event
from mbproj.integrate.stops.failures import creates_energy, driven_into, struck_together
from mbproj.integrate.stops.met import Met
from mbproj.integrate.stops.rubbing import at_exact_rest, at_rest, happened, rubbed, rubbing_of
from mbproj.integrate.stops.sharing import decided
from mbproj.model.contacts import Contacts, at_walls, in_contact
from mbproj.model.stops import Stops
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class Meeting:
    """The state after, the contacts from here on, what is recorded; the energy that was lost and the work that motions
    did in no time, J; and how hard the contacts push, N or N m, or so much that a pull within round-off is none."""

    state: State
    contacts: Contacts
    events: tuple[Event, ...] = ()
    lost: float = 0.0
    work: float = 0.0
    push: float = 0.0
    rubbed: tuple[Integers, Array] | None = None


def meet(system: System, state: State, contacts: Contacts, met: Met, *, begins: bool = False) -> Meeting:
    """At a state where something is met: a gap is closed, the contact of a stop pushes no longer, sliding comes to rest
    or friction holds no longer. Raises SimulationError where a motion drives into a stop, where an impact would create
    energy, and where neither sticking nor sliding is possible. Where a run `begins`, frictions have no past."""
    if system.stops is None:
        state, after, _ = _with_friction(system, state, contacts, met, np.zeros(0, dtype=bool), Contacts())
        found = Meeting(state, after)
    else:
        found = _at_stops(system, system.stops, state, contacts, met)
    rubs = () if begins else happened(state.t, system, contacts, found.contacts)
    return replace(found, events=(*found.events, *rubs))


def _at_stops(system: System, stops: Stops, state: State, contacts: Contacts, met: Met) -> Meeting:
    before = state
    pushing, events = _compliant(system, stops, state, contacts, met)
    touch = Touch(system, stops, state, pushing)
    touched = _marked(stops.size, (*contacts.held, *contacts.shares))
    still = THRESHOLDS.stop_rests * touch.size * met.fastest  # at rest all of the motion is round-off
    touch.slow = np.where(touched, np.maximum(touch.slow, still), touch.slow)
    rigid = stops.is_rigid & (touch.near | touched)
    struck = rigid & (touch.rate < -touch.slow) & ~touched
    lost, work, by_friction = 0.0, 0.0, None
    rests: tuple[Event, ...] = ()
    if struck.any():
        done, rests = _bounced(touch, rigid, struck)
        events += _of_impact(touch, rigid, struck, done)
        lost, work, by_friction = done.lost, done.work, done.rubbed
        touch = touch.after(done.v)
    lifts = rigid & (touch.rate > touch.slow)
    if lifts.any():
        lifts &= _lifts_less(touch, rigid, THRESHOLDS.stop_slack)
    if lifts.any():  # they come back before their gaps are seen to open, as where sliding ends and something rocks
        touch, gained = _without_lifting(touch, np.flatnonzero(lifts))
        lost -= gained
    staying = rigid & (np.abs(touch.rate) <= touch.slow)
    staying[list(met.released)] = False
    if system.frictions is None:
        push = _pushes(touch, staying)
        which = np.flatnonzero(staying)
        N = touch.N[which]
        after = replace(held_by(push, which, shares_of(N, push[which])), pushing=pushing)
        opens = touch.acceleration + touch.N @ (N.T @ push[which]) > touch.round_off
        idle = [k for k in contacts.held if staying[k] and not opens[k] and k not in (*after.touching, *after.idle)]
        after = replace(after, held=tuple(sorted((*after.held, *idle))))
    else:
        known = Contacts((), pushing) if struck.any() else replace(contacts, held=(), pushing=pushing)
        state, after, push = _with_friction(system, touch.state, known, met, staying, Contacts((), pushing))
        touch = touch.after(state.v)
    fades = staying & (push > 0.0) & (push <= THRESHOLDS.contact_pulls * push.max(initial=0.0))
    if met.released and fades.any():  # what pushes by no more than round-off goes with what is let go
        gone = (*met.released, *np.flatnonzero(fades).tolist())
        return _at_stops(system, stops, before, contacts, replace(met, released=gone))
    rough = () if system.frictions is None else system.frictions.stop  # friction goes by a push that is there
    if met.again is not None and staying[met.again] and met.again not in (*after.touching, *after.idle, *rough):
        after = replace(after, held=tuple(sorted((*after.held, met.again))))
    events += rests
    new = [
        k
        for k in after.touching
        if k not in contacts.touching and not any(each.name == _name(system, k) for each in rests)
    ]
    events += tuple(Event(state.t, _name(system, k), "contact", -1) for k in new)
    events += tuple(
        Event(state.t, _name(system, k), "release", 1) for k in contacts.touching if k not in after.touching
    )
    events += decided(system, state.t, contacts, after)
    least = touch.least_push(staying) if staying.any() else 0.0
    return Meeting(touch.state, after, events, lost, work, float(push.max(initial=least)), by_friction)


def _with_friction(
    system: System, state: State, contacts: Contacts, met: Met, staying: Flags, pushed: Contacts
) -> tuple[State, Contacts, Array]:
    """The state, the contacts from here on, and how hard stops push; frictions are as in `contacts` up to here."""
    bare = in_contact(system, pushed)
    freedom = Freedom.at(bare, state)
    rests = at_rest(bare, state, contacts, met.rest, met.fastest)
    still = at_exact_rest(freedom, state, np.flatnonzero(staying), rests, met.fastest)
    if still is not state:
        state, freedom = still, Freedom.at(bare, still)
    free = freedom.free(counted_coordinates(bare, state))
    found = rubbed(freedom, free, state, contacts, np.flatnonzero(staying), rests, met.fastest)
    after = replace(
        found.held,
        pushing=pushed.pushing,
        sliding=found.sliding,
        stuck=found.stuck,
        bearing=found.bearing,
        straight=found.straight,
        starting=found.starting,
    )
    return state, at_walls(bare, after, np.flatnonzero(staying).tolist()), found.push


def _compliant(
    system: System, stops: Stops, state: State, contacts: Contacts, met: Met
) -> tuple[dict[int, float], tuple[Event, ...]]:
    """The compliant stops that push from here on, with their damping."""
    pushing, events = dict(contacts.pushing), []
    touch = Touch(system, stops, state, pushing)
    for k in [k for k in pushing if touch.gap[k] >= -THRESHOLDS.touching * touch.size[k] and touch.rate[k] >= 0.0]:
        del pushing[k]
        events.append(Event(state.t, _name(system, k), "release", 1))
    for k in np.flatnonzero(~touch.stops.is_rigid & touch.near).tolist():
        if k in contacts.pushing:
            continue
        inside = touch.gap[k] < -THRESHOLDS.touching * touch.size[k]
        rests = touch.rate[k] <= touch.slow[k] and (touch.acceleration[k] < 0.0 or k == met.again)
        unseen = 0.0 < touch.rate[k] ** 2 < -2.0 * touch.acceleration[k] * THRESHOLDS.stop_slack * touch.size[k]
        if inside or rests or unseen or touch.rate[k] < -touch.slow[k]:
            pushing[k] = stops.pushes_by(k, touch.N[k])
            events.append(Event(state.t, _name(system, k), "contact", -1))
    return pushing, tuple(events)


def _bounced(touch: Touch, rigid: Flags, struck: Flags) -> tuple[Impact, tuple[Event, ...]]:
    """The impact of the stops that touch; where a bounce would be lower than any that counts, without restitution, and
    when its bounces would have come to rest."""
    bounces = struck if touch.stops.impact_law == "newton" else rigid  # else by impulses, which others have too
    e = np.where(bounces, touch.stops.restitution, 0.0)
    done = _struck(touch, rigid, e)
    again = touch.after(done.v)
    with np.errstate(divide="ignore", invalid="ignore"):
        way = 2.0 * again.rate / (again.fall(rigid) * (1.0 - e))
    low = struck & (e > 0.0) & (e < 1.0) & _lifts_less(again, rigid, THRESHOLDS.lowest_bounce)
    t = touch.state.t
    rests: tuple[Event, ...] = ()
    if low.any():
        rests = tuple(Event(t + float(way[k]), _name(touch.system, int(k)), "rest", -1) for k in np.flatnonzero(low))
        done = _struck(touch, rigid, np.where(low, 0.0, e))
        again = touch.after(done.v)
    settled, gained = _settled(again, rigid, low)
    return replace(done, v=settled.state.v, lost=done.lost - gained), rests


def _settled(touch: Touch, rigid: Flags, low: Flags) -> tuple[Touch, float]:
    """After an impact, without what rocks by less than any bounce that counts, and the energy that this has given, J.
    Where some are kept closed, others may fall shut that opened before."""
    settled, gained = touch, 0.0
    staying = np.zeros_like(rigid)
    while True:
        rocks = rigid & ~low & (settled.rate > settled.slow) & _lifts_less(settled, rigid, THRESHOLDS.lowest_bounce)
        if not (rocks & ~staying).any():
            return settled, gained
        staying |= rocks | (rigid & (np.abs(settled.rate) <= settled.slow))
        settled, gained = _without_lifting(touch, np.flatnonzero(staying))


def _lifts_less(touch: Touch, rigid: Flags, height: float) -> Flags:
    """Which gaps open, and fall shut again before they are a height, in the mechanism's own length or rad, (S,)."""
    fall = touch.fall(rigid)
    with np.errstate(divide="ignore", invalid="ignore"):
        reached = np.where(fall > 0.0, touch.rate**2 / (2.0 * fall), np.inf)
    return np.asarray((touch.rate > 0.0) & (reached < height * touch.size))


def _without_lifting(touch: Touch, which: Integers) -> tuple[Touch, float]:
    """The same where these stops stay closed, and the kinetic energy that this has given, J: what rocks comes to
    rest."""
    x: Array = np.array(np.linalg.lstsq(touch.N[which], -touch.rate[which], rcond=THRESHOLDS.no_push)[0], dtype=float)
    return touch.after(touch.state.v + touch.freedom.changed(x)), touch.freedom.gained(x)


def _struck(touch: Touch, rigid: Flags, e: Array) -> Impact:
    t, which, law = touch.state.t, np.flatnonzero(rigid), touch.stops.impact_law
    rough = rubbing_of(touch.freedom, touch.state, which)
    struck = Struck(touch.freedom, touch.N[which], touch.rate[which], e[which], rough)
    found = LAWS[law](struck, touch.state.v)
    if found is None:
        raise driven_into(t, touch.system, which[touch.rate[which] < 0.0])
    if not _holds(touch, rigid, law, found):
        raise struck_together(t, touch.system, which)
    if found.lost < -THRESHOLDS.creates_energy * touch.kinetic:
        others = {name: other(struck, touch.state.v) for name, other in LAWS.items()}
        helps = [
            name for name, each in others.items() if each and each.lost >= 0.0 and _holds(touch, rigid, name, each)
        ]
        raise creates_energy(t, touch.system, which[found.impulse > 0.0], -found.lost, law, helps)
    return found


def _holds(touch: Touch, rigid: Flags, law: str, done: Impact) -> bool:
    """Whether the law has an answer for the stops that are struck, and leaves no gap that closes."""
    closing = [(each.rate < -touch.slow)[rigid] for each in (touch, touch.after(done.v))]
    return law != "energetic" or (closing[0].sum() <= 1 and not closing[1].any())


def _of_impact(touch: Touch, rigid: Flags, struck: Flags, done: Impact) -> tuple[Event, ...]:
    """What is recorded of an impact: of each stop that pushes its impulse and the energy it takes."""
    events = []
    for k, impulse, taken in zip(np.flatnonzero(rigid), done.impulse, done.taken, strict=True):
        if impulse > 0.0:
            kind = "impact" if struck[k] else "push of an impact"
            events.append(Event(touch.state.t, _name(touch.system, int(k)), kind, -1, float(impulse), float(taken)))
    return tuple(events)


def _pushes(touch: Touch, staying: Flags) -> Array:
    """How hard the stops that stay closed push, (S,)."""
    found = np.zeros(touch.stops.size)
    which = np.flatnonzero(staying)
    if len(which):
        pushes = contact_pushes(touch.N[which], touch.acceleration[which])
        if pushes is None:
            raise driven_into(touch.state.t, touch.system, which)
        found[which] = pushes
    return found


def _marked(size: int, which: tuple[int, ...]) -> Flags:
    found = np.zeros(size, dtype=bool)
    found[list(which)] = True
    return found


def _name(system: System, k: int) -> str:
    """What events call a stop."""
    return f"stop '{system.names.stops[k]}'"
