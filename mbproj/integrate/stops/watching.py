"""What ends the contacts and frictions of a leg, and what each means."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.dynamics.contact.inside import stop_sizes
from mbproj.integrate.events.halts import Watched, WatchedGap, WatchedRow
from mbproj.integrate.stops.rubbing import friction_sizes
from mbproj.integrate.stops.variants import Variant
from mbproj.model.contacts import Contacts, bearing_numbers, push_numbers, walls
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

#: Sliding in a plane is watched along directions so far aside of its own, rad: none goes back before it is at rest, or
#: has turned by what is left to a right angle.
ASIDE = np.pi / 3.0


@dataclass(frozen=True)
class Meaning:
    """What it is that a run has met: a stop or a friction; a contact of that stop that is `released`, a friction that
    comes to `rest`."""

    stop: int | None = None
    friction: int | None = None
    released: bool = False
    rest: bool = False

    @property
    def let_go(self) -> tuple[int, ...]:
        """The stop that is released, or none."""
        return () if self.stop is None or not self.released else (self.stop,)

    def name(self, system: System) -> str:
        """For messages."""
        if self.friction is not None:
            return f"friction '{system.names.frictions[self.friction]}'"
        return "" if self.stop is None else f"stop '{system.names.stops[self.stop]}'"


@dataclass(frozen=True)
class Met:
    """What a run has met: stops that are `released`, a friction that comes to `rest`, or nothing of these; and the
    `fastest` motion of the run so far, 1/s. `again`: a stop whose gap would close from here on, though nothing presses
    it yet: it does from here on."""

    released: tuple[int, ...] = ()
    rest: int | None = None
    fastest: float = 0.0
    again: int | None = None


def watched_of(variant: Variant, push: float, fastest: float, interval: float) -> tuple[Watched, tuple[Meaning, ...]]:
    """What halts a leg of a variant, with what each means: gaps of stops that do not touch, those of compliant ones
    that open again, and contacts that pull, where stops push by up to `push`; sliding that comes to rest and friction
    that holds no longer, where the `fastest` motion so far was that, 1/s. `interval` lies between two samples, s."""
    found = [*_gaps_of_stops(variant), *_rates_of_frictions(variant, fastest)]
    rows = [*_rows_of_stops(variant, push), *_rows_of_frictions(variant)]
    spacing = THRESHOLDS.look_spacing * interval
    watched = Watched(tuple(gap for gap, _ in found), tuple(row for row, _ in rows), spacing)
    return watched, (*(meaning for _, meaning in found), *(meaning for _, meaning in rows))


def _gaps_of_stops(variant: Variant) -> Iterator[tuple[WatchedGap, Meaning]]:
    stops, contacts = variant.system.stops, variant.contacts
    if stops is None:
        return
    slack = THRESHOLDS.stop_slack * stop_sizes(variant.system)
    for k in range(stops.size):
        if k not in contacts.held and k not in contacts.shares:
            side = float(stops.side[k])
            yield WatchedGap(k, -side if k in contacts.pushing else side, float(slack[k])), Meaning(stop=k)


def _rates_of_frictions(variant: Variant, fastest: float) -> Iterator[tuple[WatchedGap, Meaning]]:
    """Of those that slide, and of those that rest though nothing of friction holds them: something else does."""
    system, contacts = variant.system, variant.contacts
    if system.frictions is None:
        return
    first = 0 if system.stops is None else system.stops.size
    size = friction_sizes(system)
    fastest = max(fastest, float(np.finfo(float).tiny))
    slow = np.maximum(THRESHOLDS.stop_rests * fastest, np.finfo(float).tiny) * size
    frictions, given = system.frictions, variant.choice.degrees_of_freedom == 0
    rests_over = THRESHOLDS.rest_steps / fastest if given else np.inf
    for k in range(frictions.size):
        partner, stop = int(frictions.partner[k]), int(frictions.stop[k])
        if k in contacts.sliding:
            gap = WatchedGap(first + k, contacts.sliding[k], float(slow[k]), of_rate=True, rests_over=rests_over)
            meaning = Meaning(friction=k, rest=True)
            if partner not in contacts.sliding:
                yield gap, meaning
            elif partner > k:
                yield from ((each, meaning) for each in _in_plane(gap, contacts, k, partner, first, fastest, size[k]))
        elif k not in contacts.stuck and k not in contacts.bearing and stop < 0:
            idle = 4.0 * float(slow[k])
            for sign in (1.0, -1.0):
                yield WatchedGap(first + k, sign, float(slow[k]), of_rate=True, idle=idle), Meaning(friction=k)


def _in_plane(
    gap: WatchedGap, contacts: Contacts, k: int, partner: int, first: int, fastest: float, size: float
) -> Iterator[WatchedGap]:
    """Of sliding in a plane: along its direction where that is kept; where it begins, until it has a direction of its
    own; else along directions aside of it, and along it where it becomes so slow that it keeps its direction."""
    own, across = contacts.sliding[k], contacts.sliding[partner]
    gap = gap._replace(other=first + partner, other_sign=across, rests_over=np.inf)
    if k in contacts.straight:
        yield gap
        return
    slow = THRESHOLDS.straight_speed * fastest * size
    if k in contacts.starting:
        yield gap._replace(sign=-own, other_sign=-across, idle=3.0 * slow)
        return
    for turn in (ASIDE, -ASIDE):
        cosine, sine = float(np.cos(turn)), float(np.sin(turn))
        yield gap._replace(sign=cosine * own - sine * across, other_sign=sine * own + cosine * across)
    yield gap._replace(idle=-slow)


def _rows_of_stops(variant: Variant, push: float) -> Iterator[tuple[WatchedRow, Meaning]]:
    stops, contacts = variant.system.stops, variant.contacts
    if stops is None:
        return
    first = variant.system.joints.size - contacts.rows
    slack = max(THRESHOLDS.contact_pulls * push, float(np.finfo(float).tiny))
    numbers = push_numbers(variant.free, contacts)
    rub = walls(variant.system, contacts)
    for at, k in enumerate(contacts.held):
        row, meaning = WatchedRow(first + at, -float(stops.side[k]), slack), Meaning(stop=k, released=True)
        if k in rub:
            yield row._replace(**_bound(variant, rub[k])), meaning
        elif k not in contacts.shares:
            yield row, meaning
    for k in contacts.shares:
        row = WatchedRow(first, 0.0, slack, part=-1.0 if k in contacts.idle else 1.0, bearing=numbers[k])
        yield row, Meaning(stop=k)


def _rows_of_frictions(variant: Variant) -> Iterator[tuple[WatchedRow, Meaning]]:
    frictions, contacts = variant.system.frictions, variant.contacts
    if frictions is None:
        return
    first, order = variant.system.joints.size - len(contacts.stuck), list(contacts.stuck)
    for at, k in enumerate(order):
        partner, row = int(frictions.partner[k]), WatchedRow(first + at, 1.0, **_bound(variant, k))
        if partner in contacts.stuck:
            if partner > k:
                yield row._replace(other=first + order.index(partner)), Meaning(friction=k)
            continue
        for sign in (1.0, -1.0):
            yield row._replace(sign=sign), Meaning(friction=k)


def _bound(variant: Variant, k: int) -> dict[str, Any]:
    """How hard a friction can hold at rest, as a watched row has it."""
    frictions, contacts = variant.system.frictions, variant.contacts
    assert frictions is not None
    static, bearing = float(frictions.static[k]), bearing_numbers(variant.free, frictions, contacts)[k]
    program, least = frictions.bound_of(k, variant.system.forces.programs.size), float(np.finfo(float).tiny)
    if program >= 0:
        bound, part = (1.0, 0.0) if bearing < 0 else (0.0, 1.0)
        return {"slack": least, "bound": bound, "part": part, "bearing": bearing, "program": program}
    static *= float(np.sqrt(1.0 - contacts.bearing.get(int(frictions.partner[k]), 0.0) ** 2))
    bound, part = (static, 0.0) if bearing < 0 else (0.0, static)
    slack = THRESHOLDS.contact_pulls * static if bearing < 0 else least
    return {"slack": slack, "bound": bound, "part": part, "bearing": bearing}
