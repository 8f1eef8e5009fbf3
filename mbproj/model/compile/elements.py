"""Elements as arrays: what they add to a system."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from mbproj.constraints.coupling import COORDINATES, Coupling
from mbproj.dataclass import dataclass
from mbproj.elements.element import Element, Row
from mbproj.errors import InputError, Problem
from mbproj.functions.curve import Curve
from mbproj.functions.program import CHANNELS, COORDINATE, RATE, TIME, Instruction, Op, Program
from mbproj.functions.program_set import flatten, joined
from mbproj.model.added_laws import AddedLaw, with_laws
from mbproj.model.channels import Channels, ElementStates, Energies, Kind
from mbproj.model.couplings import compile_couplings
from mbproj.model.primitive_set import Binding, bind, bindings
from mbproj.model.system import System
from mbproj.scene.expressions.compiled import compiled
from mbproj.scene.expressions.syntax_tree import parse
from mbproj.scene.expressions.tokens import ExpressionError
from mbproj.scene.text.suggestions import choose_from

#: What every expression may name beside the channels that are read.
VARIABLES = {"t": TIME, "s": COORDINATE, "s_dot": RATE}
_CALLED = {type(primitive): name for name, primitive in COORDINATES.items()}


def with_elements(system: System, elements: Sequence[Element]) -> System:
    """The system with these elements. Raises InputError that names what an element reads and that there is not, or a
    row whose function cannot be one."""
    states = [(f"{element.name}.{state.name}", state) for element in elements for state in element.states]
    names = replace(
        system.names,
        states=(*system.names.states, *(name for name, _ in states)),
        state_units=(*system.names.state_units, *(state.unit for _, state in states)),
    )
    system = replace(system, names=names)
    channels, named = _channels(system, elements)
    own = ElementStates(
        np.array([state.start for _, state in states]),
        np.array([state.scale for _, state in states]),
        flatten([named[element.name](state.rate) for element in elements for state in element.states]),
    )
    energies = Energies(
        joined([system.energies.stored, flatten([named[each.name](each.stores) for each in elements if each.stores])]),
        joined([system.energies.lost, flatten([named[each.name](each.lost) for each in elements if each.lost])]),
    )
    system = replace(system, channels=channels, energies=energies, states=_after(system.states, own))
    return _with_rows(_with_forces(system, elements, named), elements)


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
    found: list[tuple[Kind, int]] = [(Kind(kind), index) for kind, index in known]
    named, problems = dict[str, _Naming](), []
    for element in elements:
        for name in element.reads:
            if name not in able:
                what = f"element '{element.name}' reads '{name}', which there is not"
                problems.append(Problem(what, hint=choose_from(name, list(able))))
            elif able[name] not in found:
                found.append(able[name])
        named[element.name] = _Naming(element, tuple(found.index(able[name]) for name in element.reads if name in able))
    if problems:
        raise InputError(problems)
    return Channels.of(found), named


@dataclass(frozen=True)
class _Naming:
    """What the programs of an element see: the channels of the system that it reads, and how expressions call them."""

    element: Element
    channels: tuple[int, ...]

    def __call__(self, program: Program | str) -> Program:
        """The program with these numbers. Raises InputError where it is an expression that cannot be read."""
        if isinstance(program, str):
            reads = {name.replace(".", "_"): CHANNELS + at for at, name in enumerate(self.element.reads)}
            program = _program(self.element, program, VARIABLES | reads)
        return replace(program, code=tuple(self._named(each) for each in program.code))

    def _named(self, each: Instruction) -> Instruction:
        if each.op is not Op.VARIABLE or each.operand < CHANNELS:
            return each
        return replace(each, operand=float(CHANNELS + self.channels[int(each.operand) - CHANNELS]))


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
    shown = tuple(f"{element.name}.{force.along}" for element, force in forces)
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
        primitive = _coupling(element, row, parts)
        slots = tuple(slot for part in parts for slot in part.slots)
        own.append(Binding(primitive, len(body), slots))
        body.append(next(body for body, side, _ in reversed(slots) if side == 2))
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


def _coupling(element: Element, row: Row, parts: Sequence[Binding]) -> Coupling:
    """The primitive of a row. Raises InputError where its function has edges, or changes with a turn."""
    kinds = tuple(_CALLED[type(part.primitive)] for part in parts)
    turns = [abs(weight) for weight, kind in zip(row.of.values(), kinds, strict=True) if kind == "angle" and weight]
    where = f"row '{element.name}.{row.name}'"
    if row.period is None and len(turns) > 1:
        raise InputError(Problem(f"{where} couples several angles", hint="say its period: what no turn of any changes"))
    period = row.period if row.period is not None else 2.0 * np.pi * sum(turns)
    function = _program(element, row.function, VARIABLES) if isinstance(row.function, str) else row.function
    if function is None:
        return Coupling(kinds, tuple(row.of.values()), period)
    if any(each.op is Op.VARIABLE and each.operand != COORDINATE for each in function.code):
        raise InputError(Problem(f"the function of {where} names more than its first coordinate", hint="add a force"))
    curve = Curve(function)
    if curve.has_edges():
        raise InputError(Problem(f"the function of {where} has edges", hint="give one whose slope does not jump"))
    if kinds[0] == "angle" and not curve.repeats(2.0 * np.pi, period):
        raise InputError(Problem(f"the function of {where} is another one after a turn", hint="let it repeat"))
    return Coupling(kinds, tuple(row.of.values()), period, curve)


def _coordinate(system: System, element: Element, name: str) -> int:
    """The number of a joint coordinate."""
    able = system.names.coordinates
    if name not in able:
        what = f"element '{element.name}' acts on '{name}', which there is not"
        raise InputError(Problem(what, hint=choose_from(name, able)))
    return able.index(name)
