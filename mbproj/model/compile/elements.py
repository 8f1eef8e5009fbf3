"""Adds elements, signals and controllers to a system."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem, choose_from
from mbproj.functions.elements import (
    Controller,
    Element,
    End,
    Force,
    Held,
    Place,
    Row,
    ScalarState,
    Signal,
    State,
    called,
)
from mbproj.functions.program import (
    CHANNELS,
    COORDINATE,
    RATE,
    TIME,
    Code,
    Op,
    Program,
    apply,
    number,
    replaced,
    variable,
)
from mbproj.functions.program_set import ProgramSet, flatten, joined
from mbproj.joints.primitives.table import PRIMITIVES
from mbproj.model.channels import NO_ACTIONS, Actions, ChannelKind, Channels, ElementStates, Energies, Motions
from mbproj.model.compile.couplings import row_binding
from mbproj.model.contacts import AddedLaw, Frictions, with_laws
from mbproj.model.couplings import compile_couplings
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.forces import ReflectedInertias
from mbproj.model.primitive_set import Binding, bind, bindings
from mbproj.model.system import System
from mbproj.scene.expressions.compiled import compiled
from mbproj.scene.expressions.syntax_tree import ExpressionError, parse
from mbproj.scene.records import Coupled

# --- Resolves names in functions of a scene to codes of channels ------------------------------------------------------
# Coordinates, rates, states, signals, forces of laws.
# A signal has no channel of its own: its code is inserted where it is named, and so is the code of a law's force. So
# functions of them have exact derivatives. A signal that depends on itself is an algebraic loop, which is refused.


#: The variables that every expression may name beside the channels that are read.
VARIABLES = {"t": TIME, "s": COORDINATE, "s_dot": RATE}
#: The most instructions of a function once its signals are inserted.
LONGEST = 100_000
#: The hint for an algebraic loop.
REMEDY = "insert a state between, as {derivative: (wanted - it)/(1 ms)}"


def in_expressions(name: str) -> str:
    """Return the form of a name in expressions of a scene: _ replaces each hyphen, which is a minus there."""
    return name.replace("-", "_")


class NamesOfSystem:
    """Resolver of the names of a system that has its states and measured coordinates already.

    `signals` are their programs by name. `others` are names that exist but have no channel yet, for hints in messages.
    `pushes` are the forces of elements, by the names of the forces: the coordinate that each acts along, and its
    program."""

    def __init__(
        self,
        system: System,
        signals: Mapping[str, Program],
        others: Sequence[str] = (),
        pushes: Mapping[str, tuple[str, Callable[[NamesOfSystem], Program]]] = MappingProxyType({}),
    ) -> None:
        names, known = system.names, system.channels
        self._system, self._signals, self._others = system, signals, others
        self._pushes = {f"{in_expressions(name)}.force": push for name, push in pushes.items()}
        self._able = {name: (ChannelKind.STATE, at) for at, name in enumerate(names.states)}
        self._able |= {name: (ChannelKind.COORDINATE, at) for at, name in enumerate(names.coordinates)}
        self._able |= {f"{name}_dot": (ChannelKind.RATE, at) for at, name in enumerate(names.coordinates)}
        self._able |= {in_expressions(name): each for name, each in self._able.items()}
        self._laws = {f"{name}.force": at for at, name in enumerate(names.forces[: system.forces.laws.size])}
        self._laws |= {in_expressions(name): at for name, at in self._laws.items()}
        pairs = zip(known.kind.tolist(), known.index.tolist(), strict=True)
        self._channels = {(ChannelKind(kind), index): at for at, (kind, index) in enumerate(pairs)}
        self._codes = dict[str, Code]()
        self._open: list[str] = []

    @property
    def channels(self) -> Channels:
        """The channels of all names resolved so far."""
        return Channels.of(list(self._channels))

    def code(self, name: str, reader: str) -> Code:
        """Return the code of a name. Raises InputError, which names the `reader`, where the name does not exist or
        depends on itself."""
        if name in self._codes:
            return self._codes[name]
        if name in self._open:
            chain = " -> ".join([*self._open[self._open.index(name) :], name])
            raise InputError(Problem(f"{reader} depends on itself: {chain}", hint=REMEDY))
        self._open.append(name)
        try:
            self._codes[name] = self._code(name, reader)
        finally:
            self._open.pop()
        return self._codes[name]

    def _code(self, name: str, reader: str) -> Code:
        if name in self._able:
            return self._channel(*self._able[name])
        if name in self._signals:
            return self.resolved(self._signals[name], f"signal '{name}'").code
        if name in self._laws:
            return self._force(self._laws[name])
        if name in self._pushes:
            along, push = self._pushes[name]
            s, rate = (self.code(each, reader) for each in (along, f"{along}_dot"))
            return replaced(push(self).code, {COORDINATE: s, RATE: rate})
        hint = choose_from(name, [*self._signals, *self._able, *self._laws, *self._pushes, *self._others])
        raise InputError(Problem(f"{reader} reads '{name}', which does not exist", hint=hint))

    def resolved(self, program: Program, reader: str) -> Program:
        """Return a function of the scene with channels in place of the names it reads."""
        if not program.reads:
            return program
        by = {CHANNELS + at: self.code(name, reader) for at, name in enumerate(program.reads)}
        code = replaced(program.code, by)
        if len(code) > LONGEST:
            what = f"{reader} unfolds to more than {LONGEST} operations: signals in signals multiply"
            raise InputError(Problem(what, hint="name what is used again and again as a state, or write it apart"))
        return replace(program, code=code, reads=())

    def resolved_set(self, programs: ProgramSet, owners: Sequence[str]) -> ProgramSet:
        """Return all functions of a set with channels in place of names; `owners` are the names of their forces."""
        if not any(programs.reads):
            return programs
        each = (programs.program(index) for index in range(programs.size))
        return flatten(
            [self.resolved(program, f"force '{owner}'") for program, owner in zip(each, owners, strict=True)]
        )

    def of_element(self, element: Element) -> tuple[Code, ...]:
        """Return the codes of the names that an element reads."""
        return tuple(self.code(name, f"element '{element.name}'") for name in element.reads)

    def _channel(self, kind: ChannelKind, index: int) -> Code:
        return variable(CHANNELS + self._channels.setdefault((kind, index), len(self._channels)))

    def _force(self, law: int) -> Code:
        """Return F = -k (s - free) - c s' + program(t, s, s') of a law as code. Raises InputError where the force
        depends on a load."""
        system = self._system
        laws, name = system.forces.laws, system.names.forces[law]
        if laws.bearing[law] >= 0 or laws.partner[law] >= 0:
            what = f"the force of '{name}' cannot be read: it depends on a load, which would depend on the reader"
            raise InputError(Problem(what, hint="read what the load comes from: a coordinate, a spring's force"))
        at = int(laws.joint_coordinate[law])
        at = at if at >= 0 else system.names.coordinates.index(f"{name}.length")
        s, rate = self._channel(ChannelKind.COORDINATE, at), self._channel(ChannelKind.RATE, at)
        stretch = apply(Op.SUBTRACT, s, number(float(laws.free[law])))
        total = apply(Op.MULTIPLY, number(-float(laws.stiffness[law])), stretch) if laws.stiffness[law] else number(0.0)
        if laws.damping[law]:
            total = apply(Op.SUBTRACT, total, apply(Op.MULTIPLY, number(float(laws.damping[law])), rate))
        if laws.program[law] < 0:
            return total
        program = self.resolved(system.forces.programs.program(int(laws.program[law])), f"force '{name}'")
        return apply(Op.ADD, total, replaced(program.code, {COORDINATE: s, RATE: rate}))


def expression_of(element: Element, text: str, variables: Mapping[str, int]) -> Program:
    """Return an expression of an element as a program. Raises InputError where it cannot be read."""
    try:
        return Program(compiled(parse(text, frozenset(variables)), {}, variables)[0], text)
    except ExpressionError as error:
        raise InputError(Problem(f"element '{element.name}': '{text}': {error}", hint=error.hint)) from error


def named_within(element: Element, name: str) -> str:
    """Return the name of an element's part in results: element.part. Parts of the scene itself have no prefix."""
    return f"{element.name}.{name}" if element.name else name


