"""The `expect` block: results that a run has to give: their object, time, value, tolerance and source.

`fits` checks that an expectation fits its quantity: the component, the number of values, their units.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import choose_from
from mbproj.base.registry import load
from mbproj.base.settings import Settings
from mbproj.joints.table import JOINTS
from mbproj.scene.blocks.coordinates import COORDINATES, coordinates_in, with_coordinates
from mbproj.scene.blocks.observables import (
    COMPONENTS,
    CONTACT,
    EXTREMES,
    MOMENTS,
    MOST_WHEELS,
    OBSERVABLES,
    OF_BUSHINGS,
    RATIOS,
    TENSION,
    GivenPassage,
    Observable,
    coordinates_of,
    of_coordinates,
    of_corners,
    output_of,
    passage_of,
    ratio_unit,
)
from mbproj.scene.expressions.dimensions import describe
from mbproj.scene.expressions.evaluate import Value
from mbproj.scene.fields.fields import (
    NAME,
    Alternatives,
    Complaint,
    Converted,
    Field,
    List,
    NameChoice,
    Named,
    NameReference,
    OneOf,
    Record,
    Rule,
    Schema,
    Text,
)
from mbproj.scene.fields.quantities import Number, agrees
from mbproj.scene.fields.reading import Reading, Unfit, either, label
from mbproj.scene.records import BodyForce, Bushing, Expectation, Force, Joint, JointForce, KeyPath, Motion, PointForce
from mbproj.scene.sampling import nearest_samples
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode

if TYPE_CHECKING:
    from mbproj.scene.scene import Scene


#: An expectation as read: values by key. Numbers whose unit depends on the quantity are `Value`s with a dimension.
ExpectationKeys = Mapping[str, Any]
#: The kinds of items that an expectation may be about, with the block that has them; "" where no one block does.
SUBJECTS: Mapping[str, str] = {
    "marker": "markers",
    "body": "bodies",
    "joint": "joints",
    "force": "forces",
    "motion": "motions",
    "stop": "",
    "friction": "",
    "state": "",
    "signal": "",
    "diagnostic": "",
}
BOUNDS = ("below", "above")


@dataclass(frozen=True)
class Measure(Field[Value]):
    """A number in the unit of a quantity that another key names, so that its unit is checked later. It must be greater
    than `above`."""

    above: float | None = None

    @property
    def expects(self) -> str:
        return "a number in the unit of the quantity"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> Value | None:
        if not isinstance(node, ScalarNode) or not node.text.strip():
            self.reject(node, path, reading)
            return None
        value = reading.value(node, reading.parse(node))
        if value is not None and self.above is not None and not value.number > self.above:
            reading.report(f"{label(path)} must be greater than {self.above:g}, found {value.number:.6g}", node.place)
            return None
        return value

    def schema(self) -> Schema:
        limits = {} if self.above is None else {"exclusiveMinimum": self.above}
        return {"description": self.expects, "type": ["number", "string"], "pattern": r"\S", **limits}


MEASURE = Measure()


@dataclass(frozen=True)
class Moment(Field["float | str | GivenPassage"]):
    """A time in s, one of `MOMENTS`, or the passage of a joint coordinate through a value: {crank.angle: 90 deg}."""

    @property
    def expects(self) -> str:
        return either(["a time in s", *MOMENTS, "a place {A.angle: 90 deg}"])

    def read(self, node: Node, path: KeyPath, reading: Reading) -> float | str | GivenPassage | None:
        if isinstance(node, MappingNode):
            if len(node.values) != 1:
                self.reject(node, path, reading)
                return None
            ((coordinate, where),) = node.values.items()
            value = MEASURE.read(where, (*path, coordinate), reading)
            return None if value is None else GivenPassage(coordinate, value)
        if isinstance(node, ScalarNode):
            if node.text in MOMENTS:
                return node.text
            if NAME.fullmatch(node.text) and node.text not in reading.names:
                hint = choose_from(node.text, MOMENTS)
                reading.report(f"unknown moment '{node.text}'", node.place, hint)
                return None
        return Number("s", minimum=0.0).read(node, path, reading)

    def schema(self) -> Schema:
        return {
            "description": self.expects,
            "type": ["number", "string", "object"],
            "pattern": r"\S",
            "minimum": 0.0,
            "minProperties": 1,
            "maxProperties": 1,
            "additionalProperties": MEASURE.schema(),
        }


def _not_empty(text: str) -> str:
    if not text.strip():
        raise Unfit("is empty", "say who computed or measured the number, or from which formula it follows")
    return text


VALUE: Field[Any] = Alternatives((Converted(MEASURE, lambda value: (value,)), List(MEASURE, None, "numbers")))
QUANTITIES = tuple(
    dict.fromkeys([*(name for of, names in OBSERVABLES.items() if of != "diagnostic" for name in names), *OF_BUSHINGS])
)

EXPECTATION: Record[ExpectationKeys] = Record(
    "an expectation",
    {
        **{of: NameReference(of, block) for of, block in SUBJECTS.items() if block},
        **{of: Text() for of in ("stop", "friction", "state", "signal")},
        "diagnostic": NameChoice("diagnostic", lambda: OBSERVABLES["diagnostic"]),
        "quantity": NameChoice("quantity", lambda: QUANTITIES),
        "component": NameChoice("component", lambda: COMPONENTS),
        "over": Text(),
        "between": List(Text(), 2, "markers"),
        "at": Moment(),
        "value": VALUE,
        "absolute": Measure(above=0.0),
        "relative": Number(above=0.0),
        "below": MEASURE,
        "above": MEASURE,
        "source": Converted(Text(), _not_empty),
    },
    dict,
    required=("at", "source"),
    choices=(
        OneOf(tuple(SUBJECTS), needed=True, hint="an expectation is of one thing; write another for the other"),
        OneOf(("quantity", "diagnostic"), needed=True, hint="a diagnostic is a quantity itself"),
        OneOf(("value", *BOUNDS), needed=True, hint="a bound stands without a value"),
        OneOf(("absolute", "relative", *BOUNDS), needed=True, hint="keep one of them"),
    ),
)


def subject(keys: ExpectationKeys) -> tuple[str, str, str]:
    """The kind of item that an expectation is about, the name of the item, and the quantity."""
    of = next(key for key in SUBJECTS if key in keys)
    return of, keys[of], keys.get("quantity", keys.get("diagnostic"))


def expectation(name: str, keys: ExpectationKeys, unit: str) -> Expectation:
    """The record of an expectation whose quantity is in `unit`."""
    of, item, quantity = subject(keys)
    value = tuple(part.number for part in keys["value"]) if "value" in keys else None
    bounds = {key: keys[key].number for key in BOUNDS if key in keys}
    if value is not None:
        relative = keys.get("relative", 0.0) * max(map(abs, value))
        bounds["tolerance"] = keys["absolute"].number if "absolute" in keys else relative
    at = passage_of(keys["at"]) if isinstance(keys["at"], GivenPassage) else keys["at"]
    further = {key: keys[key] for key in ("over", "between") if key in keys}
    return Expectation(
        name, of, item, quantity, unit, keys.get("component", ""), at, keys["source"], value, **bounds, **further
    )


def fits(name: str, keys: ExpectationKeys, observable: Observable, unit: str | None) -> Iterator[Complaint]:
    """Complaints about an expectation that does not fit the observable, whose unit here is `unit` (None: any)."""
    path: KeyPath = ("expect", name)
    what = subject(keys)[2]
    for check in (_component_fits, _count_fits):
        complaint = check(keys, observable, what)
        if complaint is not None:
            yield complaint._replace(path=(*path, *complaint.path))
            return
    numbers = [(("value", index), part) for index, part in enumerate(keys.get("value", ()))]
    for where, value in [*numbers, *(((key,), keys[key]) for key in ("absolute", *BOUNDS) if key in keys)]:
        if unit is not None and not agrees(unit, value.dimension):
            mine = f"is in {unit}" if unit else "has no unit"
            yield Complaint(
                _place(keys, path, where), f"'{what}' {mine}, this is {describe(value.dimension, with_unit=True)}"
            )
    if "relative" in keys and not any(part.number for part in keys["value"]):
        yield Complaint((*path, "relative"), "a relative tolerance of the value 0 is 0", "give an 'absolute' tolerance")


def _place(keys: ExpectationKeys, path: KeyPath, where: KeyPath) -> KeyPath:
    """The path of a number of the expectation. A single value is no list in the scene: its path has no index."""
    return (*path, where[0]) if where[0] != "value" or len(keys["value"]) == 1 else (*path, *where)


def _component_fits(keys: ExpectationKeys, observable: Observable, what: str) -> Complaint | None:
    component, of_one = keys.get("component"), keys["at"] not in EXTREMES and "value" in keys
    if component and observable.components == 1:
        return Complaint(("component",), f"'{what}' is one number and has no components", "leave it out")
    if component and observable.components == 4:
        return Complaint(("component",), "the sign of an orientation means nothing", "give all four as 'value'")
    if observable.components > 1 and not component and not of_one:
        key = "at" if "value" in keys else next((bound for bound in BOUNDS if bound in keys), "quantity")
        otherwise = "measure another quantity" if key == "quantity" else "expect it at a time"
        hint = "add component: x, y, z or norm" if observable.components == 3 else otherwise
        return Complaint((key,), f"'{what}' has {observable.components} components, and this is about one number", hint)
    return None


def _count_fits(keys: ExpectationKeys, observable: Observable, what: str) -> Complaint | None:
    needed = 1 if "component" in keys else observable.components
    count = len(keys.get("value", [None] * needed))
    if count == needed:
        return None
    also = ", or a component: x, y, z or norm" if needed == 3 else ""
    numbers = f"{needed} numbers" if needed > 1 else "one number"
    return Complaint(("value",), f"'{what}' needs {numbers} here, found {count}", f"give {numbers}{also}")


# --- Rules on expectations --------------------------------------------------------------------------------------------
# Their item has their quantity, and the run records at their times.


#: The words of a hint where the scene has no items of a kind.
NO_ITEMS = {"stop": "no stops", "friction": "none that sticks"}
#: The functions that return the units of the coordinates on which the stops and the frictions of a scene act, by name.
UNITS = {
    "stop": "mbproj.scene.blocks.stops:stop_units",
    "friction": "mbproj.scene.blocks.friction:friction_units",
}
#: The blocks that have states and signals.
CONTROLLED = ("signals", "states", "controllers", "forces")
Items = Mapping[str, Any]
Expected = Mapping[str, ExpectationKeys]


def of_markers_and_bodies(expected: Expected) -> Iterator[Complaint]:
    """A check of the expectations of markers, bodies and diagnostics."""
    for of in ("marker", "body", "diagnostic"):
        for name, keys, _, quantity in _of(of, expected):
            able = OBSERVABLES[of]
            if quantity in able:
                yield from fits(name, keys, able[quantity], able[quantity].unit)
            else:
                yield Complaint(("expect", name, "quantity"), f"a {of} has no '{quantity}'", _choices(quantity, able))


def of_joints(joints: Mapping[str, Joint], expected: Expected) -> Iterator[Complaint]:
    """A check of the expectations of joints."""
    for name, keys, item, quantity in _of("joint", expected):
        joint, observable = joints[item], OBSERVABLES["joint"].get(quantity)
        coordinates = coordinates_in(joint, None)
        theirs = {coordinate for coordinate in COORDINATES if coordinate not in coordinates}
        portions = joint.parameters["path"].portions if "path" in joint.parameters else 0
        theirs |= {f"{TENSION}{number}" for number in range(portions + 1, MOST_WHEELS + 2)}
        theirs |= set() if {"curve", "curves"} & joint.parameters.keys() else {CONTACT}
        lacking = theirs | {f"{coordinate}{more}" for coordinate in theirs for more in ("_speed", *RATIOS)}
        if JOINTS[joint.type].merges and not joint.reaction:
            message = f"joint '{item}' merges its bodies, and nothing of it is recorded"
            yield Complaint(("expect", name, "joint"), message, "give it reaction: true")
        elif observable is None or quantity in lacking:
            able = [other for other in OBSERVABLES["joint"] if other not in lacking]
            message = f"joint '{item}' is {joint.type} and has no '{quantity}'"
            yield Complaint(("expect", name, "quantity"), message, f"it has {', '.join(able)}")
        elif not output_of(quantity):
            yield from fits(name, keys, observable, observable.unit)
        elif keys.get("over") in coordinates_of(joints):
            yield from fits(name, keys, observable, ratio_unit(quantity, keys["over"]))


def of_forces(forces: Mapping[str, Force], expected: Expected) -> Iterator[Complaint]:
    """A check of the expectations of forces on bodies, between points and between frames."""
    from mbproj.scene.records import DistanceStop, PlaneStop

    for name, keys, item, quantity in _of("force", expected):
        force = forces[item]
        able = OF_BUSHINGS if isinstance(force, Bushing) else OBSERVABLES["force"]
        if isinstance(force, BodyForce):
            message = f"force '{item}' is an input, which a run does not find"
            yield Complaint(("expect", name, "force"), message, "expect an acceleration or a reaction")
        elif quantity not in able:
            what = f"force '{item}' is a bushing and" if isinstance(force, Bushing) else "a force"
            yield Complaint(("expect", name, "quantity"), f"{what} has no '{quantity}'", _choices(quantity, able))
        elif isinstance(force, DistanceStop | PlaneStop):
            message = f"force '{item}' is a stop"
            yield Complaint(
                ("expect", name, "force"), message, "write  stop: NAME  with the quantity gap, rate or force"
            )
        elif isinstance(force, PointForce | Bushing):
            yield from fits(name, keys, able[quantity], able[quantity].unit_with("m"))


def of_joint_forces(
    joints: Mapping[str, Joint], forces: Mapping[str, Force], expected: Expected
) -> Iterator[Complaint]:
    """A check of the expectations of forces on coordinates of joints."""
    for name, keys, item, quantity in _of("force", expected):
        force, able = forces[item], OBSERVABLES["force"]
        if not isinstance(force, JointForce):
            continue
        units = [COORDINATES[coordinate] for coordinate in acts_on(force, joints)]
        if not units and force.coulomb:
            message = f"force '{item}' is dry friction"
            yield Complaint(
                ("expect", name, "force"), message, f"write  friction: NAME  with {either(OBSERVABLES['friction'])}"
            )
        elif len(units) > 1:
            message = f"force '{item}' acts on {len(units)} coordinates"
            yield Complaint(("expect", name, "force"), message, "write a force for each of them")
        elif units and quantity in able:
            yield from fits(name, keys, able[quantity], able[quantity].unit_with(units[0]))


def of_motions(motions: Mapping[str, Motion], expected: Expected) -> Iterator[Complaint]:
    """A check of the expectations of motions."""
    for name, keys, item, quantity in _of("motion", expected):
        able = OBSERVABLES["motion"]
        if quantity not in able:
            yield Complaint(("expect", name, "quantity"), f"a motion has no '{quantity}'", _choices(quantity, able))
        else:
            unit = able[quantity].unit_with(COORDINATES[motions[item].coordinate])
            yield from fits(name, keys, able[quantity], unit)


def of_stops(expected: Expected, joints: Mapping[str, Joint], forces: Mapping[str, Force]) -> Iterator[Complaint]:
    """A check of the expectations of stops."""
    yield from _of_items_on_coordinates("stop", "stop", expected, joints, forces)


def of_frictions(expected: Expected, joints: Mapping[str, Joint], forces: Mapping[str, Force]) -> Iterator[Complaint]:
    """A check of the expectations of dry frictions."""
    yield from _of_items_on_coordinates("friction", "dry friction", expected, joints, forces)


def of_states(expected: Expected, *blocks: Mapping[str, Any]) -> Iterator[Complaint]:
    """A check of the expectations of states and signals."""
    by_kind = dict(zip(CONTROLLED, blocks, strict=True))
    for of, units in (("signal", _units(by_kind["signals"])), ("state", state_units(by_kind))):
        for name, keys, item, quantity in _of(of, expected):
            if item not in units:
                hint = choose_from(item, units, f"{of}s are") if units else f"the scene has no {of}s"
                yield Complaint(("expect", name, of), f"unknown {of} '{item}'", hint)
            elif quantity != "value":
                yield Complaint(("expect", name, "quantity"), f"a {of} has no '{quantity}'", "it has value")
            else:
                yield from fits(name, keys, OBSERVABLES[of]["value"], units[item] or None)


def state_units(blocks: Mapping[str, Any]) -> dict[str, str]:
    """The units of a scene's states by name, with those of elements and controllers; "" where a unit is not known."""
    of_elements: dict[str, str] = {}
    for name, force in blocks.get("forces", {}).items():
        if isinstance(force, PointForce | JointForce) and force.element is not None:
            from mbproj.scene.blocks.elements import element_type

            element = element_type(force.element.type).make(name, "s", **force.element.values)
            of_elements |= {f"{name}.{state.name}": state.unit for state in element.states}
    for controller in blocks.get("controllers", {}).values():
        of_elements |= {f"{controller.name}.{each.name}": each.unit for each in (*controller.hold, *controller.states)}
    return {**_units(blocks.get("states", {})), **{name: _symbols(unit) for name, unit in of_elements.items()}}


