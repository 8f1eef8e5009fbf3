"""Adds elements, signals and controllers to a system."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from mbproj.arrays import Array
from mbproj.constraints import PRIMITIVES
from mbproj.dataclass import dataclass
from mbproj.elements.controlled import Controller, Signal
from mbproj.elements.element import Element, End, Force, Place, Row, called
from mbproj.errors import InputError, Problem, choose_from
from mbproj.functions.program import CHANNELS, TIME, Code, Op, Program, apply, number, replaced
from mbproj.functions.program_set import flatten, joined
from mbproj.model.added_laws import AddedLaw, with_laws
from mbproj.model.channels import ElementStates, Energies, Motions
from mbproj.model.compile.coupled import row_binding
from mbproj.model.compile.elements.channel_names import VARIABLES, NamesOfSystem, expression_of, named_within
from mbproj.model.compile.elements.controllers import actions_of, read_by
from mbproj.model.couplings import compile_couplings
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.forces import ReflectedInertias
from mbproj.model.frictions import Frictions
from mbproj.model.primitive_set import Binding, bind, bindings
from mbproj.model.system import System
from mbproj.scene.coupled import Coupled

#: The smallest number with a reciprocal: a smaller inertia counts as none.
LEAST = float(np.finfo(float).tiny)


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
        of_sliding = channels.resolved(sliding, own.owners[k])
        return of_sliding, of_sliding if static is sliding else channels.resolved(static, own.owners[k])

    return replace(own, varies={k: resolved(k, *pair) for k, pair in own.varies.items()})


def _names_read(system: System, elements: Sequence[Element], signals: Sequence[Signal]) -> Iterator[str]:
    """The names that functions of a scene read, without those of elements, which list their names themselves."""
    yield from (name for programs in system.forces.programs.reads for name in programs)
    for programs in () if system.frictions is None else system.frictions.varies.values():
        yield from (name for program in programs for name in program.reads)
    rates = [state.rate for element in elements for state in element.states]
    for program in (*(signal.program for signal in signals), *rates):
        yield from program.reads if isinstance(program, Program) else ()


def _named_forces(elements: Sequence[Element]) -> Iterator[tuple[str, tuple[str, Callable[[NamesOfSystem], Program]]]]:
    """The named forces of elements by name: the coordinate along which each acts, and its program with channels in
    place of names."""

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
    """Resolves the names in the programs of an element: `codes` are those of the names that the element reads."""

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


def with_rows(system: System, elements: Sequence[Element]) -> System:
    """Return the system with the rows of the elements. Raises InputError where a function is not admissible in a
    row."""
    coupled, driven = list[tuple[Element, Row]](), list[tuple[Element, Row]]()
    for element in elements:
        for row in element.rows:
            function = row.function
            if isinstance(function, str):
                row = replace(row, function=expression_of(element, function, VARIABLES))
            (driven if _drives(row) else coupled).append((element, row))
    return _with_motions(_with_couplings(system, coupled), driven)


def _drives(row: Row) -> bool:
    """Whether a row is a motion: it has one coordinate and a function of time alone."""
    return (
        list(row.of.values()) == [1.0]
        and isinstance(row.function, Program)
        and all(each.operand == TIME for each in row.function.code if each.op is Op.VARIABLE)
    )


def _with_couplings(system: System, rows: Sequence[tuple[Element, Row]]) -> System:
    """Return the system with rows that couple coordinates, each as a joint of its own."""
    if not rows:
        return system
    names, own, coordinates = system.names, bindings(system.joints), bindings(system.coordinates)
    body, local = system.reaction_body.tolist(), system.reaction_local.tolist()
    for element, row in rows:
        parts = [coordinates[coordinate_of(system, element, name)] for name in row.of]
        assert not isinstance(row.function, str)
        coupled = Coupled(dict(row.of), row.function, row.constant, row.period)
        own.append(row_binding(f"row '{element.name}.{row.name}'", coupled, row.constant, parts, len(body)))
        body.append(next(body for body, side, _ in reversed(own[-1].slots) if side == 2))
        local.append([0.0] * 3)
    return replace(
        system,
        names=replace(names, joints=(*names.joints, *(named_within(element, row.name) for element, row in rows))),
        joints=bind(own),
        couplings=compile_couplings(own, coordinates),
        reaction_body=np.array(body, dtype=np.intp),
        reaction_local=np.array(local).reshape(-1, 3),
        joint_places=(*system.joint_places, *(row.place for _, row in rows)),
    )


def _with_motions(system: System, rows: Sequence[tuple[Element, Row]]) -> System:
    """Return the system with rows that drive coordinates; they are the last rows of C."""
    if not rows:
        return system
    names, before = system.names, system.motions
    at = [coordinate_of(system, element, name) for element, row in rows for name in row.of]
    own = flatten([row.function for _, row in rows if isinstance(row.function, Program)])
    return replace(
        system,
        names=replace(
            names,
            motions=(*names.motions, *(named_within(element, row.name) for element, row in rows)),
            motion_units=(*names.motion_units, *(names.coordinate_units[number] for number in at)),
        ),
        motions=Motions(
            np.array([*before.joint_coordinate, *at], dtype=np.intp),
            np.array([*before.start, *(row.constant for _, row in rows)]),
            joined([before.programs, own]) if before.size else own,
            (*before.places, *(row.place for _, row in rows)),
        ),
    )


def with_inertias(system: System, elements: Sequence[Element]) -> System:
    """Return the system with inertias reflected to coordinates. Raises InputError where one is negative or not
    finite."""
    own = dict[int, float]()
    for element in elements:
        for name, inertia in element.inertias.items():
            if not 0.0 <= inertia < np.inf:
                what = f"element '{element.name}' has an inertia along '{name}' of {inertia}"
                raise InputError(Problem(what, hint="give a finite number that is not negative"))
            if inertia >= LEAST:
                at = coordinate_of(system, element, name)
                own[at] = own.get(at, 0.0) + inertia
    if not own:
        return system
    names, before, bound_to = system.names, system.reflected, bindings(system.coordinates)
    forces = len(names.forces) - before.size
    for at, inertia in zip(before.joint_coordinate.tolist(), before.inertia.tolist(), strict=True):
        own[at] = own.get(at, 0.0) + inertia
    rows = [Binding(bound_to[at].primitive, owner, bound_to[at].slots) for owner, at in enumerate(own)]
    return replace(
        system,
        names=replace(
            names,
            forces=(*names.forces[:forces], *(f"{names.coordinates[at]}.inertia" for at in own)),
            force_units=(*names.force_units[:forces], *(names.coordinate_units[at] for at in own)),
        ),
        reflected=ReflectedInertias(bind(rows), np.array([*own], dtype=np.intp), np.array([*own.values()])),
    )


# --- Coordinates other than those of joints that elements name --------------------------------------------------------
# Coordinates of markers, distances, lengths of forces.


#: The coordinates of a marker: its distance from the ground's origin along each axis of the ground.
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
#: The owner of a coordinate that belongs to no joint.
NO_JOINT = -1
Slot = tuple[int, int, Array]


def with_measured(system: System, elements: Sequence[Element], read: Iterable[str] = ()) -> System:
    """Return the system with the coordinates added that elements or `read` name.

    These are "tip.x" of a marker, "rope.left" of an element's `lengths`, and "spring.length" of a force between two
    points. Raises InputError where a length names a marker that does not exist, or two points of one body."""
    able, known = measurable(system, elements), system.names.coordinates
    by_expressions = {name.replace("-", "_"): name for name in able}
    written = (*(name for element in elements for name in _coordinate_names(element)), *_measured(read))
    asked = (by_expressions.get(name, name) for name in written)
    added = {name: able[name] for name in dict.fromkeys(asked) if name in able and name not in known}
    if not added:
        return system
    names = replace(
        system.names,
        coordinates=(*known, *added),
        coordinate_units=(*system.names.coordinate_units, *("m" for _ in added)),
    )
    return replace(system, names=names, coordinates=bind([*bindings(system.coordinates), *added.values()]))


def _coordinate_names(element: Element) -> Iterator[str]:
    """The names of all coordinates that an element names, and the coordinate of each force that it reads."""
    yield from _measured(element.reads)
    yield from (force.along for force in element.forces)
    yield from (name for row in element.rows for name in row.of)
    yield from element.inertias


def _measured(read: Iterable[str]) -> Iterator[str]:
    """The names of the coordinates on which the names `read` may depend."""
    for name in read:
        yield name.removesuffix("_dot")
        yield f"{name.removesuffix('.force')}.length"


def measurable(system: System, elements: Sequence[Element]) -> dict[str, Binding]:
    """Return all coordinates that can be added, by name. Raises InputError as `with_measured` does."""
    ground, laws, able = system.bodies, system.forces.laws, dict[str, Binding]()
    for marker in system.names.markers:
        for axis, direction in AXES.items():
            slots = (ground, 1, np.array(direction)), (ground, 1, np.zeros(3)), _end(system, marker, 2)
            able[f"{marker}.{axis}"] = Binding(PRIMITIVES["along"](), NO_JOINT, slots)
    for name, index, bound in zip(system.names.forces, laws.joint_coordinate, bindings(laws.coordinates), strict=False):
        if index < 0:
            able[f"{name}.length"] = replace(bound, owner=NO_JOINT)
    for element in elements:
        for name, ends in element.lengths.items():
            able[f"{element.name}.{name}"] = _length(system, f"{element.name}.{name}", ends)
    return able


def _length(system: System, name: str, ends: tuple[End, End]) -> Binding:
    for end in ends:
        if isinstance(end, str) and end not in system.names.markers:
            what = f"the length '{name}' ends at the marker '{end}', which does not exist"
            raise InputError(Problem(what, hint=choose_from(end, system.names.markers)))
    first, second = (_end(system, end, side) for side, end in enumerate(ends, 1))
    if first[0] == second[0]:
        raise InputError(Problem(f"the length '{name}' has both ends on one rigid body", hint="name another marker"))
    return Binding(PRIMITIVES["distance"](), NO_JOINT, (first, second))


def _end(system: System, end: End, side: int) -> Slot:
    if isinstance(end, Place):
        body = system.names.bodies.index(end.body)
        own = system.body_offset[body] + rotation_matrix(system.body_turn[body]) @ np.array(end.location)
        return int(system.body_carrier[body]), side, own
    if not isinstance(end, str):
        return system.bodies, side, np.array(end)
    marker = system.names.markers.index(end)
    return int(system.marker_body[marker]), side, system.marker_local[marker]


def coordinate_of(system: System, element: Element, name: str) -> int:
    """Return the number of a coordinate. Raises InputError where it does not exist."""
    able = system.names.coordinates
    if name not in able:
        what = f"element '{element.name}' acts on '{name}', which does not exist"
        raise InputError(Problem(what, hint=choose_from(name, [*able, *measurable(system, [element])])))
    return able.index(name)