# --- Controllers as arrays --------------------------------------------------------------------------------------------
# The outputs that they hold are states with a zero derivative, which actions set.


#: The name of the state that holds an output computed but delayed.
COMPUTED = "{}.computed"
CONSTANT = Program(number(0.0))


def held_by_controllers(controllers: Sequence[Controller]) -> list[Element]:
    """Return the states of the controllers: held outputs, delayed outputs that are already computed, and remembered
    values."""
    return [Element(controller.name, states=tuple(_states(controller))) for controller in controllers]


def states_of(states: Sequence[ScalarState]) -> Element:
    """Return the states of a scene as an element."""
    return Element("", states=tuple(State(each.name, *each.of_element) for each in states))


def _states(controller: Controller) -> Iterator[State]:
    for each in (*controller.hold, *controller.states):
        yield State(each.name, CONSTANT, each.start, unit=each.unit)
    for each in controller.hold if controller.delay else ():
        yield State(COMPUTED.format(each.name), CONSTANT, each.start, unit=each.unit)


def read_by(controllers: Sequence[Controller]) -> Iterator[str]:
    """The names that the functions of controllers read."""
    for controller in controllers:
        yield from (name for each in (*controller.hold, *controller.states) for name in each.program.reads)


def actions_of(controllers: Sequence[Controller], channels: NamesOfSystem, states: Sequence[str]) -> Actions:
    """Return the actions of controllers, in their order. With a delay the computed outputs take effect first, and then
    the next ones are computed."""
    if not controllers:
        return NO_ACTIONS
    first, period, names = list[float](), list[float](), list[str]()
    sets: list[list[tuple[str, Program]]] = []
    for controller in controllers:
        into, whose = controller.name, f"controller '{controller.name}'"
        if controller.delay:
            first.append(controller.start + controller.delay)
            sets.append([(f"{into}.{each.name}", _stands(into, each)) for each in controller.hold])
        first.append(controller.start)
        name = COMPUTED if controller.delay else "{}"
        sets.append(
            [
                *((f"{into}.{name.format(each.name)}", each.program) for each in controller.hold),
                *((f"{into}.{each.name}", each.program) for each in controller.states),
            ]
        )
        period += [controller.period] * (len(sets) - len(period))
        names += [whose] * (len(sets) - len(names))
    every = [(state, program, whose) for pairs, whose in zip(sets, names, strict=True) for state, program in pairs]
    number_of = {name: at for at, name in enumerate(states)}
    return Actions(
        np.array(first),
        np.array(period),
        np.cumsum([0, *map(len, sets)], dtype=np.intp),
        np.array([number_of[state] for state, _, _ in every], dtype=np.intp),
        flatten([channels.resolved(program, whose) for _, program, whose in every]),
        tuple(names),
    )


