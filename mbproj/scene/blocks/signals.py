"""The `signals` and `states` blocks: expressions by name, and states that integrate a derivative.

signals:
  error: 1 rad - pin.angle
  U: {value: 20*error + 30*integral, unit: V}
  lead: {transfer_function: {of: error, num: [0.1, 1], den: [0.01, 1]}}
states: {integral: {derivative: error}, current: {derivative: (U - 0.8*current)/2e-3, initial: 0 A, scale: 1 A}}
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from typing import TYPE_CHECKING, Any

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import Problem, choose_from
from mbproj.base.settings import Settings
from mbproj.functions.elements import Controller, Held, ScalarState, Signal
from mbproj.functions.program import Program
from mbproj.joints.table import JOINTS
from mbproj.scene.blocks.control_blocks import BLOCKS, ControlBlock, Expanded
from mbproj.scene.blocks.coordinates import with_coordinates
from mbproj.scene.blocks.elements import element_type
from mbproj.scene.blocks.expectations import MEASURE, Measure
from mbproj.scene.blocks.expression_names import NOT_FREE, VALUE, unit_name
from mbproj.scene.blocks.parameters import NAME, NAME_RULE
from mbproj.scene.expressions.dimensions import Inferred, called, describe
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.expressions.units import BARE, TIME, Dimension, unit_at
from mbproj.scene.fields.fields import Alternatives, Converted, Field, Named, OneOf, Record, Schema, Text
from mbproj.scene.fields.quantities import Number
from mbproj.scene.fields.reading import Reading, Unfit
from mbproj.scene.records import BodyForce, Force, JointForce, KeyPath, PointForce
from mbproj.scene.text.nodes import Node, as_mapping

if TYPE_CHECKING:
    from mbproj.scene.scene import Scene


def _unit(text: str) -> Dimension:
    """The dimension of a unit of SI. Raises Unfit for a text that is none."""
    unit = unit_at(text, 0)
    if unit is None or text[unit[1] :].strip():
        raise Unfit(f"is '{text}', which is no unit", "write it as in kg*m^2/s, V, A or bar")
    if (unit[0].multiply, unit[0].divide) != (1.0, 1.0):
        raise Unfit(f"is '{text}', which is not of SI", f"signals are in SI: {called(unit[0].dimension)}")
    return unit[0].dimension


def _signal(
    name: str,
    value: tuple[Program, Inferred] | None = None,
    unit: Dimension | None = None,
    **block: ControlBlock,
) -> Signal | Expanded:
    """The signal of an expression `value`, or the items that replace the one given block. Raises Unfit where the
    expression is in another unit."""
    if value is None:
        (only,) = block.values()
        return only.expanded(name, None if unit is None else called(unit))
    program, inferred = value
    if unit is not None and inferred.dimension is not None and not inferred.agrees(unit):
        its = describe(inferred.dimension, with_unit=True)
        raise Unfit(f"is in {called(unit)}, and its expression is {its}", "check the units of both")
    return Signal(name, program, unit_name(inferred.certain if unit is None else unit))


@dataclass(frozen=True)
class _PlainSignal(Field["Signal | Expanded"]):
    """A signal that is written as its expression alone."""

    @property
    def expects(self) -> str:
        return VALUE.expects

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Signal | Expanded | None:
        value = VALUE.read(node, path, reading)
        return None if value is None else _signal(str(path[-1]), value)

    def schema(self) -> Schema:
        return VALUE.schema()


SIGNAL_KEYS: dict[str, Field[Any]] = {"value": VALUE, **BLOCKS, "unit": Converted(Text(), _unit)}
_SIGNAL: Field[Signal | Expanded] = Alternatives(
    (
        _PlainSignal(),
        Record("a signal", SIGNAL_KEYS, _signal, choices=(OneOf(("value", *BLOCKS), needed=True),), named=True),
    )
)


def _state(
    name: str,
    derivative: tuple[Program, Inferred],
    initial: Value | None = None,
    scale: Value | None = None,
) -> ScalarState:
    """The record of a state. Its unit is that of its numbers, else that of its derivative times a second. Raises Unfit
    where these differ."""
    rate, of_rate = derivative[0], derivative[1].certain
    dimensions = [
        each.dimension for each in (initial, scale) if each is not None and each.dimension not in (None, BARE)
    ]
    dimension = dimensions[0] if dimensions else None
    for other in dimensions[1:]:
        if dimension is not None and other is not None and not dimension.agrees(other):
            raise Unfit(f"begins with {describe(dimension)} and has a scale that is {describe(other)}")
    if of_rate is not None and of_rate != BARE:
        integrated = of_rate * TIME
        if dimension is not None and not dimension.agrees(integrated):
            raise Unfit(
                f"is {describe(dimension)}, and its derivative is {describe(of_rate)}", "check the units of both"
            )
        dimension = dimension or integrated
    return ScalarState(
        name,
        rate,
        0.0 if initial is None else initial.number,
        1.0 if scale is None else scale.number,
        unit_name(dimension),
    )


STATE_KEYS: dict[str, Field[Any]] = {"derivative": VALUE, "initial": MEASURE, "scale": Measure(above=0.0)}
_STATE: Record[ScalarState] = Record("a state", STATE_KEYS, _state, ("derivative",), named=True)
#: The fields of the two blocks.
SIGNALS = Named("signal", _SIGNAL, reserved=NOT_FREE, names=NAME, rule=NAME_RULE)
STATES = Named("state", _STATE, reserved=NOT_FREE, names=NAME, rule=NAME_RULE)


# --- The `controllers` block ------------------------------------------------------------------------------------------
# Values computed at instants and held in between, and states that a controller remembers.
#     controllers:
#       speed:
#         period: 20 ms
#         delay: 1 ms
#         hold: {u: -80*rail.displacement - 8*rail.displacement_dot - 5*sum}
#         states: {sum: {next: sum + rail.displacement}}


def _hold(
    name: str,
    value: tuple[Program, Inferred] | None = None,
    initial: Value | None = None,
    next: tuple[Program, Inferred] | None = None,
) -> Held:
    expression = value or next
    assert expression is not None
    program, dimension = expression[0], expression[1].certain
    if initial is not None and dimension is not None and initial.dimension is not None:
        if not initial.dimension.agrees(dimension):
            raise Unfit("has an initial value in another unit than its expression", "check the units of both")
        dimension = dimension or initial.dimension
    start = 0.0 if initial is None else initial.number
    return Held(name, program, start, unit_name(dimension or (initial.dimension if initial is not None else None)))


@dataclass(frozen=True)
class _PlainHeldValue(Field[Held]):
    """A held value that is written as its expression alone."""

    @property
    def expects(self) -> str:
        return VALUE.expects

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Held | None:
        value = VALUE.read(node, path, reading)
        return None if value is None else _hold(str(path[-1]), value)

    def schema(self) -> Schema:
        return VALUE.schema()


HELD: Field[Held] = Alternatives(
    (_PlainHeldValue(), Record("a held value", {"value": VALUE, "initial": MEASURE}, _hold, ("value",), named=True))
)
NEXT: Record[Held] = Record(
    "a state of a controller", {"next": VALUE, "initial": MEASURE}, _hold, ("next",), named=True
)


def _controller(
    name: str,
    period: float,
    hold: Mapping[str, Held] | None = None,
    states: Mapping[str, Held] | None = None,
    delay: float = 0.0,
    start: float = 0.0,
) -> Controller:
    held, states = hold or {}, states or {}
    if not held:
        raise Unfit("holds nothing", "write what it computes: hold: {u: ..}")
    both = sorted(held.keys() & states.keys())
    if both:
        raise Unfit(f"has '{both[0]}' twice", "a held value and a state cannot share a name")
    if not delay < period:
        raise Unfit(f"has a delay of {delay:g} s and a period of {period:g} s", "the delay is shorter than the period")
    return Controller(name, period, tuple(held.values()), tuple(states.values()), delay, start)


@dataclass(frozen=True)
class ControllerRecord(Record[Controller]):
    """A controller. Its expressions name its own held values and states without its name in front."""

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Controller | None:
        mapping = as_mapping(node)
        blocks = [] if mapping is None else [mapping.values[key] for key in ("hold", "states") if key in mapping.values]
        names = [name for block in map(as_mapping, blocks) if block is not None for name in block.keys]
        reading.inner = {name: f"{path[-1]}.{name}" for name in names}
        try:
            return super().read(node, path, reading)
        finally:
            reading.inner = {}


CONTROLLER_KEYS: dict[str, Field[Any]] = {
    "period": Number("s", above=0.0),
    "hold": Named("held value", HELD, reserved=NOT_FREE, names=NAME, rule=NAME_RULE),
    "states": Named("state", NEXT, reserved=NOT_FREE, names=NAME, rule=NAME_RULE),
    "delay": Number("s", minimum=0.0),
    "start": Number("s", minimum=0.0),
}
CONTROLLER: Record[Controller] = ControllerRecord(
    "a controller", CONTROLLER_KEYS, _controller, ("period", "hold"), named=True
)


# --- Blocks to plain signals ------------------------------------------------------------------------------------------
# Replaces the blocks among a scene's signals (`control.blocks`) by plain signals, states and controllers.


#: Blocks of a scene whose items have parts that expressions name with a point, as in `pin.angle`.
WITH_PARTS = ("joints", "forces", "markers", "controllers")


def expanded(scene: Mapping[str, Any], reading: Reading) -> Mapping[str, Any]:
    """Return the blocks of a `scene` with plain signals, states and controllers in place of blocks. Reports
    signals whose parts would have the names of another item's parts."""
    signals = scene.get("signals", {})
    blocks = {name: each for name, each in signals.items() if isinstance(each, Expanded)}
    if not blocks:
        return scene
    for name, block in blocks.items():
        for kind in _blocks_with_name(name, block, scene):
            message = f"'{name}' is the name of one of the {kind} too, and its parts would be called alike"
            reading.report(message, reading.places["signals", name], "give the signal another name")
    parts = [part for each in signals.values() for part in (each.signals if isinstance(each, Expanded) else (each,))]
    states = [*scene.get("states", {}).values(), *(state for block in blocks.values() for state in block.states)]
    delays = [each for block in blocks.values() for each in block.controllers]
    controllers = [*delays, *scene.get("controllers", {}).values()]
    named = {"signals": parts, "states": states, "controllers": controllers}
    return {**scene, **{key: {each.name: each for each in several} for key, several in named.items()}}


