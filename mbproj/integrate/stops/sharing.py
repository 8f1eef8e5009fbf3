"""Forces of stops that touch, of frictions at rest and of joints that the motion does not determine: these share a load
at will, and a run reports one share of many."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Flags, Integers
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.contact.freedom import Freedom
from mbproj.dynamics.contact.inside import stop_sizes
from mbproj.dynamics.equations.gaps import gap_rates, gaps
from mbproj.dynamics.observe.bearings import load, supports
from mbproj.dynamics.observe.reactions import reactions
from mbproj.integrate.events.time_events import DECIDES, SHARED, Event
from mbproj.model.contacts import Contacts, in_contact
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


def sharing(system: System, state: State, contacts: Contacts, fastest: float) -> tuple[str, ...]:
    """Whose forces are shared at will with these contacts: "stop 'a'", "friction 'b'", "joint 'C'".

    Forces y along rows A of what holds leave the motion alone where Aᵀy = 0. `fastest`: the fastest motion of the run
    so far, 1/s."""
    resting = _resting(system, contacts)
    if len(contacts.touching) + len(resting) < 2:
        return ()
    freedom = Freedom.at(in_contact(system, Contacts((), contacts.pushing)), state)
    rows, gradients = np.zeros((0, freedom.basis.shape[1])), np.zeros((0, len(freedom.basis)))
    stops, frictions, held = system.stops, system.frictions, contacts.touching
    touching = np.zeros(0, dtype=np.intp)
    if stops is not None:
        touching = _touching(system, freedom, state, contacts, fastest)
        rows, gradients = freedom.rows(stops)[touching], freedom.gap_gradients(stops)[touching]
    if frictions is not None:
        rows = np.vstack([rows, freedom.rows_of(frictions.coordinates)[resting]])
        gradients = np.vstack([gradients, freedom.gradients_of(frictions.coordinates)[resting]])
    sure = np.append(np.isin(touching, held), np.ones(len(resting), dtype=bool))
    y = _balanced_with_themselves(rows, sure)
    part: Flags = np.any(np.abs(y) > THRESHOLDS.no_part, axis=0)
    if not part.any():
        return ()
    found = [f"stop '{system.names.stops[k]}'" for k in touching[part[: len(touching)]]]
    own = y / np.maximum(np.linalg.norm(rows, axis=1), np.finfo(float).tiny)
    multipliers = own @ freedom.multipliers_of(gradients)
    if frictions is not None:
        shares = {int(k) for k in resting[part[len(touching) :]]}
        shares |= {k for k in contacts.sliding if frictions.stop[k] in touching[part[: len(touching)]]}
        if system.bearings is not None:
            bearings = system.bearings
            carried = load(bearings, supports(system, bearings, freedom.pose, multipliers)) - bearings.preload
            arms = np.maximum(bearings.radial, bearings.axial)
            changes = (carried > THRESHOLDS.no_part * arms * np.abs(own).max()).any(axis=0)
            shares |= {k for k in contacts.sliding if frictions.bearing[k] >= 0 and changes[frictions.bearing[k]]}
        found += [f"friction '{system.names.frictions[k]}'" for k in sorted(shares)]
    force, torque = reactions(system, freedom.pose, multipliers)
    size = np.linalg.norm(force, axis=-1) * system.length + np.linalg.norm(torque, axis=-1)
    loaded = (size > THRESHOLDS.no_part * np.abs(own).max() * system.length).any(axis=0)
    return (*found, *(f"joint '{system.names.joints[j]}'" for j in np.flatnonzero(loaded)))


def changed(t: float, before: tuple[str, ...], after: tuple[str, ...]) -> tuple[Event, ...]:
    """What is recorded where other forces are shared from now on."""
    ended = (Event(t, name, SHARED, -1) for name in before if name not in after)
    return (*ended, *(Event(t, name, SHARED, 1) for name in after if name not in before))


def decided(system: System, t: float, before: Contacts, after: Contacts) -> tuple[Event, ...]:
    """What is recorded where the motion begins to depend on how stops share."""
    if before.decides or not after.decides:
        return ()
    return tuple(Event(t, f"stop '{system.names.stops[k]}'", DECIDES, 1) for k in sorted({*after.shares} - after.idle))


def _resting(system: System, contacts: Contacts) -> Integers:
    """The frictions at rest, those at stops where these touch."""
    frictions = system.frictions
    if frictions is None:
        return np.zeros(0, dtype=np.intp)
    acts = (frictions.stop < 0) | np.isin(frictions.stop, contacts.touching)
    acts[list(contacts.sliding)] = False
    return np.flatnonzero(acts)


def _touching(system: System, freedom: Freedom, state: State, contacts: Contacts, fastest: float) -> Integers:
    """The rigid stops that are held, and those that rest without a push."""
    stops = system.stops
    assert stops is not None
    size = stop_sizes(system)
    near = np.abs(gaps(stops, freedom.pose, state.turns)) <= THRESHOLDS.touching * size
    slow = np.abs(gap_rates(stops, freedom.pose, freedom.twist)) <= THRESHOLDS.stop_rests * fastest * size
    found = stops.is_rigid & near & slow
    found[contacts.touching] = True
    return np.flatnonzero(found)


def _balanced_with_themselves(rows: Array, sure: Flags) -> Array:
    """A basis of the y (d, k) with Aᵀy = 0, for rows A of unit length. Of those that are not `sure`, only rows within
    the span of these count: others open. A row that nothing can move along has no part."""
    size = np.linalg.norm(rows, axis=1)
    moves = size > THRESHOLDS.no_push * size.max(initial=0.0)
    unit = np.where(moves[:, None], rows / np.where(moves, size, 1.0)[:, None], 0.0)
    _, values, basis = np.linalg.svd(unit[sure], full_matrices=False)
    basis = basis[values > THRESHOLDS.half_digits]
    outside = np.linalg.norm(unit - (unit @ basis.T) @ basis, axis=1) > THRESHOLDS.half_digits
    counts = np.flatnonzero(moves & ~outside)
    left, values, _ = np.linalg.svd(unit[counts])
    rank = int(np.count_nonzero(values > THRESHOLDS.half_digits))
    found = np.zeros((len(counts) - rank, len(rows)))
    found[:, counts] = left[:, rank:].T
    return found
