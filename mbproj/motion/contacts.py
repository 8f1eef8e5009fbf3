"""Stops and dry friction in the kernel's loop: their data for the kernel, their events, and their forces in samples.
The kernel finds the times of contact events and decides which contacts are closed.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import count, takewhile
from typing import Any, TypedDict

import numpy as np

from mbproj.base.arrays import Array, Flags, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem, SimulationError
from mbproj.base.registry import EQUILIBRIUM, IMPACT_LAWS, USUAL_IMPACT_LAW
from mbproj.base.settings import Settings
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.assembly.assemble import State
from mbproj.equations.bearings import load, supports
from mbproj.equations.constraints import set_velocity
from mbproj.equations.contacts import Freedom, nearest_inside, stored_energy
from mbproj.equations.friction import frictions_at
from mbproj.equations.gaps import gap_rates, gaps, stop_sizes
from mbproj.equations.kinematics import Pose, body_rates, pose_of, twist_of
from mbproj.equations.reactions import reactions
from mbproj.equations.samples import Samples
from mbproj.model.contacts import Contacts, at_walls, in_contact
from mbproj.model.system import System
from mbproj.motion.failures import no_unique_sliding
from mbproj.motion.formulations.choice import Choice, choose
from mbproj.motion.formulations.compiled import Compiled
from mbproj.motion.time_events import SHARED, Event

# --- The largest speed of a mechanism, and the energy stored in its stops ---------------------------------------------


def stored(system: System, pose: Pose, turns: Integers) -> Array:
    """Return the energy stored in compliant stops at poses (...), (...), in J."""
    if system.stops is None:
        return np.zeros(pose.position.shape[:-2])
    return np.asarray(stored_energy(system.stops, gaps(system.stops, pose, turns)))


def speed_of(system: System, state: State) -> float:
    """Return the speed of the fastest body of a mechanism, in the mechanism's lengths and rad per s."""
    pose = pose_of(state.q)
    twist = twist_of(pose, state.v)
    return float(np.abs(twist.velocity).max() / system.length + np.abs(body_rates(pose, twist)).max())


# --- Dry frictions at one state ---------------------------------------------------------------------------------------
# Their rates, and which of them are at rest.


def friction_sizes(system: System) -> Array:
    """Return the scales of the frictions' coordinates, (K,): the mechanism's length in m, or 1 rad."""
    assert system.frictions is not None
    return np.where(system.frictions.coordinates.is_length, system.length, 1.0)


def friction_rates(system: System, state: State) -> Array:
    """Return s' of the frictions, (K,)."""
    assert system.frictions is not None
    pose = pose_of(state.q)
    return np.asarray(set_velocity(system.frictions.coordinates, pose, twist_of(pose, state.v)))


def at_rest(system: System, state: State) -> Flags:
    """Return whether each friction is at rest, (K,): no faster than round-off of the mechanism's motion. Both frictions
    of a plane rest together."""
    frictions = system.frictions
    assert frictions is not None
    rate = friction_rates(system, state)
    across = np.where(frictions.partner >= 0, rate[frictions.partner], 0.0)
    slow = THRESHOLDS.stop_rests * speed_of(system, state) * friction_sizes(system)
    return np.asarray(np.hypot(rate, across) <= slow)


# --- Stops and dry friction in the kernel's loop ----------------------------------------------------------------------


#: The sets of `Contacts` that a saved state may contain.
MARKED = ("idle", "straight", "starting")


def _joints(system: System, compiled: Compiled) -> list[int]:
    """Return the system's number of each joint of the kernel."""
    return [*takewhile(lambda joint: joint < len(system.names.joints), map(compiled.joint, count()))]


