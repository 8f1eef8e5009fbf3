"""Stops and dry friction in the kernel's loop: their data for the kernel, their events, and their forces in samples.
The kernel finds the times of contact events and decides which contacts are closed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from itertools import count, takewhile
from typing import Any

import numpy as np

from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.contact.inside import stop_sizes
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.observe.samples import Samples
from mbproj.errors import SimulationError
from mbproj.integrate.events.time_events import SHARED, Event
from mbproj.integrate.formulations.choice import Choice
from mbproj.integrate.formulations.compiled import Compiled
from mbproj.integrate.stops.failures import undecided
from mbproj.integrate.stops.rubbing import friction_sizes
from mbproj.integrate.stops.sharing import loaded_joints
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