def _stands(controller: str, each: Held) -> Program:
    """Return the program that gives a delayed output the value computed before."""
    return Program(variable(CHANNELS), each.name, (f"{controller}.{COMPUTED.format(each.name)}",))


# --- Adds elements, signals and controllers to a system ---------------------------------------------------------------


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
    added = ElementStates(
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
        states=_states_after(system.states, added),
        signals=shown,
    )
    return with_inertias(with_rows(_with_forces(system, elements, pushes), elements), elements)


def _frictions(system: System, channels: NamesOfSystem) -> Frictions | None:
    """Return the dry frictions of a system, with channels in place of names in their functions."""
    frictions = system.frictions
    if frictions is None or not frictions.varies:
        return frictions

    def resolved(k: int, sliding: Program, static: Program) -> tuple[Program, Program]:
        of_sliding = channels.resolved(sliding, frictions.owners[k])
        return of_sliding, of_sliding if static is sliding else channels.resolved(static, frictions.owners[k])

    return replace(frictions, varies={k: resolved(k, *pair) for k, pair in frictions.varies.items()})


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
            stored = named[element.name](element.stores)
            yield replace(stored, code=apply(Op.SUBTRACT, number(0.0), stored.code))


def _states_after(before: ElementStates, added: ElementStates) -> ElementStates:
    """Return the states `added` after the states `before`."""
    parts = before, added
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
    names, coordinates = system.names, bindings(system.coordinates)
    forces = [(element, force) for element in elements for force in element.forces]
    programs = [program for of_element in pushes for program in of_element]
    if not forces:
        return system
    at = [coordinate_of(system, element, force.along) for element, force in forces]
    added = [
        AddedLaw(coordinates[row], row, program, element.name, loses=force.loses)
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
    names, joints, coordinates = system.names, bindings(system.joints), bindings(system.coordinates)
    body, local = system.reaction_body.tolist(), system.reaction_local.tolist()
    for element, row in rows:
        parts = [coordinates[coordinate_of(system, element, name)] for name in row.of]
        assert not isinstance(row.function, str)
        coupled = Coupled(dict(row.of), row.function, row.constant, row.period)
        joints.append(row_binding(f"row '{element.name}.{row.name}'", coupled, row.constant, parts, len(body)))
        body.append(next(body for body, side, _ in reversed(joints[-1].slots) if side == 2))
        local.append([0.0] * 3)
    return replace(
        system,
        names=replace(names, joints=(*names.joints, *(named_within(element, row.name) for element, row in rows))),
        joints=bind(joints),
        couplings=compile_couplings(joints, coordinates),
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
    functions = flatten([row.function for _, row in rows if isinstance(row.function, Program)])
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
            joined([before.programs, functions]) if before.size else functions,
            (*before.places, *(row.place for _, row in rows)),
        ),
    )


