"""The mechanism with its contacts, ready to run."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

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

#: The stops that hold rows of C, and the frictions with the values at which they do.
Rows: TypeAlias = tuple[tuple[int, ...], tuple[tuple[int, float], ...]]
NO_ROWS: Rows = ((), ())


@dataclass(frozen=True, eq=False)
class Variant:
    """A mechanism while these stops touch and frictions stick and slide, and how it runs; `free` is it without them."""

    contacts: Contacts
    free: System
    system: System
    choice: Choice


class Variants:
    """Scratch of a run: the variants that it has met, by the rows that stops and frictions hold. Compliant stops and
    frictions that slide are laws, which leave the rest as it is."""

    def __init__(self, free: Choice, system: System, settings: Settings) -> None:
        self._system = system
        in_plane = free.name == "planar"  # contacts have no say in what is planar
        self._settings = settings if in_plane else replace(settings, formulation=free.name)
        self._by_rows: dict[Rows, Choice] = {NO_ROWS: free}
        #: Where each choice was made but the first: a run that goes on makes the same.
        self.chosen_at: dict[Rows, State] = {}

    @property
    def compiled(self) -> Compiled:
        """The equations in the kernel, without contacts."""
        found = self._by_rows[NO_ROWS].compiled
        assert found is not None
        return found

    def anew(self) -> Variants:
        """Without those that were met, to look at some that are not run."""
        return Variants(self._by_rows[NO_ROWS], self._system, self._settings)

    def of(self, contacts: Contacts, state: State) -> Variant:
        """The one for these contacts. Raises SimulationError where its equations have no unique solution."""
        system = in_contact(self._system, contacts)
        rows = contacts.held, tuple(contacts.stuck.items())
        if rows not in self._by_rows:
            if contacts.stuck:  # those that were are not met again
                self._by_rows, self.chosen_at = {NO_ROWS: self._by_rows[NO_ROWS]}, {}
            self.choose(rows, state)
        choice = self._by_rows[rows]
        if (
            contacts.pushing or contacts.sliding or contacts.bearing or contacts.shares
        ) and choice.compiled is not None:
            choice = replace(choice, compiled=_again(choice.compiled, system))
        return Variant(contacts, self._system, system, choice)

    def choose(self, rows: Rows, state: State) -> None:
        """How the mechanism runs while these rows are held, chosen at a state. Raises SimulationError as `of` does."""
        held, stuck = rows
        self._by_rows[rows] = self._chosen(in_contact(self._system, Contacts(held, stuck=dict(stuck))), state)
        self.chosen_at[rows] = state

    def _chosen(self, system: System, state: State) -> Choice:
        try:
            return choose(system, state, self._settings)
        except InputError as error:
            cause = f"with a stop in contact, or a friction that sticks: {error.problems[0].message}"
            raise SimulationError(state.t, cause) from error


def _again(compiled: Compiled, system: System) -> Compiled:
    """The same equations with other forces."""
    found: Compiled
    if isinstance(compiled, InPlane):
        found = InPlane(compiled.core, system, compiled.plane)
    else:
        found = Reduced(compiled.core, system)
    found.model.rows = compiled.model.rows
    return found