def _units(items: Mapping[str, Any]) -> dict[str, str]:
    return {name: _symbols(each.unit) for name, each in items.items()}


def _symbols(unit: str) -> str:
    """The unit as a scene writes it: "N*m" for the "N m" of results."""
    return unit.replace(" ", "*") if unit != "1" else ""


def _of_items_on_coordinates(
    of: str, what: str, expected: Expected, joints: Mapping[str, Joint], forces: Mapping[str, Force]
) -> Iterator[Complaint]:
    """Complaints about expectations of the kind `of`, "stop" or "friction"."""
    able, asked = OBSERVABLES[of], [*_of(of, expected)]
    units = load(UNITS[of])(joints, forces) if asked else {}
    for name, keys, item, quantity in asked:
        if item not in units:
            hint = choose_from(item, units, f"{what}s are") if units else f"the scene has {NO_ITEMS[of]}"
            yield Complaint(("expect", name, of), f"unknown {what} '{item}'", hint)
        elif quantity not in able:
            yield Complaint(("expect", name, "quantity"), f"a {what} has no '{quantity}'", _choices(quantity, able))
        else:
            yield from fits(name, keys, able[quantity], able[quantity].unit_with(units[item]))


def expectations_of(blocks: Mapping[str, Any]) -> Iterator[Expectation]:
    """The records of a scene's expectations; `blocks` are its blocks as read, after all checks have passed."""
    joints = blocks.get("joints", {})
    for name, keys in blocks.get("expect", {}).items():
        of, item, quantity = subject(keys)
        coordinate, able = "", OBSERVABLES[of]
        if of == "force":
            force = blocks["forces"][item]
            able = OF_BUSHINGS if isinstance(force, Bushing) else able
            coordinate = COORDINATES[acts_on(force, joints)[0]] if isinstance(force, JointForce) else "m"
        elif of == "motion":
            coordinate = COORDINATES[blocks["motions"][item].coordinate]
        elif of in UNITS:
            coordinate = load(UNITS[of])(joints, blocks.get("forces", {}))[item]
        elif of in ("state", "signal"):
            units = state_units(blocks) if of == "state" else _units(blocks["signals"])
            yield expectation(name, keys, units[item])
            continue
        unit = ratio_unit(quantity, keys["over"]) if output_of(quantity) else able[quantity].unit_with(coordinate)
        yield expectation(name, keys, unit)


