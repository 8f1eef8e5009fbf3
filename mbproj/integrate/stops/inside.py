"""Stops and dry friction in the kernel's own loop: it finds when they are met, and does what happens there. What it
leaves over is for `march`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import count, takewhile
from typing import Any, Protocol

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.contact.impact import LAWS
from mbproj.dynamics.contact.inside import stop_sizes
from mbproj.dynamics.observe.samples import Samples
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.events.time_events import SHARED, Event
from mbproj.integrate.formulations.choice import Choice
from mbproj.integrate.formulations.compiled import Compiled
from mbproj.integrate.reporting.marks import Mark
from mbproj.integrate.stops.rubbing import friction_sizes
from mbproj.integrate.stops.variants import Variant, Variants
from mbproj.integrate.stops.watching import Meaning
from mbproj.model.contacts import Contacts, at_walls, walls
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


def meets_inside(choice: Choice, system: System, state: State) -> bool:
    """Whether the kernel's loop itself has the contacts of a mechanism: where every motion that the joints leave has
    inertia at a state."""
    if choice.compiled is None:
        return False
    if system.driven and system.reflected.inertia.size:  # motions pay for flywheels in no time
        return False
    heavy = bool((system.mass > 0.0).all()) and np.linalg.eigvalsh(system.inertia)[:, 0].min(initial=np.inf) > 0.0
    return heavy or choice.compiled.is_regular(state)[0]


def is_of_the_march(mark: Mark) -> bool:
    """Whether a run goes on from where an older mbproj has met stops outside of the kernel."""
    return bool(mark) and "contacts" not in mark


class Standing(Protocol):
    """What the march knows of a leg."""

    system: System
    variants: Variants
    contacts: Contacts
    shared: tuple[str, ...]
    whole: Leg
    meets_inside: bool


#: What frictions and stops are marked as.
MARKED = ("idle", "straight", "starting")
#: What the kernel's contact policy and the march know alike.
KNOWN = ("push", "fastest", "met_at", "met_often")


def inside_of(at: Standing) -> Inside | None:
    """What the kernel's loop does itself from here on; None where the march does it."""
    if not at.meets_inside or _bears_what_varies(at.system, at.contacts):
        return None
    known = {name: getattr(at, name) for name in KNOWN} | _known(at.system, at.contacts)
    known |= {"lost": 0.0, "work": 0.0, "events": 0, "rubbed": [0.0] * len(at.system.names.frictions)}
    number = {name: k for k, name in enumerate(_named(at.system, at.variants.compiled))}
    known["shared"] = [number[name] for name in at.shared if name in number]
    return Inside(at.system, at.variants, THRESHOLDS.look_spacing * at.whole.interval, known)


def _bears_what_varies(system: System, contacts: Contacts) -> bool:
    """Whether a friction bears a part of a static force that changes in the run."""
    frictions, shares = system.frictions, {k for k, part in contacts.bearing.items() if part}
    return frictions is not None and any(frictions.bound_of(k, 0) >= 0 for k in shares)


def _named(system: System, compiled: Compiled) -> list[str]:
    """What shares a load, by the kernel's numbers: stops, frictions, joints."""
    own = takewhile(lambda joint: joint < len(system.names.joints), map(compiled.joint, count()))
    joints = [system.names.joints[joint] for joint in own]
    parts = {"stop": system.names.stops, "friction": system.names.frictions, "joint": joints}
    return [f"{what} '{name}'" for what, names in parts.items() for name in names]


def _known(system: System, contacts: Contacts) -> dict[str, Any]:
    """Contacts as the kernel has them: what sticks at a wall is stuck there."""
    at, stuck, bearing = walls(system, contacts), dict(contacts.stuck), dict(contacts.bearing)
    for stop, k in at.items():
        assert system.stops is not None
        stuck[k] = float(system.stops.bound[stop])
        bearing.pop(k, None)
    numbered = {"sliding": contacts.sliding, "stuck": stuck, "pushing": contacts.pushing, "bearing": bearing}
    return {
        "held": list(contacts.held),
        **{name: [*each.items()] for name, each in numbered.items()},
        **{name: sorted(getattr(contacts, name)) for name in MARKED},
        "shares": [(k, list(parts)) for k, parts in contacts.shares.items()],
        "decides": contacts.decides,
    }