def _stop_laws(system: System) -> list[tuple[float, ...]]:
    """Return the kernel's data of each stop: side, restitution, slack and size. For compliant stops: the number of the
    law (-1: rigid), the damping c, and the factor `Stops.gives_by`."""
    stops = system.stops
    if stops is None:
        return []
    sizes, yields, damped = stop_sizes(system), ~stops.is_rigid, np.isnan(stops.restitution)
    number = np.where(yields, system.forces.laws.size + np.cumsum(yields) - 1, -1)
    damping = np.where(yields & damped, stops.damping, 0.0)
    per_mass = np.where(yields & ~damped, stops.gives_by, 0.0)
    slack = THRESHOLDS.stop_slack * sizes
    rows = zip(stops.side, stops.restitution, slack, sizes, number, damping, per_mass, strict=True)
    return [tuple(each.item() for each in row) for row in rows]


def _friction_laws(system: System) -> list[tuple[float, ...]]:
    """Return the kernel's data of each friction. The first six are the number of its law where all slide, its bearing,
    static and sliding force, Stribeck speed and size. Its stop, its partner and the program of its static bound follow,
    each -1 for none."""
    frictions = system.frictions
    if frictions is None:
        return []
    first = system.forces.laws.size + len(_all_push(system))
    numbers = zip(range(first, first + frictions.size), frictions.bearing.tolist(), strict=True)
    laws = np.column_stack([frictions.static, frictions.sliding, frictions.stribeck, friction_sizes(system)])
    programs = system.forces.programs.size + len(_all_push(system)) + frictions.size + len(frictions.varies)
    bounds = [frictions.bound_of(k, programs) for k in range(frictions.size)]
    places = zip(frictions.stop.tolist(), frictions.partner.tolist(), bounds, strict=True)
    return [(*number, *law, *at) for number, law, at in zip(numbers, laws.tolist(), places, strict=True)]


def _all_push(system: System) -> dict[int, float]:
    """Return the damping of each compliant stop, by its number. For a stop with a restitution it is r = 1, and the
    kernel scales the rate."""
    stops = system.stops
    if stops is None:
        return {}
    by = np.where(np.isnan(stops.restitution), stops.damping, 1.0)
    return {k: float(by[k]) for k in np.flatnonzero(~stops.is_rigid).tolist()}


def _as_laws(system: System) -> Contacts:
    """Return contacts in which all frictions slide and all compliant stops push: the kernel scales each of these
    laws."""
    return Contacts(pushing=_all_push(system), sliding=dict.fromkeys(range(len(system.names.frictions)), 1.0))


def contacts_of(system: System, state: Mapping[str, Any]) -> Contacts:
    """Return the contacts from the kernel's saved state."""
    held = tuple(sorted(state["held"]))
    contacts = Contacts(
        held,
        dict(state["pushing"]),
        dict(state["sliding"]),
        dict(state["stuck"]),
        dict(state.get("bearing", ())),
        shares={k: tuple((stop, part) for stop, part in parts) for k, parts in state.get("shares", ())},
        **{name: frozenset(state.get(name, ())) for name in MARKED},
    )
    return at_walls(system, contacts, held)


