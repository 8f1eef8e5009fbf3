"""Controllers as arrays: the outputs that they hold are states with a zero derivative, which actions set."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mbproj.elements import Element, State
from mbproj.elements.controlled import Controller, Held, ScalarState
from mbproj.functions.program import CHANNELS, Program, number, variable
from mbproj.functions.program_set import flatten
from mbproj.model.channels import NO_ACTIONS, Actions
from mbproj.model.compile.elements.channel_names import NamesOfSystem

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
    every = [(state, program, whose) for own, whose in zip(sets, names, strict=True) for state, program in own]
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