def _stop_laws(system: System) -> list[tuple[float, ...]]:
    """Of each stop its side, restitution, slack and size; of one that gives way its law, and what its damping goes
    by."""
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
    """Of each friction the number of its law while all slide, its bearing, static and sliding force, Stribeck speed and
    size. Of one at a stop that stop, and its partner; then the function by which it holds, or -1."""
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
    """All stops that give way as laws, whose damping by a restitution is that at r = 1: the kernel scales the rate."""
    stops = system.stops
    if stops is None:
        return {}
    by = np.where(np.isnan(stops.restitution), stops.damping, 1.0)
    return {k: float(by[k]) for k in np.flatnonzero(~stops.is_rigid).tolist()}


@dataclass
class Inside:
    """Scratch of a leg: what the kernel's contact policy has saved, `state`; whether the leg `halts` before it meets
    anything; and what the policy has left over, if anything."""

    system: System
    variants: Variants
    spacing: float
    state: dict[str, Any]
    halts: bool = False
    left_over: Meaning | None = None

    @property
    def laws(self) -> Contacts:
        """All frictions and stops that give way are laws: the kernel takes the part of each that counts."""
        sliding = dict.fromkeys(range(len(self.system.names.frictions)), 1.0)
        return Contacts(pushing=_all_push(self.system), sliding=sliding)

    def tell(self, at: Standing) -> None:
        """The march knows where the kernel's loop has left the contacts."""
        at.contacts = self._contacts(self.state)
        names = _named(self.system, self.variants.compiled)
        at.shared = tuple(names[k] for k in self.state["shared"])
        for name in KNOWN:
            setattr(at, name, self.state[name])

    def _contacts(self, state: Mapping[str, Any]) -> Contacts:
        held, stuck = tuple(sorted(state["held"])), dict(state["stuck"])
        found = Contacts(
            held,
            dict(state["pushing"]),
            dict(state["sliding"]),
            stuck,
            dict(state.get("bearing", ())),
            shares={k: tuple((own, part) for own, part in parts) for k, parts in state.get("shares", ())},
            decides=bool(state.get("decides", False)),
            **{name: frozenset(state.get(name, ())) for name in MARKED},
        )
        return at_walls(self.system, found, held)

    def variant(self, contacts: Mapping[str, Any], state: State) -> Variant:
        """The mechanism with the contacts that a mark of the kernel's has."""
        return self.variants.anew().of(self._contacts(contacts), state)

    def begin(self, run: Any) -> None:
        """The kernel's run, before its first step."""
        law = "newton" if self.system.stops is None else self.system.stops.impact_law
        laws = _stop_laws(self.system), _friction_laws(self.system)
        run.begin_contacts(*laws, self.state, self.spacing, list(LAWS).index(law))
        if self.halts:
            run.halt_at_contacts()

    def take(self, run: Any) -> list[Event]:
        """What was recorded since the last call; the run stands where it stands."""
        self.state = run.contacts
        number, released = run.left_over
        stops = len(self.system.names.stops)
        self.left_over = None
        if number >= stops:
            self.left_over = Meaning(friction=number - stops, rest=not released)
        elif number >= 0:
            self.left_over = Meaning(stop=number, released=released)
        return [Event(t, self._name(k, what[0]), *what) for t, k, *what in run.take_contact_events()]

    def _name(self, number: int, what: str) -> str:
        """What an event calls a stop, a friction or a joint: of both tangents at a stop the force that it is."""
        frictions, k = self.system.frictions, number - len(self.system.names.stops)
        if what != SHARED and frictions is not None and 0 <= k < frictions.size and frictions.stop[k] >= 0:
            name = frictions.owners[k].split("'")[1]
            return f"friction '{name}'"
        return _named(self.system, self.variants.compiled)[number]

    def jumps(self, work: Array) -> Array:
        """What motions have worked, and impacts and each friction in them have lost since the leg began, J."""
        rubbed = self.state["rubbed"][: len(self.system.names.frictions)]
        return np.array([self.state["work"], self.state["lost"], *rubbed])

    def samples(self, samples: Samples, block: Mapping[str, Any]) -> Samples:
        """A block of samples with what contacts do: how hard stops push and frictions hold is known."""
        stops, pushes = len(self.system.names.stops), np.asarray(block["pushes"])
        compiled = self.variants.compiled
        side = np.ones(0) if self.system.stops is None else self.system.stops.side
        forces = np.ascontiguousarray(pushes * np.append(side, np.ones(pushes.shape[1] - stops)))
        return replace(
            samples,
            work=samples.work + block["jumps"],
            solved=lambda _: compiled.multipliers(samples, forces),
            press=None if self.system.stops is None else lambda: pushes[:, :stops],
            rub=None if self.system.frictions is None else lambda: (pushes[:, stops:], block["slides"][:, stops:]),
        )