def unsampled(expected: Expected, settings: Settings) -> Iterator[Complaint]:
    """A check that the run records at the times of the expectations."""
    for name, keys in expected.items():
        time, path = keys["at"], ("expect", name, "at")
        if isinstance(time, GivenPassage):
            continue
        near = None if isinstance(time, str) else nearest_samples(settings, time)
        if settings.duration is not None and near and time > settings.duration:
            message = f"{time:.10g} s is after the end of the run, at {settings.duration:.10g} s"
            yield Complaint(path, message, "choose an earlier time, or 'end'")
        elif near:
            times = " and ".join(f"{sample:.10g} s" for sample in near)
            message = f"there is no sample at {time:.10g} s; the nearest are at {times}"
            yield Complaint(path, message, "choose one of them, or another 'output_step'")


def acts_on(force: JointForce, joints: Mapping[str, Joint]) -> list[str]:
    """The coordinates along which results record the force among the forces. They do not record dry friction there that
    may stick."""
    whole = with_coordinates(force, joints)
    smooth = (name for name, dry in whole.coulomb.items() if dry.regularised is not None)
    return list(dict.fromkeys((*whole.laws, *smooth)))


def _of(of: str, expected: Expected) -> Iterator[tuple[str, ExpectationKeys, str, str]]:
    """The name, the values by key, the item and the quantity of each expectation of the kind `of`."""
    for name, keys in expected.items():
        if of in keys:
            yield (name, keys, *subject(keys)[1:])


