"""A rule on expressions: the signals, states, coordinates and forces that they name exist."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from mbproj.errors import Problem, choose_from
from mbproj.functions.program import Program
from mbproj.joints import JOINTS
from mbproj.scene.blocks.control.expanded import expanded, where
from mbproj.scene.blocks.coordinates import with_coordinates
from mbproj.scene.blocks.elements import element_type
from mbproj.scene.fields.reading import Reading
from mbproj.scene.records import BodyForce, Force, JointForce, KeyPath, PointForce, Settings

if TYPE_CHECKING:
    from mbproj.scene.read import Scene

#: Parts of items that are known only after the forces, so that no expression of a force may name them.
TOO_LATE = ("angle_ddot", "displacement_ddot", "length_ddot", "acceleration", "reaction", "reaction_force")
Found = Mapping[str, Any]


def with_known_names(blocks: Found, settings: Settings | None, reading: Reading) -> Found:
    """The items of the scene by block and name, with plain signals, states and controllers in place of blocks. Reports
    unknown names in their expressions, and notes the instants of controllers that may be a mistake."""
    blocks = expanded(blocks, reading)
    check_names(blocks, reading)
    note_instants(blocks, settings, reading)
    return blocks


def check_names(blocks: Found, reading: Reading) -> None:
    """Report unknown names at the expressions that use them. `blocks` are the items of the scene by block and name."""
    functions = [*_functions_with_names(blocks)]
    if not functions:
        return
    able = dict.fromkeys(nameable(blocks))
    for path, program in functions:
        for name in program.reads:
            if name not in able:
                near = next(path[:end] for end in range(len(path), -1, -1) if path[:end] in reading.places)
                reading.report(*_unknown(name, able, reading.places[near]))


def _unknown(name: str, able: Collection[str], place: Any) -> tuple[str, Any, str]:
    if name.rpartition(".")[2] in TOO_LATE:
        what = f"'{name}' follows from the forces, which this would change: an algebraic loop"
        return what, place, "use a coordinate, its rate, a spring's force, or a state that follows one of them"
    own, _, last = name.rpartition(".")
    rate = f"{own}.{last.removeprefix('velocity_').removesuffix('_speed')}_dot"  # as linear models and results call it
    hint = f"did you mean '{rate}'?" if rate in able else choose_from(name, able)
    return f"unknown name '{name}'", place, hint


def _functions_with_names(blocks: Found) -> Iterator[tuple[KeyPath, Program]]:
    """The path and the program of every function of the scene that names a signal, a state or a coordinate."""
    signals = blocks.get("signals", {})
    for name, signal in signals.items():
        if signal.program.reads:
            yield where("signals", name, signals) or ("signals", name, "value"), signal.program
    for name, state in blocks.get("states", {}).items():
        if state.rate.reads:
            yield where("states", name, signals) or ("states", name, "derivative"), state.rate
    for name, controller in blocks.get("controllers", {}).items():
        for block, several in (("hold", controller.hold), ("states", controller.states)):
            for each in several:
                if each.program.reads:
                    own = where("controllers", name, signals)
                    yield own or ("controllers", name, block, each.name), each.program
    for name, force in blocks.get("forces", {}).items():
        for key, program in _functions_of_force(force):
            if program is not None and program.reads:
                yield ("forces", name, *key), program


def _functions_of_force(force: Force) -> Iterator[tuple[KeyPath, Program | None]]:
    if isinstance(force, PointForce | JointForce) and force.element is not None:
        values = force.element.values.items()
        yield from (((key,), value) for key, value in values if isinstance(value, Program))
    elif isinstance(force, PointForce):
        yield ("force",), force.law.function
    elif isinstance(force, JointForce):
        for law in force.laws.values():
            yield ("torque" if force.unit == "rad" else "force",), law.function
        for dry in force.coulomb.values():
            yield from ((("coulomb",), each) for each in (dry.sliding, dry.static) if isinstance(each, Program))
    elif isinstance(force, BodyForce):
        key = "torque" if force.torque else "force"
        for at, component in enumerate(force.components):
            yield (key, at), component


def names_channels(scene: Scene) -> bool:
    """Whether functions of a scene name signals, states or coordinates."""
    functions = [(force, each) for force in scene.forces for _, each in _functions_of_force(force) if each is not None]
    return bool(scene.signals or scene.states or scene.controllers) or any(
        program.reads or (isinstance(force, PointForce | JointForce) and force.element) for force, program in functions
    )


def nameable(blocks: Found) -> Iterator[str]:
    """Every name that an expression may use, as it is written there: with _ for a hyphen."""
    joints, forces, held = blocks.get("joints", {}), blocks.get("forces", {}), list[str]()
    yield from (*blocks.get("signals", {}), *blocks.get("states", {}))
    names = [f"{joint.name}.{name}" for joint in joints.values() for name in JOINTS[joint.type].coordinates]
    for controller in blocks.get("controllers", {}).values():
        held += [f"{controller.name}.{each.name}" for each in (*controller.hold, *controller.states)]
    names += [f"{marker}.{axis}" for marker in blocks.get("markers", {}) for axis in "xyz"]
    names += [f"{force.name}.length" for force in forces.values() if isinstance(force, PointForce)]
    names += [f"{name}_dot" for name in names]
    for force in forces.values():
        names += _parts_of(force, joints)
    yield from (name.replace("-", "_") for name in (*names, *held))


def _parts_of(force: Force, joints: Mapping[str, Any]) -> Iterator[str]:
    """The names of the force along each coordinate, "name.force", and of the states of an element."""
    if not isinstance(force, PointForce | JointForce):
        return
    if force.element is not None:
        made = element_type(force.element.type).make(force.name, "s", **force.element.values)
        yield from (f"{force.name}.{state.name}" for state in made.states)
        yield f"{force.name}.force"
    elif isinstance(force, PointForce):
        yield f"{force.name}.force"
    else:
        named = with_coordinates(force, joints)
        yield from (f"{named.called(coordinate)}.force" for coordinate in named.laws)


# --- Notes on the instants of controllers -----------------------------------------------------------------------------
# Those that split fixed steps, and those that lie after the end of the run.


#: A time is on the grid of fixed steps where it differs from a whole number of them by at most this part of a step.
ON_GRID = 1e-6


def note_instants(blocks: Mapping[str, Any], settings: Settings | None, reading: Reading) -> None:
    """Note the controllers whose instants lie inside of fixed steps, or that have at most one instant in the run."""
    if settings is None:
        return
    for name, each in blocks.get("controllers", {}).items():
        path = where("controllers", name, blocks.get("signals", {})) or ("controllers", name)
        what = None
        if each.start + each.period > settings.duration:
            count = "one instant" if each.start <= settings.duration else "no instant"
            what = f"'{name}' has {count} in a run of {settings.duration:g} s"
            hint = f"its period is {each.period:g} s: give a shorter one, or make the run longer"
        elif settings.step is not None and any(map(_splits(settings.step), (each.period, each.delay, each.start))):
            times = (2.0 if each.delay else 1.0) / each.period
            what = f"'{name}' acts inside of steps of {settings.step:g} s: they end there, and go on to their grid"
            hint = f"that makes up to {times:.4g} steps a second beside {1.0 / settings.step:.4g}; none where the step"
            hint += " divides 'period', 'delay' and 'start'"
        if what is not None:
            near = next(path[:end] for end in range(len(path), -1, -1) if path[:end] in reading.places)
            reading.notes.append(Problem(what, reading.places[near], hint))


def _splits(step: float) -> Any:
    def splits(time: float) -> bool:
        return abs(time / step - math.floor(time / step + 0.5)) > ON_GRID

    return splits
