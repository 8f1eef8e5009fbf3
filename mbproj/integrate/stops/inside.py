"""Rigid stops without friction in the kernel's own loop: it finds when they are met, and does what happens there.
What it leaves over is for `march`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.dynamics.contact.inside import stop_sizes
from mbproj.dynamics.observe.samples import Samples
from mbproj.integrate.events.leg import Leg
from mbproj.integrate.events.time_events import Event
from mbproj.integrate.formulations.choice import Choice
from mbproj.integrate.outcome.marks import Mark
from mbproj.integrate.stops.variants import Variants
from mbproj.integrate.stops.watching import Meaning
from mbproj.model.contacts import Contacts
from mbproj.model.system import System
from mbproj.registry import PROJECTIONS, implicit_integrators
from mbproj.scene.records import ProjectionSettings, Settings
from mbproj.thresholds import THRESHOLDS


def meets_inside(choice: Choice, system: System, settings: Settings) -> bool:
    """Whether the kernel's loop itself does what happens at the stops: rigid ones without friction, with Newton's
    law, in explicit steps that end on the constraints, where every motion has inertia."""
    stops = system.stops
    if choice.compiled is None or stops is None or stops.impact_law != "newton" or system.frictions is not None:
        return False
    heavy = bool((system.mass > 0.0).all()) and np.linalg.eigvalsh(system.inertia)[:, 0].min(initial=np.inf) > 0.0
    pays = not (system.driven and system.reflected.inertia.size)  # what motions pay for flywheels in no time
    explicit = settings.integrator not in implicit_integrators()
    return bool(stops.is_rigid.all()) and heavy and pays and explicit and _ends_closed(settings.projection)


def _ends_closed(projection: ProjectionSettings) -> bool:
    """Whether every step ends on the constraints, in positions and velocities."""
    corrects = PROJECTIONS[projection.method].correction in ("mass", "coordinates")
    both = projection.position and projection.velocity and projection.test == "violation"
    return corrects and both and projection.every == 1 and projection.threshold is None


def is_of_the_march(mark: Mark, contacts: Contacts) -> bool:
    """Whether a run goes on from where an older mbproj has met stops outside of the kernel."""
    return bool(mark) and "contacts" not in mark and contacts == Contacts(contacts.held)


class Standing(Protocol):
    """What the march knows of a leg."""

    system: System
    variants: Variants
    contacts: Contacts
    whole: Leg
    meets_inside: bool


#: What the kernel's contact policy and the march know alike.
KNOWN = ("push", "fastest", "met_at", "met_often")


def inside_of(at: Standing) -> Inside | None:
    """What the kernel's loop does itself from here on; None where the march does it, since contacts share a load."""
    stops, interval = at.system.stops, at.whole.interval
    if stops is None or not at.meets_inside or at.contacts != Contacts(at.contacts.held):
        return None
    sizes = stop_sizes(at.system)
    laws = np.column_stack([stops.side, stops.restitution, THRESHOLDS.stop_slack * sizes, sizes])
    known = {name: getattr(at, name) for name in KNOWN}
    known |= {"held": list(at.contacts.held), "lost": 0.0, "work": 0.0, "events": 0}
    own = [tuple(each) for each in laws.tolist()]
    return Inside(at.variants, own, THRESHOLDS.look_spacing * interval, known, at.system.names.stops)


@dataclass
class Inside:
    """Scratch of a leg: the stops' `laws` as the kernel has them, side, restitution, slack and size; what the kernel's
    contact policy has saved, `state`; and what it has left over, if anything."""

    variants: Variants
    laws: list[tuple[float, ...]]
    spacing: float
    state: dict[str, Any]
    names: tuple[str, ...]
    left_over: Meaning | None = None

    def tell(self, at: Standing) -> None:
        """The march knows where the kernel's loop has left the contacts."""
        at.contacts = self.contacts
        for name in KNOWN:
            setattr(at, name, self.state[name])

    def begin(self, run: Any) -> None:
        """The kernel's run, before its first step."""
        run.begin_contacts(self.laws, self.state, self.spacing)

    def take(self, run: Any) -> list[Event]:
        """What was recorded since the last call; the run stands where it stands."""
        self.state = run.contacts
        stop, released = run.left_over
        self.left_over = None if stop < 0 else Meaning(stop=stop, released=released)
        return [Event(t, f"stop '{self.names[k]}'", *what) for t, k, *what in run.take_contact_events()]

    @property
    def contacts(self) -> Contacts:
        """Those that hold."""
        return Contacts(tuple(sorted(self.state["held"])))

    @property
    def jumps(self) -> Array:
        """The work of motions and the loss of impacts since the leg began, (2,), in J."""
        return np.array([self.state["work"], self.state["lost"]])

    def samples(self, samples: Samples, block: Mapping[str, Any]) -> Samples:
        """A block of samples with what contacts do: how hard stops push is known."""
        return replace(
            samples,
            work=samples.work + block["jumps"],
            solved=lambda _: self._multipliers(samples, block),
            press=lambda: np.asarray(block["pushes"]),
        )

    def _multipliers(self, samples: Samples, block: Mapping[str, Any]) -> Array:
        """λ of the joints and motions, (T, m): those of the mechanism whose joints have the rows that are held."""
        parts = dict(self._of_each(samples, block))
        found = np.zeros((len(samples.t), next(iter(parts.values())).shape[1]))
        for which, multipliers in parts.items():
            found[list(which)] = multipliers
        return found

    def _of_each(self, samples: Samples, block: Mapping[str, Any]) -> Iterator[tuple[tuple[int, ...], Array]]:
        """Which samples have the same contacts, and their multipliers."""
        held = np.asarray(block["held"], dtype=bool)
        for each in np.unique(held, axis=0):
            which, stops = np.flatnonzero((held == each).all(axis=1)), np.flatnonzero(each)
            variant = self.variants.of(Contacts(tuple(stops.tolist())), samples.state(int(which[0])))
            first = variant.free.joints.size
            carried = block["multipliers"][which]
            compiled = variant.choice.compiled
            if compiled is None or variant.free.stops is None:
                yield tuple(which.tolist()), carried
                continue
            if compiled.name == "reduced":
                alone = -variant.free.stops.side[stops] * block["pushes"][np.ix_(which, stops)]
                carried = np.insert(carried, [first] * len(stops), alone, axis=1)
            own = np.arange(first, first + len(stops))
            chosen = replace(samples, carried=carried, **{name: getattr(samples, name)[which] for name in _OF_A_SAMPLE})
            yield tuple(which.tolist()), np.delete(compiled.multipliers(chosen), own, axis=1)


#: What `Samples` has of each sample that its multipliers depend on.
_OF_A_SAMPLE = ("t", "y", "acceleration")
