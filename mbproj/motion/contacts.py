"""Stops and dry friction in the kernel's loop: their data for the kernel, their events, and their forces in samples.
The kernel finds the times of contact events and decides which contacts are closed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import count, takewhile
from typing import Any

import numpy as np

from mbproj.arrays import Array, Integers
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.contact.freedom import Freedom
from mbproj.dynamics.contact.inside import stop_sizes
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.observe.reactions import reactions
from mbproj.dynamics.observe.samples import Samples
from mbproj.errors import SimulationError
from mbproj.integrate.events.time_events import SHARED, Event
from mbproj.integrate.formulations.choice import Choice
from mbproj.integrate.formulations.compiled import Compiled
from mbproj.integrate.reporting.failures import no_unique_sliding
from mbproj.integrate.stops.rubbing import friction_sizes
from mbproj.integrate.stops.whole import speed_of, stored
from mbproj.model.contacts import Contacts, at_walls, in_contact
from mbproj.model.system import System
from mbproj.registry import IMPACT_LAWS, USUAL_IMPACT_LAW
from mbproj.thresholds import THRESHOLDS

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
    sizes, yields, given = stop_sizes(system), ~stops.is_rigid, np.isnan(stops.restitution)
    number = np.where(yields, system.forces.laws.size + np.cumsum(yields) - 1, -1)
    damping = np.where(yields & given, stops.damping, 0.0)
    per_mass = np.where(yields & ~given, stops.gives_by, 0.0)
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
    return [(*own, *law, *at) for own, law, at in zip(numbers, laws.tolist(), places, strict=True)]


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
        shares={k: tuple((own, part) for own, part in parts) for k, parts in state.get("shares", ())},
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
    own = [stop_names(system, [k]) if k < stops else f"friction '{system.names.frictions[k - stops]}'" for k in which]
    cause = "it is met and released again and again at one time"
    hint = "make it compliant with 'stiffness', or use a smaller step or tolerance"
    return SimulationError(t, cause, where=", ".join(own) or None, hint=hint)


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
        owners = [own.coordinates for own in (system.stops, system.frictions) if own is not None]
        gradients = np.vstack([freedom.gradients_of(along) for along in owners])
        force, torque = reactions(system, freedom.pose, forces.T @ freedom.multipliers_of(gradients))
        size = np.linalg.norm(force, axis=-1) * system.length + np.linalg.norm(torque, axis=-1)
        bears = (size > THRESHOLDS.no_part * np.abs(forces).max() * system.length).any(axis=0)
        return np.flatnonzero(bears[list(joints)]).tolist()

    return loaded
