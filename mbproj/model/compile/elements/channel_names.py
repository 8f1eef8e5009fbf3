"""Resolves names in functions of a scene to codes of channels: coordinates, rates, states, signals, forces of laws.

A signal has no channel of its own: its code is inserted where it is named, and so is the code of a law's force. So
functions of them have exact derivatives. A signal that depends on itself is an algebraic loop, which is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

from mbproj.elements.element import Element
from mbproj.errors import InputError, Problem, choose_from
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
from mbproj.functions.program_set import ProgramSet, flatten
from mbproj.model.channels import ChannelKind, Channels
from mbproj.model.system import System
from mbproj.scene.expressions.compiled import compiled
from mbproj.scene.expressions.syntax_tree import ExpressionError, parse

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
        self._found = {(ChannelKind(kind), index): at for at, (kind, index) in enumerate(pairs)}
        self._codes = dict[str, Code]()
        self._open: list[str] = []

    @property
    def channels(self) -> Channels:
        """The channels of all names resolved so far."""
        return Channels.of(list(self._found))

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
        return variable(CHANNELS + self._found.setdefault((kind, index), len(self._found)))

    def _force(self, law: int) -> Code:
        """Return F = -k (s - free) - c s' + program(t, s, s') of a law as code. Raises InputError where the force
        depends on a load."""
        system = self._system
        own, name = system.forces.laws, system.names.forces[law]
        if own.bearing[law] >= 0 or own.partner[law] >= 0:
            what = f"the force of '{name}' cannot be read: it depends on a load, which would depend on the reader"
            raise InputError(Problem(what, hint="read what the load comes from: a coordinate, a spring's force"))
        at = int(own.joint_coordinate[law])
        at = at if at >= 0 else system.names.coordinates.index(f"{name}.length")
        s, rate = self._channel(ChannelKind.COORDINATE, at), self._channel(ChannelKind.RATE, at)
        stretch = apply(Op.SUBTRACT, s, number(float(own.free[law])))
        total = apply(Op.MULTIPLY, number(-float(own.stiffness[law])), stretch) if own.stiffness[law] else number(0.0)
        if own.damping[law]:
            total = apply(Op.SUBTRACT, total, apply(Op.MULTIPLY, number(float(own.damping[law])), rate))
        if own.program[law] < 0:
            return total
        program = self.resolved(system.forces.programs.program(int(own.program[law])), f"force '{name}'")
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