def _blocks_with_name(name: str, block: Expanded, blocks: Mapping[str, Any]) -> Iterator[str]:
    """The blocks of the scene with an item of this name, where the signal has parts; none where it has no parts."""
    if len(block.signals) > 1 or block.states or block.controllers:
        for kind in WITH_PARTS:
            if any(each.replace("-", "_") == name for each in blocks.get(kind, {})):
                yield kind


def where(kind: str, name: str, signals: Mapping[str, object]) -> tuple[str, ...] | None:
    """The path of the signal from which the item `name` of the block `kind` was expanded; None where the scene itself
    has the item."""
    owner = name.partition(".")[0]
    return ("signals", owner) if "." in name or (kind == "controllers" and owner in signals) else None


# --- A rule on expressions --------------------------------------------------------------------------------------------
# The signals, states, coordinates and forces that they name exist.


#: Parts of items that are known only after the forces, so that no expression of a force may name them.
TOO_LATE = ("angle_ddot", "displacement_ddot", "length_ddot", "acceleration", "reaction", "reaction_force")
Blocks = Mapping[str, Any]


def with_known_names(blocks: Blocks, settings: Settings | None, reading: Reading) -> Blocks:
    """The items of the scene by block and name, with plain signals, states and controllers in place of blocks. Reports
    unknown names in their expressions, and notes the instants of controllers that may be a mistake."""
    blocks = expanded(blocks, reading)
    check_names(blocks, reading)
    note_instants(blocks, settings, reading)
    return blocks


def check_names(blocks: Blocks, reading: Reading) -> None:
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
    owner, _, last = name.rpartition(".")
    # Linear models and results have velocity_x and angle_speed for what an expression calls x_dot and angle_dot.
    rate = f"{owner}.{last.removeprefix('velocity_').removesuffix('_speed')}_dot"
    hint = f"did you mean '{rate}'?" if rate in able else choose_from(name, able)
    return f"unknown name '{name}'", place, hint


def _functions_with_names(blocks: Blocks) -> Iterator[tuple[KeyPath, Program]]:
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
                    path = where("controllers", name, signals)
                    yield path or ("controllers", name, block, each.name), each.program
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


def nameable(blocks: Blocks) -> Iterator[str]:
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
        element = element_type(force.element.type).make(force.name, "s", **force.element.values)
        yield from (f"{force.name}.{state.name}" for state in element.states)
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
