"""The scene format: the field of each key. The reader, its messages and the schema all follow from these tables."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any, final

from mbproj.base.registry import calling, load
from mbproj.base.settings import SETTINGS, SIZE, SettingEntry
from mbproj.joints.table import COORDINATE_UNITS, INERTIA_UNITS, JOINTS, JointType, Parameter
from mbproj.scene.blocks.bodies import BODY
from mbproj.scene.blocks.coordinates import COORDINATES, act_on_coordinates, drive_coordinates, on_bodies
from mbproj.scene.blocks.expectations import CHECKS, EXPECTATION
from mbproj.scene.blocks.parameters import Parameters
from mbproj.scene.fields.fields import (
    Alternatives,
    Complaint,
    Converted,
    Deferred,
    Field,
    Flag,
    List,
    NameChoice,
    Named,
    NameReference,
    OneOf,
    Record,
    Rule,
    Text,
    Variants,
)
from mbproj.scene.fields.placing import (
    AXES,
    AXIS,
    BODY_DIRECTION,
    BODY_POINT,
    FRAMES,
    JOINT_POINT,
    ORIGIN_AND_POINT,
    PLANE,
    TWO_BODIES,
    TWO_POINTS,
    face_normal,
    of_side,
    on_plane,
    with_face,
)
from mbproj.scene.fields.quantities import (
    Integer,
    Number,
    Placed,
    not_along,
    of_these_bodies,
    pair_of,
    position_in,
    same_kind,
    vector,
)
from mbproj.scene.records import GROUND, Joint, Marker, Orientations, Pair

# --- The `simulation` block -------------------------------------------------------------------------------------------
# The field that reads each setting.


def _field(entry: SettingEntry) -> Field[Any]:
    """The field that reads a setting."""
    if entry.kind == "str":
        what = "projection method" if entry.name == "projection" else entry.key.replace("_", " ")
        return NameChoice(what, lambda: entry.words)
    if entry.kind == "bool":
        return Flag()
    if entry.kind == "int":
        return Integer(minimum=1)
    number = Number("" if entry.takes in ("1", SIZE) else entry.takes, above=entry.above, maximum=entry.maximum)
    if entry.kind == "float":
        return number
    if entry.kind == "tuple[float, ...]":
        return List(number, None, "times")
    return Alternatives((Converted(number, lambda value: (value, value)), List(number, 2)))


def _fields(length: int) -> dict[str, Field[Any]]:
    """The fields of the settings whose paths have this length, by their keys."""
    return {entry.key: _field(entry) for entry in SETTINGS.values() if len(entry.path) == length}


#: The fields of the options of a projection.
OF_PROJECTION: Mapping[str, Field[Any]] = _fields(2)
PROJECTION: Field[dict[str, Any]] = Alternatives(
    (
        Converted(OF_PROJECTION["method"], lambda method: {"method": method}),
        Record("a projection", OF_PROJECTION, dict),
    )
)
SIMULATION: Record[dict[str, Any]] = Record(
    "a simulation", {**_fields(1), "projection": PROJECTION}, dict, choices=(OneOf(("step", "tolerance")),)
)


# --- The scene format -------------------------------------------------------------------------------------------------


#: The keys that give the axes of a joint, by the frame of its type.
FRAME_KEYS: Mapping[str, Mapping[str, Field[Placed]]] = {
    "point": {},
    "axis": {"axis": AXIS},
    "normal": {"axis": AXIS},
    "face": {"axis": AXIS},
    "axes": {"axes": AXES},
}


JOINT_TYPE = NameChoice("joint type", lambda: JOINTS)


@cache
def _joint_record(type_name: str) -> Record[Joint]:
    return replace(_joint_variant(type_name, JOINTS[type_name]), elsewhere=_JointKeys())


def _joint_variant(type_name: str, kind: JointType) -> Record[Joint]:
    """The record that reads a joint of this type."""
    units = {name: COORDINATE_UNITS[row[0]] for name, row in kind.coordinates.items()}
    if kind.frame == "joints":
        from mbproj.scene.blocks.couplings import coupling_record

        return coupling_record(type_name, JOINT_TYPE)
    if kind.frame == "path":
        from mbproj.scene.blocks.ropes import rope_record

        return rope_record(type_name, {"type": JOINT_TYPE, **_of_coordinates(type_name, units)})
    if kind.is_on_plane:
        return _on_plane(type_name, kind, units)
    frame = {**FRAME_KEYS[kind.frame], **({"x_axis": AXIS} if kind.x_axis != "none" else {})}
    two_points = ORIGIN_AND_POINT if {"curve", "curves"} & kind.parameters.keys() else TWO_POINTS
    place = {"locations": two_points} if kind.separate else {"location": JOINT_POINT}
    keys: dict[str, Field[Any]] = {"type": JOINT_TYPE, "bodies": TWO_BODIES, **place, **frame}
    keys |= {name: _parameter(each) for name, each in kind.parameters.items()}
    if kind.merges:
        keys |= {"reaction": Flag(), "axes": FRAMES}
    keys |= _of_coordinates(type_name, units)
    (point,) = place
    checks = [Rule(("bodies", point), of_these_bodies(point))]
    checks += [Rule(("bodies", key), of_these_bodies(key, alone=kind.frame in ("normal", "face"))) for key in frame]
    checks += [Rule((point, key), same_kind(point, key)) for key in frame]
    checks += [Rule(("axis", "x_axis"), not_along("x_axis"))] if kind.x_axis != "none" else []
    if kind.frame == "face":
        keys["normal"] = BODY_DIRECTION
        checks += [Rule(("bodies", "normal"), of_side("normal", 1)), Rule(("axis", "normal"), face_normal)]
    if kind.merges:
        checks += [Rule(("bodies", "axes"), of_these_bodies("axes")), Rule((point, "axes"), same_kind(point, "axes"))]
    wanted = [key for key in frame if key != "x_axis" or kind.x_axis == "required"]
    wanted += ["normal"] if kind.frame == "face" else []
    needed = ("type", "bodies", point, *wanted, *kind.required_parameters)
    return Record(f"a {type_name} joint", keys, _joint, needed, tuple(checks), named=True)


def _on_plane(type_name: str, kind: JointType, units: Mapping[str, str]) -> Record[Joint]:
    """The record that reads a joint of this type, whose body 2 stays on a plane of body 1."""
    fields: dict[str, Field[Any]] = {
        "plane": PLANE,
        "centre": BODY_POINT,
        **({"axis": BODY_DIRECTION} if kind.has_axis else {}),
        **({"x_axis": BODY_DIRECTION} if kind.x_axis == "required" else {}),
    }
    fields |= {name: _parameter(each) for name, each in kind.parameters.items()}
    keys = {"type": JOINT_TYPE, "bodies": TWO_BODIES, **fields, **_of_coordinates(type_name, units)}
    sides = {"plane": 0, "centre": 1, "axis": 1, "x_axis": 1}
    checks = [Rule(("bodies", key), of_side(key, side)) for key, side in sides.items() if key in fields]
    checks += [Rule(("axis", "x_axis"), not_along("x_axis"))] if "x_axis" in fields else []
    return Record(f"a {type_name} joint", keys, _joint, ("type", "bodies", *fields), tuple(checks), named=True)


def _of_coordinates(type_name: str, units: Mapping[str, str]) -> dict[str, Field[Any]]:
    """The keys of a joint with a value for each coordinate; `units` are those of its coordinates, by name."""
    if not units:
        return {}
    inertias = {name: Number(INERTIA_UNITS[unit], minimum=0.0) for name, unit in units.items()}
    limits = {name: Deferred[Any]("mbproj.scene.blocks.stops:limit_field", (unit,)) for name, unit in units.items()}
    return {
        "speed": _each("a speed", {name: Number(f"{unit}/s") for name, unit in units.items()}),
        "reflected_inertia": _each("a reflected inertia", inertias),
        "limits": Record(f"a {type_name} joint", limits, dict, elsewhere=frozenset(COORDINATES)),
        **{name: position_in(unit) for name, unit in units.items()},
    }


def _parameter(entry: Parameter) -> Field[Any]:
    return Deferred("mbproj.scene.blocks.couplings:parameter", (entry,))


def _each(what: str, numbers: Mapping[str, Field[float]]) -> Field[dict[str, float]]:
    """The field of numbers by coordinate of a joint, none of which is required; a number alone where the joint has one
    coordinate."""
    if len(numbers) > 1:
        return Record(what, numbers, dict)
    (number,) = numbers.values()
    return Converted(number, lambda value: dict.fromkeys(numbers, value))


def _joint(
    name: str, type: str, bodies: tuple[str, str], speed: Mapping[str, float] | None = None, **values: Any
) -> Joint:
    def pair(*keys: str) -> Pair | None:
        pairs = [values[key] for key in keys if key in values]
        return pair_of(pairs[0], bodies) if pairs else None

    kind = JOINTS[type]
    points: Pair | None
    axes: Pair | None
    if kind.is_on_plane:
        points, axes, across = on_plane(bodies, *(values.get(key) for key in ("plane", "centre", "axis", "x_axis")))
    else:
        points, axes = pair("location", "locations"), None if kind.merges else pair("axis", "axes")
        across = pair("x_axis")
        axes = axes and with_face(axes, bodies, values["normal"]) if kind.frame == "face" else axes
    assert points is not None
    frames = None
    if kind.merges and "axes" in values:
        frames = Orientations(values["axes"][bodies[0]], values["axes"][bodies[1]], local=True)
    return Joint(
        name,
        type,
        bodies,
        points,
        axes,
        start={key: values[key] for key in kind.coordinates if key in values},
        speed=speed or {},
        parameters={key: values[key] for key in kind.parameters if key in values},
        reaction=values.get("reaction", False),
        reflected_inertia=values.get("reflected_inertia", {}),
        limits=values.get("limits", {}),
        frames=frames,
        x_axis=across,
    )


@final
class _JointRecords(Mapping[str, Record[Joint]]):
    """The record of each type of joint, which is made when a scene first has a joint of the type."""

    def __getitem__(self, name: str) -> Record[Joint]:
        return _joint_record(name)

    def __iter__(self) -> Iterator[str]:
        return iter(JOINTS)

    def __len__(self) -> int:
        return len(JOINTS)


@final
class _JointKeys(Container[str]):
    """The keys of all joints, which each record of a joint knows for its messages."""

    def __contains__(self, key: object) -> bool:
        return any(key in record.keys for record in JOINT.variants.values())


JOINT: Variants[Joint] = Variants("type", JOINT_TYPE, _JointRecords())

MARKER: Record[Marker] = Record(
    "a marker",
    {"body": NameReference("body", "bodies"), "location": BODY_POINT},
    lambda name, body, location: (
        Marker(name, body, location) if isinstance(location, tuple) else Marker(name, body, location[body], local=True)
    ),
    required=("body", "location"),
    checks=(Rule(("body", "location"), of_these_bodies("location")),),
    named=True,
)


def _couplings_fit(joints: Mapping[str, Joint]) -> Iterable[Complaint]:
    complaints: Iterable[Complaint] = ()
    if any(joint.couples is not None for joint in joints.values()):
        complaints = load("mbproj.scene.blocks.couplings:couple_coordinates")(joints)
    return complaints


def _ropes_fit(joints: Mapping[str, Joint], *others: Any) -> Iterable[Complaint]:
    complaints: Iterable[Complaint] = ()
    if any("path" in joint.parameters for joint in joints.values()):
        complaints = load("mbproj.scene.blocks.ropes:run_over_places")(joints, *others)
    return complaints


#: `parameters` comes first: reading it defines the names that later numbers may use.
SCENE: Record[dict[str, Any]] = Record(
    "a scene",
    {
        "parameters": Parameters(),
        "mbproj": NameChoice("format version", lambda: ("1",)),
        "title": Text(),
        "gravity": vector("m/s^2"),
        "simulation": SIMULATION,
        "bodies": Named("body", BODY, needed=True, reserved=frozenset({GROUND})),
        "curves": Named("curve", Deferred("mbproj.scene.blocks.curves:CURVE")),
        "joints": Named("joint", JOINT),
        "forces": Named("force", Deferred("mbproj.scene.blocks.forces:FORCE")),
        "motions": Named("motion", Deferred("mbproj.scene.blocks.motions:MOTION")),
        "signals": Deferred("mbproj.scene.blocks.signals:SIGNALS"),
        "states": Deferred("mbproj.scene.blocks.signals:STATES"),
        "controllers": Named("controller", Deferred("mbproj.scene.blocks.signals:CONTROLLER")),
        "markers": Named("marker", MARKER),
        "expect": Named("expectation", EXPECTATION),
    },
    dict,
    required=("mbproj", "gravity", "bodies"),
    checks=(
        Rule(("joints",), _couplings_fit),
        Rule(
            ("curves", "joints"), calling("mbproj.scene.blocks.curve_rules:fit_curves"), besides=("forces", "motions")
        ),
        Rule(("joints", "bodies"), _ropes_fit, besides=("motions",)),
        Rule(("bodies", "forces"), on_bodies),
        Rule(("joints", "forces"), act_on_coordinates),
        Rule(("joints", "forces"), calling("mbproj.scene.blocks.friction:slides_in_joints")),
        Rule(("joints", "motions"), drive_coordinates),
        *CHECKS,
    ),
)
