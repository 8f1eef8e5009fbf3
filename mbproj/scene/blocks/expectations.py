"""Rules on expectations: their item has their quantity, and the run records at their times."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mbproj.errors import choose_from
from mbproj.joints import JOINTS
from mbproj.registry import load
from mbproj.scene.blocks.coordinates import COORDINATES, coordinates_in, with_coordinates
from mbproj.scene.blocks.expectations import Given, expectation, fits, subject
from mbproj.scene.blocks.observables import (
    CONTACT,
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
    ratio_unit,
)
from mbproj.scene.fields.containers import Complaint, Rule
from mbproj.scene.fields.reading import either
from mbproj.scene.records import BodyForce, Bushing, Expectation, Force, Joint, JointForce, Motion, PointForce, Settings
from mbproj.scene.sampling import nearest_samples

#: The words of a hint where the scene has no items of a kind.
NO_ITEMS = {"stop": "no stops", "friction": "none that sticks"}
#: The functions that return the units of the coordinates on which the stops and the frictions of a scene act, by name.
UNITS = {
    "stop": "mbproj.scene.blocks.forces.stops:stop_units",
    "friction": "mbproj.scene.blocks.forces.dry_joints:friction_units",
}
#: The blocks that have states and signals.
CONTROLLED = ("signals", "states", "controllers", "forces")
Items = Mapping[str, Any]
Expected = Mapping[str, Given]


def of_markers_and_bodies(expected: Expected) -> Iterator[Complaint]:
    """A check of the expectations of markers, bodies and diagnostics."""
    for of in ("marker", "body", "diagnostic"):
        for name, given, _, quantity in _of(of, expected):
            able = OBSERVABLES[of]
            if quantity in able:
                yield from fits(name, given, able[quantity], able[quantity].unit)
            else:
                yield Complaint(("expect", name, "quantity"), f"a {of} has no '{quantity}'", _choices(quantity, able))


def of_joints(joints: Mapping[str, Joint], expected: Expected) -> Iterator[Complaint]:
    """A check of the expectations of joints."""
    for name, given, item, quantity in _of("joint", expected):
        joint, observable = joints[item], OBSERVABLES["joint"].get(quantity)
        own = coordinates_in(joint, None)
        theirs = {coordinate for coordinate in COORDINATES if coordinate not in own}
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
            yield from fits(name, given, observable, observable.unit)
        elif given.get("over") in coordinates_of(joints):
            yield from fits(name, given, observable, ratio_unit(quantity, given["over"]))


def of_forces(forces: Mapping[str, Force], expected: Expected) -> Iterator[Complaint]:
    """A check of the expectations of forces on bodies, between points and between frames."""
    from mbproj.scene.stops import DistanceStop, PlaneStop

    for name, given, item, quantity in _of("force", expected):
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
            yield from fits(name, given, able[quantity], able[quantity].unit_with("m"))


def of_joint_forces(
    joints: Mapping[str, Joint], forces: Mapping[str, Force], expected: Expected
) -> Iterator[Complaint]:
    """A check of the expectations of forces on coordinates of joints."""
    for name, given, item, quantity in _of("force", expected):
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
            yield from fits(name, given, able[quantity], able[quantity].unit_with(units[0]))


def of_motions(motions: Mapping[str, Motion], expected: Expected) -> Iterator[Complaint]:
    """A check of the expectations of motions."""
    for name, given, item, quantity in _of("motion", expected):
        able = OBSERVABLES["motion"]
        if quantity not in able:
            yield Complaint(("expect", name, "quantity"), f"a motion has no '{quantity}'", _choices(quantity, able))
        else:
            unit = able[quantity].unit_with(COORDINATES[motions[item].coordinate])
            yield from fits(name, given, able[quantity], unit)


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
        for name, given, item, quantity in _of(of, expected):
            if item not in units:
                hint = choose_from(item, units, f"{of}s are") if units else f"the scene has no {of}s"
                yield Complaint(("expect", name, of), f"unknown {of} '{item}'", hint)
            elif quantity != "value":
                yield Complaint(("expect", name, "quantity"), f"a {of} has no '{quantity}'", "it has value")
            else:
                yield from fits(name, given, OBSERVABLES[of]["value"], units[item] or None)


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
    for name, given, item, quantity in asked:
        if item not in units:
            hint = choose_from(item, units, f"{what}s are") if units else f"the scene has {NO_ITEMS[of]}"
            yield Complaint(("expect", name, of), f"unknown {what} '{item}'", hint)
        elif quantity not in able:
            yield Complaint(("expect", name, "quantity"), f"a {what} has no '{quantity}'", _choices(quantity, able))
        else:
            yield from fits(name, given, able[quantity], able[quantity].unit_with(units[item]))


def expectations_of(blocks: Mapping[str, Any]) -> Iterator[Expectation]:
    """The records of a scene's expectations; `blocks` are its blocks as read, after all checks have passed."""
    joints = blocks.get("joints", {})
    for name, given in blocks.get("expect", {}).items():
        of, item, quantity = subject(given)
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
            own = state_units(blocks) if of == "state" else _units(blocks["signals"])
            yield expectation(name, given, own[item])
            continue
        unit = ratio_unit(quantity, given["over"]) if output_of(quantity) else able[quantity].unit_with(coordinate)
        yield expectation(name, given, unit)


def unsampled(expected: Expected, settings: Settings) -> Iterator[Complaint]:
    """A check that the run records at the times of the expectations."""
    for name, given in expected.items():
        time, path = given["at"], ("expect", name, "at")
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


def _of(of: str, expected: Expected) -> Iterator[tuple[str, Given, str, str]]:
    """The name, the values by key, the item and the quantity of each expectation of the kind `of`."""
    for name, given in expected.items():
        if of in given:
            yield (name, given, *subject(given)[1:])


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
