"""Elements as arrays: what they add to a system."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.elements.element import Element, called
from mbproj.errors import InputError, Problem
from mbproj.functions.program import CHANNELS, COORDINATE, RATE, TIME, Code, Op, Program, apply, number, variable
from mbproj.functions.program_set import flatten, joined
from mbproj.model.added_laws import AddedLaw, with_laws
from mbproj.model.channels import Channels, ElementStates, Energies, Kind
from mbproj.model.compile.coupled import bound
from mbproj.model.compile.measured import measurable, with_measured
from mbproj.model.couplings import compile_couplings
from mbproj.model.primitive_set import bind, bindings
from mbproj.model.system import System
from mbproj.scene.coupled import Coupled
from mbproj.scene.expressions.compiled import compiled
from mbproj.scene.expressions.syntax_tree import parse
from mbproj.scene.expressions.tokens import ExpressionError
from mbproj.scene.text.suggestions import choose_from

#: What every expression may name beside the channels that are read.
VARIABLES = {"t": TIME, "s": COORDINATE, "s_dot": RATE}


def with_elements(system: System, elements: Sequence[Element]) -> System:
    """The system with these elements. Raises InputError that names what an element reads and that there is not, or a
    row whose function cannot be one."""
    states = [(f"{element.name}.{state.name}", state) for element in elements for state in element.states]
    names = replace(
        system.names,
        states=(*system.names.states, *(name for name, _ in states)),
        state_units=(*system.names.state_units, *(state.unit for _, state in states)),
    )
    system = with_measured(replace(system, names=names), elements)
    channels, named = _channels(system, elements)
    own = ElementStates(
        np.array([state.start for _, state in states]),
        np.array([state.scale for _, state in states]),
        flatten([named[element.name](state.rate) for element in elements for state in element.states]),
    )
    energies = Energies(
        joined([system.energies.stored, flatten([named[each.name](each.stores) for each in elements if each.stores])]),
        joined([system.energies.lost, flatten([*_lost(elements, named)])]),
    )
    system = replace(system, channels=channels, energies=energies, states=_after(system.states, own))
    return _with_rows(_with_forces(system, elements, named), elements)


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
    start, scale = (np.concatenate([getattr(part, name) for part in parts]) for name in ("start", "scale"))
    return ElementStates(start, scale, joined([part.programs for part in parts]))


def _channels(system: System, elements: Sequence[Element]) -> tuple[Channels, dict[str, _Naming]]:
    """All channels that functions name, and how the programs of each element name them."""
    names = system.names
    able = {name: (Kind.STATE, at) for at, name in enumerate(names.states)}
    able |= {name: (Kind.COORDINATE, at) for at, name in enumerate(names.coordinates)}
    able |= {f"{name}_dot": (Kind.RATE, at) for at, name in enumerate(names.coordinates)}
    known = zip(system.channels.kind.tolist(), system.channels.index.tolist(), strict=True)
    found = {(Kind(kind), index): at for at, (kind, index) in enumerate(known)}
    laws = {f"{name}.force": at for at, name in enumerate(names.forces[: system.forces.laws.size])}

    def channel(kind: Kind, index: int) -> Code:
        return variable(CHANNELS + found.setdefault((kind, index), len(found)))

    named, problems = dict[str, _Naming](), []
    for element in elements:
        codes = []
        for name in element.reads:
            if name in able:
                codes.append(channel(*able[name]))
            elif name in laws:
                codes.append(_force(system, laws[name], channel))
            else:
                what = f"element '{element.name}' reads '{name}', which there is not"
                problems.append(Problem(what, hint=choose_from(name, [*able, *laws, *measurable(system, elements)])))
        named[element.name] = _Naming(element, tuple(codes))
    if problems:
        raise InputError(problems)
    return Channels.of(list(found)), named


def _force(system: System, law: int, channel: Callable[[Kind, int], Code]) -> Code:
    """F = -k (s - free) - c s' + program(t, s, s') of a law, by channels. Raises InputError where it goes by a load."""
    own, name = system.forces.laws, system.names.forces[law]
    if own.bearing[law] >= 0 or own.partner[law] >= 0:
        what = f"the force of '{name}' cannot be read: it goes by a load, which would depend on what reads it"
        raise InputError(Problem(what, hint="read what the load comes from: a coordinate, a spring's force"))
    at = int(own.joint_coordinate[law])
    at = at if at >= 0 else system.names.coordinates.index(f"{name}.length")
    s, rate = channel(Kind.COORDINATE, at), channel(Kind.RATE, at)
    stretch = apply(Op.SUBTRACT, s, number(float(own.free[law])))
    total = apply(Op.MULTIPLY, number(-float(own.stiffness[law])), stretch) if own.stiffness[law] else number(0.0)
    if own.damping[law]:
        total = apply(Op.SUBTRACT, total, apply(Op.MULTIPLY, number(float(own.damping[law])), rate))
    if own.program[law] < 0:
        return total
    program = system.forces.programs.program(int(own.program[law]))
    return apply(Op.ADD, total, _replaced(program.code, {COORDINATE: s, RATE: rate}))


def _replaced(code: Code, by: Mapping[int, Code]) -> Code:
    """The code with other codes in place of these variables."""
    return tuple(
        one for each in code for one in (by.get(int(each.operand), (each,)) if each.op is Op.VARIABLE else (each,))
    )


@dataclass(frozen=True, eq=False)
class _Naming:
    """What the programs of an element see: the codes of what it reads, and how expressions call them."""

    element: Element
    codes: tuple[Code, ...]

    def __call__(self, program: Program | str) -> Program:
        """The program with the system's channels. Raises InputError where it is an expression that cannot be read."""
        if isinstance(program, str):
            reads = {called(name): CHANNELS + at for at, name in enumerate(self.element.reads)}
            program = _program(self.element, program, VARIABLES | reads)
        return replace(program, code=_replaced(program.code, dict(enumerate(self.codes, CHANNELS))))


def _program(element: Element, text: str, variables: Mapping[str, int]) -> Program:
    try:
        return Program(compiled(parse(text), {}, variables)[0], text)
    except ExpressionError as error:
        raise InputError(Problem(f"element '{element.name}': '{text}': {error}", hint=error.hint)) from error


def _with_forces(system: System, elements: Sequence[Element], named: Mapping[str, _Naming]) -> System:
    """With the laws of the elements."""
    names, own = system.names, bindings(system.coordinates)
    forces = [(element, force) for element in elements for force in element.forces]
    if not forces:
        return system
    at = [_coordinate(system, element, force.along) for element, force in forces]
    added = [
        AddedLaw(own[row], row, named[element.name](force.push), element.name, loses=force.loses)
        for row, (element, force) in zip(at, forces, strict=True)
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