class Inside:
    """The contacts of one run from `start` in the kernel's loop. `interval`: the time between samples in s. `halts`:
    whether the run ends before its first contact event."""

    def __init__(self, choice: Choice, system: System, start: State, interval: float, *, halts: bool = False) -> None:
        assert choice.compiled is not None
        self.system, self.halts, self._alone = system, halts, choice.compiled
        self.compiled = choice.compiled.with_system(in_contact(system, _as_laws(system)), whole=system)
        self._interval, self._stored = interval, stored(system, pose_of(start.q), start.turns)
        self._fastest = max(speed_of(system, start), THRESHOLDS.slow_motion / interval)

    def begin(self, run: Any) -> None:
        """Give the contacts to the kernel's run, before its first step."""
        stops, frictions = self.system.stops, self.system.frictions
        law = USUAL_IMPACT_LAW if stops is None else stops.impact_law
        state: dict[str, Any] = {"push": 0.0, "fastest": self._fastest, "met_at": -np.inf, "met_often": 0}
        state |= {"held": [], "lost": 0.0, "work": 0.0, "events": 0}
        state |= {"rubbed": [0.0] * (0 if frictions is None else frictions.size)}
        laws = _stop_laws(self.system), _friction_laws(self.system)
        in_plane, joints = self.compiled.dimension == "Plane", _joints(self.system, self.compiled)
        loaded = loaded_joints(self.system, self.compiled, joints) if in_plane else None
        run.begin_contacts(*laws, state, self._interval, IMPACT_LAWS.index(law), loaded)
        if self.halts:
            run.halt_at_contacts()

    def take(self, run: Any) -> list[Event]:
        """Return the events since the last call."""
        return [Event(t, self._name(k, what[0]), *what) for t, k, *what in run.take_contact_events()]

    def failure(self, run: Any) -> SimulationError | None:
        """Return the error of a run that ended because the kernel could not decide on contacts; None for other ends."""
        if run.outcome.status != self.compiled.core.Status.undecided:
            return None
        return undecided(float(run.outcome.time), self.system, *run.undecided)

    def _name(self, number: int, what: str) -> str:
        """Return the name of a stop, a friction or a joint for events. Both frictions at a stop have the name of its
        force."""
        frictions, k = self.system.frictions, number - len(self.system.names.stops)
        if what != SHARED and frictions is not None and 0 <= k < frictions.size and frictions.stop[k] >= 0:
            name = frictions.owners[k].split("'")[1]
            return f"friction '{name}'"
        return self._names[number]

    @cached_property
    def _names(self) -> list[str]:
        """The names of all stops, frictions and joints, which may share a load, in the kernel's order."""
        joints = [self.system.names.joints[joint] for joint in _joints(self.system, self.compiled)]
        parts = {"stop": self.system.names.stops, "friction": self.system.names.frictions, "joint": joints}
        return [f"{what} '{name}'" for what, names in parts.items() for name in names]

    def samples(self, samples: Samples, block: Mapping[str, Any]) -> Samples:
        """Return a block of samples with the forces of stops and frictions. Energy stored in compliant stops is not
        counted as dissipated."""
        stops, pushes, alone = len(self.system.names.stops), np.asarray(block["pushes"]), self._alone
        side = np.ones(0) if self.system.stops is None else self.system.stops.side
        forces = np.ascontiguousarray(pushes * np.append(side, np.ones(pushes.shape[1] - stops)))
        work = samples.work + block["jumps"]
        work[:, 1] -= stored(self.system, pose_of(samples.q), samples.turns) - self._stored
        return replace(
            samples,
            work=work,
            solved=lambda _: alone.multipliers(samples, forces),
            press=None if self.system.stops is None else lambda: pushes[:, :stops],
            rub=None if self.system.frictions is None else lambda: (pushes[:, stops:], block["slides"][:, stops:]),
        )


# --- Errors where a run ends at a stop or a dry friction --------------------------------------------------------------
# Each has the time, the owner, and a remedy.


def stop_names(system: System, which: Sequence[int] | Integers) -> str:
    """Return the names of stops: "stop 'A'", "stops 'A', 'B'"."""
    names = ", ".join(f"'{system.names.stops[int(k)]}'" for k in which)
    return f"stop{'s' * (len(which) > 1)} {names}"


def undecided(
    t: float, system: System, why: str, which: Sequence[int], energy: float, laws: Sequence[int]
) -> SimulationError:
    """Return the error of contacts that the kernel could not decide, for the cause `why`. `which`: their numbers.
    `energy`: that in J which an impact would create. `laws`: the numbers of the impact laws that would create none."""
    if why == "driven into":
        return driven_into(t, system, which)
    if why == "creates energy":
        assert system.stops is not None
        return creates_energy(t, system, which, energy, system.stops.impact_law, [IMPACT_LAWS[k] for k in laws])
    if why == "no balance":
        return finds_no_balance(t, system, np.array(which))
    if why == "never ends":
        return never_ends(t, system, which)
    if why == "pushes":
        return pushes_along(t, system, which)
    cause = "a contact meets a motion without inertia: no force or impulse is finite there"
    return SimulationError(t, cause, hint="give its bodies mass and inertia")


