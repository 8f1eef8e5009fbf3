"""What a leg with its contacts and frictions says of the mechanism itself, in which these are forces."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from mbproj.arrays import Array, Integers, Numbers
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.contact.freedom import Freedom
from mbproj.dynamics.equations.constraint_equations import set_velocity
from mbproj.dynamics.equations.gaps import gap_rates, gaps, pressing, stored_energy
from mbproj.dynamics.equations.kinematics import body_rates, pose_of, twist_of
from mbproj.dynamics.friction.changing import frictions_over, sliding_forces
from mbproj.dynamics.friction.problem import Cone, contact_problem
from mbproj.dynamics.observe.bearings import load, supports
from mbproj.dynamics.observe.samples import Samples
from mbproj.integrate.stops.variants import Variant
from mbproj.model.contacts import Contacts, bearing_numbers, friction_laws, walls
from mbproj.model.frictions import Frictions
from mbproj.model.stops import Stops
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


def of_the_whole(variant: Variant, samples: Samples) -> Samples:
    """Samples of a variant as those of the mechanism itself: rows of contacts and frictions become forces of stops and
    of frictions."""
    system = variant.system
    stops, frictions, rows = system.stops, system.frictions, variant.contacts.rows
    own = np.arange(system.joints.size - rows, system.joints.size)

    @cache
    def known() -> tuple[Array, Array, Array]:
        press = np.zeros((len(samples.t), 0)) if stops is None else _pressing(variant, stops, samples, own)
        if frictions is None:
            return press, *np.zeros((2, len(samples.t), 0))
        force, slides = _rubbing(variant, frictions, samples, own, press)
        least = (press, force) if stops is None else least_shares(variant.free, variant.contacts, samples, press, force)
        return *least, slides

    return replace(
        samples,
        solved=lambda _: np.delete(samples.multipliers, own, axis=1),
        press=None if stops is None else lambda: known()[0],
        rub=None if frictions is None else lambda: known()[1:],
    )


def _pressing(variant: Variant, stops: Stops, samples: Samples, own: Integers) -> Array:
    """How hard each stop pushes, (T, S)."""
    held, pose, by = list(variant.contacts.held), pose_of(samples.q), np.zeros(stops.size)
    gap, rate = gaps(stops, pose, samples.turns), gap_rates(stops, pose, twist_of(pose, samples.v))
    by[list(variant.contacts.pushing)] = list(variant.contacts.pushing.values())
    found = pressing(stops, by, gap, rate)
    alone = -stops.side[held] * samples.multipliers[:, own[: len(held)]]
    found[:, held] = alone
    for k, parts in variant.contacts.shares.items():
        found[:, k] = np.maximum(sum(part * alone[:, held.index(at)] for at, part in parts), 0.0)
    return np.asarray(found)


def _rubbing(
    variant: Variant, frictions: Frictions, samples: Samples, own: Integers, press: Array
) -> tuple[Array, Array]:
    """The force of each friction along its coordinate, and where it slides to, 0 while it sticks, (T, K) each. What
    sticks at a wall takes half of its push in `press` (T, S), or all that it can, off."""
    system, contacts, pose = variant.system, variant.contacts, pose_of(samples.q)
    rate = np.asarray(set_velocity(frictions.coordinates, pose, twist_of(pose, samples.v)))
    loads, numbers = np.ones_like(rate), np.array(bearing_numbers(variant.free, frictions, contacts))
    if system.bearings is not None and (numbers >= 0).any():
        found = load(system.bearings, supports(system, system.bearings, pose, samples.multipliers))
        loads = np.where(numbers >= 0, found[:, numbers], 1.0)
    speed = np.hypot(rate, np.where(frictions.partner >= 0, rate[:, frictions.partner], 0.0))
    slides = np.zeros_like(rate)
    for k, direction in contacts.sliding.items():
        in_plane = frictions.partner[k] in contacts.sliding and k not in contacts.slow
        slides[:, k] = rate[:, k] / np.where(speed[:, k] > 0.0, speed[:, k], 1.0) if in_plane else direction
    frictions = frictions_over(system, samples)
    static = np.broadcast_to(frictions.static, rate.shape)
    force = -slides * sliding_forces(frictions, speed) * loads
    for k, part in contacts.bearing.items():
        force[:, k] = part * static[:, k] * loads[:, k]
    for stop, k in walls(system, contacts).items():
        assert system.stops is not None
        together = press[:, stop]
        taken = np.where(together > 0.0, np.minimum(0.5 * together, static[:, k] * loads[:, k]), together)
        force[:, k] = system.stops.side[stop] * taken
        press[:, stop] -= taken
    force[:, list(contacts.stuck)] = -samples.multipliers[:, own[len(contacts.held) :]]
    return force, slides


def integrals_of_the_whole(variant: Variant, integrals: Numbers) -> Array:
    """Work, dissipation and what each friction has lost, (..., 2 + K), of those that the variant has, maybe none."""
    found = np.zeros((*integrals.shape[:-1], 2 + len(variant.system.names.frictions)))
    if integrals.shape[-1]:
        rubs = [2 + k for k in friction_laws(variant.contacts)]
        found[..., :2], found[..., rubs] = integrals[..., :2], integrals[..., 2:]
    return found


def stored_in_stops(variant: Variant, samples: Samples) -> Array:
    """What compliant stops keep at samples, (T,), in J."""
    stops = variant.system.stops
    if stops is None:
        return np.zeros(len(samples.t))
    return np.asarray(stored_energy(stops, gaps(stops, pose_of(samples.q), samples.turns)))


def stored_by(system: System, state: State) -> float:
    """What compliant stops keep at a state, J."""
    if system.stops is None:
        return 0.0
    return float(stored_energy(system.stops, gaps(system.stops, pose_of(state.q), state.turns)))


def speed_of(system: System, state: State) -> float:
    """How fast the fastest part of a mechanism moves, in its lengths and rad per s."""
    pose = pose_of(state.q)
    twist = twist_of(pose, state.v)
    return float(np.abs(twist.velocity).max() / system.length + np.abs(body_rates(pose, twist)).max())


def row_of_the_whole(system: System, contacts: Contacts, row: int, before: int) -> int:
    """The row of the mechanism's own C for one of a variant's, where `before` rows come before the joints'; those of
    contacts and frictions come after all others, in the order of the stops and then of the frictions."""
    number, stops = row - before - system.joints.size, len(system.names.stops)
    own = [*contacts.held, *(stops + k for k in contacts.stuck)]
    if number < 0:
        return row
    return system.constraints + own[number] if number < len(own) else row - len(own)


def least_shares(
    system: System, contacts: Contacts, samples: Samples, press: Array, force: Array
) -> tuple[Array, Array]:
    """The pushes (T, S) and the forces of frictions (T, K) of the least-norm share, where something rests on stops by
    friction. They follow from any share, as a run keeps one; the same where there is one."""
    stops, frictions = system.stops, system.frictions
    assert stops is not None
    assert frictions is not None
    resting = np.flatnonzero(np.isin(frictions.stop, contacts.touching))
    resting = resting[[k not in contacts.sliding for k in resting.tolist()]]
    if len(resting) == 0 or len(contacts.touching) < 2:  # the forces at one point are unique
        return press, force
    touching = np.array(contacts.touching, dtype=np.intp)
    cones: list[Cone] = []
    press, force, B, known = press.copy(), force.copy(), np.zeros((0, 0)), b""
    for at in range(len(samples.t)):
        if known != samples.q[at].tobytes():
            known = samples.q[at].tobytes()
            freedom = Freedom.at(system, samples.state(at))
            A = np.vstack([freedom.rows(stops)[touching], freedom.rows_of(frictions.coordinates)[resting]])
            B = A @ A.T
            size = np.linalg.norm(A, axis=1)[len(touching) :]
            able = size > THRESHOLDS.no_push * size.max()  # what nothing can move along bears nothing
            of = [np.flatnonzero(able & (frictions.stop[resting] == stop)) + len(touching) for stop in touching]
            cones = [Cone(at, tuple(rows.tolist()), _most(frictions, int(touching[at]))) for at, rows in enumerate(of)]
        borne = np.concatenate([press[at, touching], force[at, resting]])
        least = contact_problem(B, -B @ borne, cones)
        if least is not None:
            press[at, touching], force[at, resting] = least[: len(touching)], least[len(touching) :]
    return press, force


def _most(frictions: Frictions, stop: int) -> float:
    """The coefficient at rest of the friction of a stop, 0 for none, with what shares at the edge are off by."""
    return (1.0 + THRESHOLDS.slips) * float(frictions.static[frictions.stop == stop].max(initial=0.0))
