"""The mechanism with its contacts, ready to run."""

from __future__ import annotations

from dataclasses import replace

from mbproj.dataclass import dataclass
from mbproj.dynamics.assembly.assemble import State
from mbproj.errors import InputError, SimulationError
from mbproj.integrate.formulations.choice import Choice, choose
from mbproj.integrate.formulations.compiled import Compiled
from mbproj.integrate.formulations.planar import InPlane
from mbproj.integrate.formulations.reduced import Reduced
from mbproj.model.contacts import Contacts, in_contact
from mbproj.model.system import System
from mbproj.scene.records import Settings


@dataclass(frozen=True, eq=False)
class Variant:
    """A mechanism while these stops touch, and how it runs."""

    contacts: Contacts
    system: System
    choice: Choice


class Variants:
    """Scratch of a run: the variants that it has met, by the stops that are held. The damping of compliant stops is
    another one in each contact; it is a number in a law and leaves the rest as it is."""

    def __init__(self, free: Choice, system: System, settings: Settings) -> None:
        self._system, self._settings = system, settings
        self._by_held: dict[tuple[int, ...], Choice] = {(): free}

    def of(self, contacts: Contacts, state: State) -> Variant:
        """The one for these contacts. Raises SimulationError where its equations have no unique solution."""
        system = in_contact(self._system, contacts)
        if contacts.held not in self._by_held:
            self._by_held[contacts.held] = self._chosen(in_contact(self._system, Contacts(contacts.held)), state)
        choice = self._by_held[contacts.held]
        if contacts.pushing and choice.compiled is not None:
            choice = replace(choice, compiled=_again(choice.compiled, system))
        return Variant(contacts, system, choice)

    def _chosen(self, system: System, state: State) -> Choice:
        try:
            return choose(system, state, self._settings)
        except InputError as error:
            raise SimulationError(state.t, f"with a stop in contact: {error.problems[0].message}") from error


def _again(compiled: Compiled, system: System) -> Compiled:
    """The same equations with other forces."""
    redundant = compiled.model.redundant
    found: Compiled
    if isinstance(compiled, InPlane):
        found = InPlane(compiled.core, system, compiled.plane)
    else:
        found = Reduced(compiled.core, system)
    found.model.redundant = redundant
    return found
