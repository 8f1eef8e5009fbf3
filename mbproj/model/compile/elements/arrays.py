"""Elements as arrays: what they add to a system."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.elements.controlled import Controller, Signal
from mbproj.elements.element import Element, Force, called
from mbproj.errors import InputError, Problem
from mbproj.functions.program import CHANNELS, COORDINATE, RATE, TIME, Code, Op, Program, apply, number, replaced
from mbproj.functions.program_set import flatten, joined
from mbproj.model.added_laws import AddedLaw, with_laws
from mbproj.model.channels import ElementStates, Energies
from mbproj.model.compile.coupled import bound
from mbproj.model.compile.elements.controllers import actions_of, read_by
from mbproj.model.compile.elements.measured import measurable, with_measured
from mbproj.model.compile.elements.named import Named
from mbproj.model.couplings import compile_couplings
from mbproj.model.frictions import Frictions
from mbproj.model.primitive_set import bind, bindings
from mbproj.model.system import System
from mbproj.scene.coupled import Coupled
from mbproj.scene.expressions.compiled import compiled
from mbproj.scene.expressions.syntax_tree import parse
from mbproj.scene.expressions.tokens import ExpressionError
from mbproj.scene.text.suggestions import choose_from

#: What every expression may name beside the channels that are read.
VARIABLES = {"t": TIME, "s": COORDINATE, "s_dot": RATE}


def with_elements(
    system: System, elements: Sequence[Element], signals: Sequence[Signal] = (), controllers: Sequence[Controller] = ()
) -> System:
    """The system with these elements, signals that its functions name, and what controllers do. Raises InputError that
    names what an element or a function reads and that there is not, or a row whose function cannot be one."""
    states = [(named_within(element, state.name), state) for element in elements for state in element.states]
    names = replace(
        system.names,
        states=(*system.names.states, *(name for name, _ in states)),
        state_units=(*system.names.state_units, *(state.unit for _, state in states)),
        signals=tuple(signal.name for signal in signals),
        signal_units=tuple(signal.unit for signal in signals),
    )
    system = replace(system, names=names)
    system = with_measured(system, elements, [*_read(system, elements, signals), *read_by(controllers)])
    others = measurable(system, elements)
    channels = Named(system, {each.name: each.program for each in signals}, [*others], dict(_pushes(elements)))
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
        joined([system.energies.lost, flatten([*_lost(elements, named)])]),
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
        states=_after(system.states, own),
        signals=shown,
    )
    return _with_rows(_with_forces(system, elements, pushes), elements)


def _frictions(system: System, channels: Named) -> Frictions | None:
    """Those of a system, with its channels in what they go by."""
    own = system.frictions
    if own is None or not own.varies:
        return own

    def resolved(k: int, sliding: Program, static: Program) -> tuple[Program, Program]:
        found = channels.resolved(sliding, own.owners[k])
        return found, found if static is sliding else channels.resolved(static, own.owners[k])

    return replace(own, varies={k: resolved(k, *pair) for k, pair in own.varies.items()})


def named_within(element: Element, name: str) -> str:
    """What results call a part of an element: by both names; those of the scene itself have no element's."""
    return f"{element.name}.{name}" if element.name else name


def _read(system: System, elements: Sequence[Element], signals: Sequence[Signal]) -> Iterator[str]:
    """What functions of a scene name beside those of elements."""
    yield from (name for programs in system.forces.programs.reads for name in programs)
    for programs in () if system.frictions is None else system.frictions.varies.values():
        yield from (name for program in programs for name in program.reads)
    rates = [state.rate for element in elements for state in element.states]
    for program in (*(signal.program for signal in signals), *rates):
        yield from program.reads if isinstance(program, Program) else ()


def _pushes(elements: Sequence[Element]) -> Iterator[tuple[str, tuple[str, Callable[[Named], Program]]]]:
    """What forces that have a name of their own give, once what their elements read has its channels."""

    def push(channels: Named, element: Element, force: Force) -> Program:
        return _Naming(element, channels, channels.of_element(element))(force.push)

    for element in elements:
        for force in element.forces:
            if force.name:
                yield force.name, (force.along, partial(push, element=element, force=force))


