"""Adds elements, signals and controllers to a system."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.elements.controlled import Controller, Signal
from mbproj.elements.element import Element, Force, called
from mbproj.functions.program import CHANNELS, Code, Op, Program, apply, number, replaced
from mbproj.functions.program_set import flatten, joined
from mbproj.model.added_laws import AddedLaw, with_laws
from mbproj.model.channels import ElementStates, Energies
from mbproj.model.compile.elements.controllers import actions_of, read_by
from mbproj.model.compile.elements.measured import coordinate_of, measurable, with_measured
from mbproj.model.compile.elements.named import VARIABLES, NamesOfSystem, expression_of, named_within
from mbproj.model.compile.elements.rows import with_inertias, with_rows
from mbproj.model.frictions import Frictions
from mbproj.model.primitive_set import bindings
from mbproj.model.system import System


def with_elements(
    system: System, elements: Sequence[Element], signals: Sequence[Signal] = (), controllers: Sequence[Controller] = ()
) -> System:
    """Return the system with these elements, signals and controllers. Raises InputError where an element or a function
    names something that does not exist, or the function of a row is not admissible."""
    states = [(named_within(element, state.name), state) for element in elements for state in element.states]
    names = replace(
        system.names,
        states=(*system.names.states, *(name for name, _ in states)),
        state_units=(*system.names.state_units, *(state.unit for _, state in states)),
        signals=tuple(signal.name for signal in signals),
        signal_units=tuple(signal.unit for signal in signals),
    )
    system = replace(system, names=names)
    system = with_measured(system, elements, [*_names_read(system, elements, signals), *read_by(controllers)])
    others = measurable(system, elements)
    channels = NamesOfSystem(
        system, {each.name: each.program for each in signals}, [*others], dict(_named_forces(elements))
    )
    named = {element.name: _Naming(element, channels, channels.of_element(element)) for element in elements}
    forces = replace(
        system.forces, programs=channels.resolved_set(system.forces.programs, system.forces.program_owners)
    )
    own = ElementStates(
        np.array([state.start for _, state in states]),
        np.array([state.scale for _, state in states]),
        flatten([named[each.name](part.rate, f"state '{part.name}'") for each in elements for part in each.states]),
        np.array([state.counts for _, state in states], dtype=bool),
    )
    energies = Energies(
        joined([system.energies.stored, flatten([named[each.name](each.stores) for each in elements if each.stores])]),
        joined([system.energies.lost, flatten([*_losses(elements, named)])]),
    )
    pushes = [[named[element.name](force.push) for force in element.forces] for element in elements]
    shown = flatten([channels.resolved(signal.program, f"signal '{signal.name}'") for signal in signals])
    actions = actions_of(controllers, channels, system.names.states)
    system = replace(
        system,
        actions=actions,
        forces=forces,
        frictions=_frictions(system, channels),
        channels=channels.channels,
        energies=energies,
        states=_states_after(system.states, own),
        signals=shown,
    )
    return with_inertias(with_rows(_with_forces(system, elements, pushes), elements), elements)


def _frictions(system: System, channels: NamesOfSystem) -> Frictions | None:
    """Return the dry frictions of a system, with channels in place of names in their functions."""
    own = system.frictions
    if own is None or not own.varies:
        return own

    def resolved(k: int, sliding: Program, static: Program) -> tuple[Program, Program]:
        found = channels.resolved(sliding, own.owners[k])
        return found, found if static is sliding else channels.resolved(static, own.owners[k])

    return replace(own, varies={k: resolved(k, *pair) for k, pair in own.varies.items()})


def _names_read(system: System, elements: Sequence[Element], signals: Sequence[Signal]) -> Iterator[str]:
    """The names that functions of a scene read; elements list those of their own functions themselves."""
    yield from (name for programs in system.forces.programs.reads for name in programs)
    for programs in () if system.frictions is None else system.frictions.varies.values():
        yield from (name for program in programs for name in program.reads)
    rates = [state.rate for element in elements for state in element.states]
    for program in (*(signal.program for signal in signals), *rates):
        yield from program.reads if isinstance(program, Program) else ()


def _named_forces(elements: Sequence[Element]) -> Iterator[tuple[str, tuple[str, Callable[[NamesOfSystem], Program]]]]:
    """The forces of elements that have names, as functions: the coordinate each acts along, and its program once the
    names that its element reads have channels."""

    def push(channels: NamesOfSystem, element: Element, force: Force) -> Program:
        return _Naming(element, channels, channels.of_element(element))(force.push)

    for element in elements:
        for force in element.forces:
            if force.name:
                yield force.name, (force.along, partial(push, element=element, force=force))


def _losses(elements: Sequence[Element], named: Mapping[str, _Naming]) -> Iterator[Program]:
    """The energies lost by elements, beside those lost by their forces. Where all forces of an element lose energy, its
    stored energy is subtracted."""
    for element in elements:
        if element.lost:
            yield named[element.name](element.lost)
        elif element.stores and element.forces and all(force.loses for force in element.forces):
            kept = named[element.name](element.stores)
            yield replace(kept, code=apply(Op.SUBTRACT, number(0.0), kept.code))


def _states_after(before: ElementStates, own: ElementStates) -> ElementStates:
    """Return the states `own` after the states `before`."""
    parts = before, own
    start, scale, counts = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("start", "scale", "counts")
    )
    return ElementStates(start, scale, joined([part.programs for part in parts]), counts)


@dataclass(frozen=True, eq=False)
class _Naming:
    """Resolves the names in the programs of an element: `codes` are the codes of the names that the element reads."""

    element: Element
    channels: NamesOfSystem
    codes: tuple[Code, ...]

    def __call__(self, program: Program | str, of: str = "") -> Program:
        """Return a program of the element with the system's channels; `of` names the part, for messages. Raises
        InputError where it is an expression that cannot be read."""
        if isinstance(program, str):
            reads = {called(name): CHANNELS + at for at, name in enumerate(self.element.reads)}
            program = expression_of(self.element, program, VARIABLES | reads)
        if program.reads:
            return self.channels.resolved(program, of or f"element '{self.element.name}'")
        return replace(program, code=replaced(program.code, dict(enumerate(self.codes, CHANNELS))))


def _with_forces(system: System, elements: Sequence[Element], pushes: Sequence[Sequence[Program]]) -> System:
    """Return the system with the forces of the elements as laws, whose programs are `pushes`."""
    names, own = system.names, bindings(system.coordinates)
    forces = [(element, force) for element in elements for force in element.forces]
    programs = [program for own in pushes for program in own]
    if not forces:
        return system
    at = [coordinate_of(system, element, force.along) for element, force in forces]
    added = [
        AddedLaw(own[row], row, program, element.name, loses=force.loses)
        for row, program, (element, force) in zip(at, programs, forces, strict=True)
    ]
    laws = system.forces.laws.size
    shown = tuple(force.name or f"{element.name}.{force.along}" for element, force in forces)
    names = replace(
        names,
        forces=(*names.forces[:laws], *shown, *names.forces[laws:]),
        force_units=(
            *names.force_units[:laws],
            *(names.coordinate_units[row] for row in at),
            *names.force_units[laws:],
        ),
    )
    return replace(system, forces=with_laws(system.forces, added), names=names)