def _choices(quantity: str, able: Mapping[str, Observable]) -> str:
    return choose_from(quantity, able, "it has")


CHECKS = (
    Rule(("expect",), of_markers_and_bodies),
    Rule(("joints", "expect"), of_joints),
    Rule(("forces", "expect"), of_forces),
    Rule(("joints", "forces", "expect"), of_joint_forces),
    Rule(("motions", "expect"), of_motions),
    Rule(("joints", "expect"), of_coordinates),
    Rule(("expect",), of_corners, besides=("markers",)),
    Rule(("expect",), of_stops, besides=("joints", "forces")),
    Rule(("expect",), of_frictions, besides=("joints", "forces")),
    Rule(("expect",), of_states, besides=CONTROLLED),
)


# --- The measures of a sweep, evaluated on each run -------------------------------------------------------------------
# Each is written as an expectation without a value.


_WORDS = (*SUBJECTS, "quantity", "component", "over", "between", "at")

A_MEASURE: Record[ExpectationKeys] = Record(
    "a measure",
    {key: EXPECTATION.keys[key] for key in _WORDS},
    dict,
    required=("at",),
    choices=(
        OneOf(tuple(SUBJECTS), needed=True, hint="a measure is of one thing; write another for the other"),
        OneOf(("quantity", "diagnostic"), needed=True, hint="a diagnostic is a quantity itself"),
    ),
)


