"""What happens when stops are met: impacts, contacts that begin and end, bounces that come to rest."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property

import numpy as np

from mbproj.arrays import Array, Flags
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.contact.freedom import Freedom, counted_coordinates
from mbproj.dynamics.contact.hunt_crossley import relative_damping
from mbproj.dynamics.contact.impact import Impact, contact_pushes, impact
from mbproj.dynamics.contact.inside import stop_sizes
from mbproj.dynamics.equations.energy import kinetic_energy
from mbproj.dynamics.equations.gaps import gap_rates, gaps
from mbproj.dynamics.equations.kinematics import body_rates, pose_of, twist_of
from mbproj.integrate.events.time_events import Event
from mbproj.integrate.stops.failures import creates_energy, driven_into
from mbproj.model.contacts import Contacts, in_contact
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class Meeting:
    """The state after, the contacts from here on, what is recorded; the energy that was lost and the work that motions
    did in no time, J; and how hard the contacts push, N or N m."""

    state: State
    contacts: Contacts
    events: tuple[Event, ...]
    lost: float = 0.0
    work: float = 0.0
    push: float = 0.0


class _Touch:
    """A mechanism at stops, with what they are to it."""

    def __init__(self, system: System, state: State, pushing: dict[int, float]) -> None:
        assert system.stops is not None
        self.system, self.state, self.stops = in_contact(system, Contacts((), pushing)), state, system.stops
        pose = pose_of(state.q)
        twist = twist_of(pose, state.v)
        self.gap, self.rate = gaps(self.stops, pose, state.turns), gap_rates(self.stops, pose, twist)
        self.size = stop_sizes(system)
        self.near = self.gap <= THRESHOLDS.touching * self.size
        speed = np.abs(twist.velocity).max() / system.length + np.abs(body_rates(pose, twist)).max()
        self.slow = THRESHOLDS.stop_rests * self.size * speed
        self.kinetic = float(kinetic_energy(system, pose, twist))

    @cached_property
    def freedom(self) -> Freedom:
        return Freedom.at(self.system, self.state)

    @cached_property
    def N(self) -> Array:
        return self.freedom.rows(self.stops)

    @cached_property
    def acceleration(self) -> Array:
        """Of the gaps, without contacts of rigid stops, (S,)."""
        return self.freedom.gap_accelerations(self.stops, counted_coordinates(self.system, self.state))

    def after(self, v: Array) -> _Touch:
        """The same with other velocities; what counts as slow is as before, as round-off is."""
        found = _Touch.__new__(_Touch)
        found.__dict__.update({k: x for k, x in self.__dict__.items() if k not in ("freedom", "N", "acceleration")})
        found.state = replace(self.state, v=v)
        pose = pose_of(found.state.q)
        found.rate = gap_rates(self.stops, pose, twist_of(pose, v))
        return found


def meet(system: System, state: State, contacts: Contacts, released: int | None = None) -> Meeting:
    """At a state where something is met: a gap is closed, or the contact of a stop pushes no longer and is `released`.
    Raises SimulationError where a motion drives into a stop, or where an impact would create energy."""
    pushing, events = _compliant(system, state, contacts)
    touch = _Touch(system, state, pushing)
    rigid = touch.stops.is_rigid & (touch.near | _marked(touch.stops.size, contacts.held))
    struck = rigid & (touch.rate < -touch.slow) & ~_marked(touch.stops.size, contacts.held)
    lost = work = 0.0
    rests: tuple[Event, ...] = ()
    if struck.any():
        done, rests = _bounced(touch, rigid, struck)
        events += _of_impact(touch, rigid, struck, done)
        lost, work = done.lost, done.work
        touch = touch.after(done.v)
    staying = rigid & (np.abs(touch.rate) <= touch.slow)
    if released is not None:
        staying[released] = False
    push = _pushes(touch, staying)
    held = tuple(int(k) for k in np.flatnonzero(push > 0.0))
    events += rests
    new = [k for k in held if k not in contacts.held and not any(each.name == _name(system, k) for each in rests)]
    events += tuple(Event(state.t, _name(system, k), "contact", -1) for k in new)
    events += tuple(Event(state.t, _name(system, k), "release", 1) for k in contacts.held if k not in held)
    return Meeting(touch.state, Contacts(held, pushing), events, lost, work, float(push.max(initial=0.0)))


def _compliant(system: System, state: State, contacts: Contacts) -> tuple[dict[int, float], tuple[Event, ...]]:
    """The compliant stops that push from here on, with their damping."""
    pushing, events = dict(contacts.pushing), []
    touch = _Touch(system, state, pushing)
    for k in [k for k in pushing if touch.gap[k] >= -THRESHOLDS.touching * touch.size[k] and touch.rate[k] >= 0.0]:
        del pushing[k]
        events.append(Event(state.t, _name(system, k), "release", 1))
    for k in np.flatnonzero(~touch.stops.is_rigid & touch.near).tolist():
        if k in contacts.pushing:
            continue
        inside = touch.gap[k] < -THRESHOLDS.touching * touch.size[k]
        rests = touch.rate[k] <= touch.slow[k] and touch.acceleration[k] < 0.0
        if inside or rests or touch.rate[k] < -touch.slow[k]:
            pushing[k] = _damping(touch, k)
            events.append(Event(state.t, _name(system, k), "contact", -1))
    return pushing, tuple(events)


def _damping(touch: _Touch, k: int) -> float:
    """c of a compliant stop that is met now. What is pressed on it at rest meets it with the speed of the oscillation
    that this begins: k δᵖ = m a, v² = a δ."""
    stops = touch.stops
    if np.isnan(stops.restitution[k]):
        return float(stops.damping[k])
    mass, pressed = 1.0 / float(touch.N[k] @ touch.N[k]), max(-float(touch.acceleration[k]), 0.0)
    depth = (mass * pressed / float(stops.stiffness[k])) ** (1.0 / float(stops.exponent[k]))
    speed = float(np.hypot(touch.rate[k], np.sqrt(pressed * depth)))
    return relative_damping(float(stops.restitution[k])) / speed


def _bounced(touch: _Touch, rigid: Flags, struck: Flags) -> tuple[Impact, tuple[Event, ...]]:
    """The impact of the stops that touch; where a bounce would be lower than any that counts, without restitution, and
    when its bounces would have come to rest."""
    e = np.where(struck, touch.stops.restitution, 0.0)
    done = _struck(touch, rigid, e)
    again = touch.after(done.v)
    fall = -again.acceleration
    with np.errstate(divide="ignore", invalid="ignore"):
        height = np.where(fall > 0.0, again.rate**2 / (2.0 * fall), np.inf)
        way = 2.0 * again.rate / (fall * (1.0 - e))
    low = struck & (e > 0.0) & (e < 1.0) & (again.rate > 0.0) & (height < THRESHOLDS.lowest_bounce * touch.size)
    if not low.any():
        return done, ()
    t = touch.state.t
    rests = tuple(Event(t + float(way[k]), _name(touch.system, int(k)), "rest", -1) for k in np.flatnonzero(low))
    return _struck(touch, rigid, np.where(low, 0.0, e)), rests


def _struck(touch: _Touch, rigid: Flags, e: Array) -> Impact:
    which = np.flatnonzero(rigid)
    found = impact(touch.freedom, touch.state.v, touch.N[which], touch.rate[which], e[which])
    if found is None:
        raise driven_into(touch.state.t, touch.system, which[touch.rate[which] < 0.0])
    if found.lost < -THRESHOLDS.creates_energy * touch.kinetic:
        raise creates_energy(touch.state.t, touch.system, which[found.impulse > 0.0], -found.lost)
    return found


def _of_impact(touch: _Touch, rigid: Flags, struck: Flags, done: Impact) -> tuple[Event, ...]:
    """What is recorded of an impact: of each stop that pushes its impulse and the energy it takes."""
    after, t = touch.after(done.v), touch.state.t
    events = []
    for k, impulse in zip(np.flatnonzero(rigid), done.impulse, strict=True):
        if impulse > 0.0:
            taken = -0.5 * float(impulse) * float(touch.rate[k] + after.rate[k])
            kind = "impact" if struck[k] else "push of an impact"
            events.append(Event(t, _name(touch.system, int(k)), kind, -1, float(impulse), taken))
    return tuple(events)


def _pushes(touch: _Touch, staying: Flags) -> Array:
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