def _lost(elements: Sequence[Element], named: Mapping[str, _Naming]) -> Iterator[Program]:
    """What elements lose beside what their forces lose: less by what an element stores whose forces all lose."""
    for element in elements:
        if element.lost:
            yield named[element.name](element.lost)
        elif element.stores and element.forces and all(force.loses for force in element.forces):
            kept = named[element.name](element.stores)
            yield replace(kept, code=apply(Op.SUBTRACT, number(0.0), kept.code))


def _after(before: ElementStates, own: ElementStates) -> ElementStates:
    """States after others."""
    parts = before, own
    start, scale, counts = (
        np.concatenate([getattr(part, name) for part in parts]) for name in ("start", "scale", "counts")
    )
    return ElementStates(start, scale, joined([part.programs for part in parts]), counts)


@dataclass(frozen=True, eq=False)
class _Naming:
    """What the programs of an element see: the codes of what it reads, and how expressions call them."""

    element: Element
    channels: Named
    codes: tuple[Code, ...]

    def __call__(self, program: Program | str, of: str = "") -> Program:
        """The program `of` a part, with the system's channels. Raises InputError where it is an expression that cannot
        be read."""
        if isinstance(program, str):
            reads = {called(name): CHANNELS + at for at, name in enumerate(self.element.reads)}
            program = _program(self.element, program, VARIABLES | reads)
        if program.reads:
            return self.channels.resolved(program, of or f"element '{self.element.name}'")
        return replace(program, code=replaced(program.code, dict(enumerate(self.codes, CHANNELS))))


def _program(element: Element, text: str, variables: Mapping[str, int]) -> Program:
    try:
        return Program(compiled(parse(text), {}, variables)[0], text)
    except ExpressionError as error:
        raise InputError(Problem(f"element '{element.name}': '{text}': {error}", hint=error.hint)) from error


def _with_forces(system: System, elements: Sequence[Element], pushes: Sequence[Sequence[Program]]) -> System:
    """With the laws of the elements, whose programs are these."""
    names, own = system.names, bindings(system.coordinates)
    forces = [(element, force) for element in elements for force in element.forces]
    programs = [program for own in pushes for program in own]
    if not forces:
        return system
    at = [_coordinate(system, element, force.along) for element, force in forces]
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


def _with_rows(system: System, elements: Sequence[Element]) -> System:
    """With the rows of the elements, each a joint of its own."""
    rows = [(element, row) for element in elements for row in element.rows]
    if not rows:
        return system
    names, own, coordinates = system.names, bindings(system.joints), bindings(system.coordinates)
    body, local = system.reaction_body.tolist(), system.reaction_local.tolist()
    for element, row in rows:
        parts = [coordinates[_coordinate(system, element, name)] for name in row.of]
        function = _program(element, row.function, VARIABLES) if isinstance(row.function, str) else row.function
        coupled = Coupled(dict(row.of), function, row.constant, row.period)
        own.append(bound(f"row '{element.name}.{row.name}'", coupled, row.constant, parts, len(body)))
        body.append(next(body for body, side, _ in reversed(own[-1].slots) if side == 2))
        local.append([0.0] * 3)
    return replace(
        system,
        names=replace(names, joints=(*names.joints, *(f"{element.name}.{row.name}" for element, row in rows))),
        joints=bind(own),
        couplings=compile_couplings(own, coordinates),
        reaction_body=np.array(body, dtype=np.intp),
        reaction_local=np.array(local).reshape(-1, 3),
        joint_places=(*system.joint_places, *(None for _ in rows)),
    )


def _coordinate(system: System, element: Element, name: str) -> int:
    """The number of a joint coordinate."""
    able = system.names.coordinates
    if name not in able:
        what = f"element '{element.name}' acts on '{name}', which there is not"
        raise InputError(Problem(what, hint=choose_from(name, [*able, *measurable(system, [element])])))
    return able.index(name)