def _some(measures: Mapping[str, ExpectationKeys]) -> Mapping[str, ExpectationKeys]:
    if not measures:
        raise Unfit("is empty", "say what to measure, as in  tip: {marker: tip, quantity: position, ..}")
    return measures


MEASURES: Field[Mapping[str, ExpectationKeys]] = Converted(Named("measure", A_MEASURE), _some)


def items_of(scene: Scene) -> dict[str, tuple[str, ...]]:
    """The names of the items that measures may be about, by block, as a `Reading` has them."""
    return {block: tuple(items) for block, items in _blocks(scene).items()}


def complaints(measures: Mapping[str, ExpectationKeys], scene: Scene) -> Iterator[Complaint]:
    """Complaints about measures of items or quantities that the scene does not have."""
    blocks = {**_blocks(scene), "expect": measures}
    for check in CHECKS:
        yield from map(_under_measure, check.complaints(blocks, blocks))


def untimely(measures: Mapping[str, ExpectationKeys], settings: Settings) -> Iterator[Complaint]:
    """Complaints about measures at times at which a run with these settings has no sample."""
    return map(_under_measure, unsampled(measures, settings))


def measures_of(measures: Mapping[str, ExpectationKeys], scene: Scene) -> tuple[Expectation, ...]:
    """The records of measures that passed the checks: expectations without a value or a bound."""
    expected = {name: {**words, "source": ""} for name, words in measures.items()}
    return tuple(expectations_of({**_blocks(scene), "expect": expected}))


def _under_measure(complaint: Complaint) -> Complaint:
    """The complaint about an expectation as one about the key `measure`."""
    return complaint._replace(path=("measure", *complaint.path[1:]))


def _blocks(scene: Scene) -> dict[str, Mapping[str, Any]]:
    kinds: Mapping[str, Any] = {
        "bodies": scene.bodies,
        "joints": scene.joints,
        "forces": scene.forces,
        "motions": scene.motions,
        "markers": scene.markers,
        "signals": scene.signals,
        "states": scene.states,
        "controllers": scene.controllers,
    }
    return {block: {item.name: item for item in items} for block, items in kinds.items()}