def driven_into(t: float, system: System, which: Sequence[int] | Integers) -> SimulationError:
    """Return the error of rigid stops whose gaps no motion that the joints allow can open."""
    cause = "a rigid stop is driven into: no motion that the joints allow can turn back there"
    hint = "end the motion before the stop, drive with a force, or make the stop compliant with 'stiffness'"
    return SimulationError(t, cause, where=stop_names(system, which), hint=hint)


def creates_energy(
    t: float, system: System, which: Sequence[int] | Integers, energy: float, law: str, helps: Sequence[str]
) -> SimulationError:
    """Return the error of an impact law that would create energy in J, by unequal restitutions or by friction. `helps`:
    the laws that would create none."""
    assert system.stops is not None
    unequal = len({float(system.stops.restitution[int(k)]) for k in which}) > 1
    where = "unequal restitutions meet" if unequal else "friction turns an impact round"
    cause = f"the impact would create {energy:.4g} J: {law.capitalize()}'s law does not hold where {where}"
    hint = "give them the same 'restitution'" if unequal else "use a smaller 'restitution' or 'friction' there"
    if helps:
        hint = f"use 'impact_law: {helps[0]}' in 'simulation', or {hint}"
    return SimulationError(t, cause, where=stop_names(system, which), hint=hint)


def finds_no_balance(t: float, system: System, frictions: Integers) -> SimulationError:
    """Return the error of dry frictions that can neither stick nor slide, or can slide in two ways."""
    names, owners = ", ".join(f"'{system.names.frictions[int(k)]}'" for k in frictions), system.frictions
    joints: list[int] = (
        [] if owners is None or system.bearings is None else system.bearings.joint[owners.bearing[frictions]].tolist()
    )
    of = ", ".join(dict.fromkeys(f"'{system.names.joints[int(joint)]}'" for joint in joints))
    return no_unique_sliding(t, f"friction {names} of joint {of}" if of else f"friction {names}")


def never_ends(t: float, system: System, which: Sequence[int]) -> SimulationError:
    """Return the error of contacts that close and open again and again at one time. `which`: their numbers, stops
    first, then frictions."""
    stops = len(system.names.stops)
    names = [stop_names(system, [k]) if k < stops else f"friction '{system.names.frictions[k - stops]}'" for k in which]
    cause = "it is met and released again and again at one time"
    hint = "make it compliant with 'stiffness', or use a smaller step or tolerance"
    return SimulationError(t, cause, where=", ".join(names) or None, hint=hint)


def pushes_along(t: float, system: System, which: Sequence[int]) -> SimulationError:
    """Return the error of a dry friction that would create energy. `which`: its number among frictions."""
    cause = "dry friction pushes along the motion, so it creates energy: the run is wrong from about here on"
    hint = "use a smaller step or tolerance; where the friction is a formula, keep it positive"
    return SimulationError(t, cause, where=f"friction '{system.names.frictions[which[0]]}'", hint=hint)


# --- Joints that bear part of a shared load ---------------------------------------------------------------------------
# Stops and frictions share a load arbitrarily. In a planar run such a part may load joints out of the plane.


def loaded_joints(
    system: System, compiled: Compiled, joints: Sequence[int]
) -> Callable[[float, Array, Array], list[int]]:
    """Return a function of (t, y, forces). It returns the places, within `joints`, of the joints that bear any of the
    forces.

    y is the kernel's, and `forces` (S + K, k) act along the coordinates of stops and frictions."""

    def loaded(t: float, y: Array, forces: Array) -> list[int]:
        q, v = compiled.coordinates(compiled.bodies_of(y))
        freedom = Freedom.at(system, State.of(system, t, positions=q, velocities=v))
        owners = [contact.coordinates for contact in (system.stops, system.frictions) if contact is not None]
        gradients = np.vstack([freedom.gradients_of(along) for along in owners])
        force, torque = reactions(system, freedom.pose, forces.T @ freedom.multipliers_of(gradients))
        size = np.linalg.norm(force, axis=-1) * system.length + np.linalg.norm(torque, axis=-1)
        bears = (size > THRESHOLDS.no_part * np.abs(forces).max() * system.length).any(axis=0)
        return np.flatnonzero(bears[list(joints)]).tolist()

    return loaded