def with_inertias(system: System, elements: Sequence[Element]) -> System:
    """Return the system with inertias reflected to coordinates. Raises InputError where one is negative or not
    finite."""
    inertias = dict[int, float]()
    for element in elements:
        for name, inertia in element.inertias.items():
            if not 0.0 <= inertia < np.inf:
                what = f"element '{element.name}' has an inertia along '{name}' of {inertia}"
                raise InputError(Problem(what, hint="give a finite number that is not negative"))
            if inertia >= LEAST:
                at = coordinate_of(system, element, name)
                inertias[at] = inertias.get(at, 0.0) + inertia
    if not inertias:
        return system
    names, before, bound_to = system.names, system.reflected, bindings(system.coordinates)
    forces = len(names.forces) - before.size
    for at, inertia in zip(before.joint_coordinate.tolist(), before.inertia.tolist(), strict=True):
        inertias[at] = inertias.get(at, 0.0) + inertia
    rows = [Binding(bound_to[at].primitive, owner, bound_to[at].slots) for owner, at in enumerate(inertias)]
    return replace(
        system,
        names=replace(
            names,
            forces=(*names.forces[:forces], *(f"{names.coordinates[at]}.inertia" for at in inertias)),
            force_units=(*names.force_units[:forces], *(names.coordinate_units[at] for at in inertias)),
        ),
        reflected=ReflectedInertias(bind(rows), np.array([*inertias], dtype=np.intp), np.array([*inertias.values()])),
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
        local = system.body_offset[body] + rotation_matrix(system.body_turn[body]) @ np.array(end.location)
        return int(system.body_carrier[body]), side, local
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