# --- Dry frictions at an initial state --------------------------------------------------------------------------------
# Which of them stick, which slide, and their forces. The kernel decides, as at the start of a run.


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


# --- The start of a run with stops ------------------------------------------------------------------------------------
# Inside all of them, or touching some with speeds that agree.


#: Words for a coordinate beyond the bound of a stop, by the stop's side.
BEYOND = {1.0: "below the least", -1.0: "above the most"}


class AtStart(TypedDict):
    """The gap of a stop in m or rad and its rate per s, the `unit` of the gap, and whether the stop touches."""

    gap: float
    rate: float
    unit: str
    touches: bool


def gaps_at_start(system: System, state: State) -> dict[str, AtStart]:
    """Return the gaps of stops at the start, by the stops' names."""
    if system.stops is None:
        return {}
    pose = pose_of(state.q)
    gap, rate = gaps(system.stops, pose, state.turns), gap_rates(system.stops, pose, twist_of(pose, state.v))
    touches = gap <= THRESHOLDS.same_written * stop_sizes(system)
    return {
        name: {
            "gap": float(gap[k]),
            "rate": float(rate[k]),
            "unit": system.names.stop_units[k],
            "touches": bool(touches[k]),
        }
        for k, name in enumerate(system.names.stops)
    }


def refuse_penetration(system: System, state: State, start: str = "scene") -> None:
    """Raises InputError where the state is beyond a stop, or touches a rigid one and moves into it. A run that is to
    `start` from its equilibrium may compress compliant stops."""
    if system.stops is None:
        return
    pose = pose_of(state.q)
    gap, slack = gaps(system.stops, pose, state.turns), THRESHOLDS.same_written * stop_sizes(system)
    beyond = np.flatnonzero((gap < -slack) & (system.stops.is_rigid | (start != EQUILIBRIUM)))
    if len(beyond):
        raise InputError(_limit_problems(system, state, gap, beyond))
    rate = gap_rates(system.stops, pose, twist_of(pose, state.v))
    struck = system.stops.is_rigid & (gap <= slack) & (rate < -slack)
    if struck.any():
        raise InputError([_into(system, int(k), float(-rate[k])) for k in np.flatnonzero(struck)])


def _limit_problems(system: System, state: State, gap: Array, beyond: Integers) -> list[Problem]:
    """Return the problems of stops that the start is beyond. They say how to begin inside, or that the stops exclude
    each other."""
    assert system.stops is not None
    places = system.stops.places
    _, left = nearest_inside(system, state)
    apart = np.flatnonzero(left < -np.sqrt(THRESHOLDS.assembled) * stop_sizes(system))
    if len(apart):
        names = " and ".join(f"'{system.names.stops[k]}'" for k in apart)
        whom = "exclude each other" if len(apart) > 1 else "cannot be kept"
        missed = " and ".join(f"{-left[k]:.3g} {system.names.stop_units[k]}" for k in apart)
        said = f"the limits {names} {whom}: no pose near the start is inside, the nearest is beyond by {missed}"
        return [Problem(said, places[k], "widen the range, or look at the joints of the loop") for k in apart]
    return [_outside(system, int(k), float(gap[k])) for k in beyond]


def _outside(system: System, k: int, gap: float) -> Problem:
    stops, unit = system.stops, system.names.stop_units[k]
    assert stops is not None
    side, bound = float(stops.side[k]), float(stops.bound[k])
    at = f"at {bound + side * gap:.6g} {unit}, {BEYOND[side]}, {bound:.6g} {unit}"
    message = f"the start is beyond the stop '{system.names.stops[k]}' by {-gap:.6g} {unit}: {at}"
    return Problem(message, stops.places[k], "start inside, or widen the range")


def _into(system: System, k: int, speed: float) -> Problem:
    stops, unit = system.stops, system.names.stop_units[k]
    assert stops is not None
    message = f"the start touches the stop '{system.names.stops[k]}' and moves into it at {speed:.6g} {unit}/s"
    return Problem(message, stops.places[k], "start before the stop, or with a speed that leads away from it")
