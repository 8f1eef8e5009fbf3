"""The fields of joint limits and of the force `stop`:

limits: {angle: {range: [-30 deg, 95 deg], stiffness: 1e5 N*m/rad, restitution: 0.4}}      # of a joint
type: stop, points: {ground: [0, 0, 0], wheel: [0, 0, 0.3]}, shortest: 0.1 m, rigid: true
type: stop, plane: {body: ground, location: [0, 0, 0], normal: [0, 0, 1]}, point: {body: ball, location: [..]}, ...

The field of dry friction of a point, ball or wheel on the plane of a stop:

friction: 0.3
friction: {coefficient: 0.3, static: 0.4, stribeck_speed: 0.05 m/s}
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any, ClassVar

from mbproj.base.dataclass import dataclass
from mbproj.joints.table import COORDINATE_UNITS, JOINTS
from mbproj.scene.blocks.friction import SPEED, STATIC, not_less
from mbproj.scene.fields.fields import (
    Alternatives,
    Complaint,
    Converted,
    Field,
    Flag,
    NameChoice,
    NameReference,
    OneOf,
    Record,
    Rule,
    Schema,
    T_co,
)
from mbproj.scene.fields.placing import BODY_DIRECTION, BODY_POINT, POINTS_OF, TWO_BODIES, TWO_POINTS, two_ends
from mbproj.scene.fields.quantities import Number, of_these_bodies, position_in
from mbproj.scene.fields.reading import Reading, Unfit, label
from mbproj.scene.records import (
    GROUND,
    DistanceStop,
    Force,
    Joint,
    KeyPath,
    Limit,
    OfBody,
    PlaneFriction,
    PlaneStop,
    StopLaw,
)
from mbproj.scene.text.nodes import MappingNode, Node, ScalarNode, SequenceNode


def _friction(coefficient: float, static: float | None = None, stribeck_speed: float | None = None) -> PlaneFriction:
    return PlaneFriction(coefficient, coefficient if static is None else static, stribeck_speed)


COEFFICIENT = STATIC["coefficient"]
#: A coefficient alone, or a mapping with it.
PLANE_FRICTION: Field[PlaneFriction] = Alternatives(
    (
        Converted(COEFFICIENT, _friction),
        Record(
            "friction",
            {"coefficient": COEFFICIENT, "static": COEFFICIENT, "stribeck_speed": SPEED["m"]},
            _friction,
            ("coefficient",),
            (Rule(("coefficient",), not_less("coefficient"), ("static", "stribeck_speed", "regularised")),),
        ),
    )
)
#: The keys of a stop that exclude friction.
FRICTIONLESS = (OneOf(("stiffness", "friction"), hint="friction is that of rigid stops: rigid: true"),)


#: The texts by which YAML means no value.
OPEN = ("null", "~", "")


@dataclass(frozen=True)
class CoordinateRange(Field[tuple[float | None, float | None]]):
    """The lower and the upper bound of a coordinate in `unit`; null for no bound."""

    unit: str
    node_type: ClassVar[type] = SequenceNode

    @property
    def expects(self) -> str:
        return f"the least and the most that it may be, in {self.unit}, or null"

    def read(self, node: Node, path: KeyPath, reading: Reading) -> tuple[float | None, float | None] | None:
        if not isinstance(node, SequenceNode) or len(node.items) != 2:
            self.reject(node, path, reading)
            return None
        before = len(reading.problems)
        low, high = (self._side(item, (*path, at), reading) for at, item in enumerate(node.items))
        if len(reading.problems) > before:
            return None
        if low is None and high is None:
            reading.report(f"{label(path)} is open on both sides", node.place, "give a number on one of them")
            return None
        if low is not None and high is not None and not low < high:
            said = f"{label(path)} has nothing in it: it goes from {low:.6g} to {high:.6g} {self.unit}"
            reading.report(said, node.place, "the least comes first; to hold a coordinate still, use another joint")
            return None
        return low, high

    def _side(self, node: Node, path: KeyPath, reading: Reading) -> float | None:
        is_open = isinstance(node, ScalarNode) and node.text in OPEN
        side: float | None = None if is_open else reading.read(_position(self.unit), node, path)
        return side

    def schema(self) -> Schema:
        side = {"anyOf": [_position(self.unit).schema(), {"enum": [None, *OPEN]}]}
        return {"description": self.expects, "type": "array", "items": side, "minItems": 2, "maxItems": 2}


@cache
def _position(unit: str) -> Number:
    return position_in(unit)


@cache
def _stiffness(unit: str | None) -> Number:
    return Number(unit, above=0.0)


class StopRecord(Record[T_co]):
    """A record with the law of a stop. `keys` has the unit of `stiffness` for the exponent 1, as N/m; with an
    `exponent` e the stiffness is in N/m^e."""

    def read(self, node: Node, path: KeyPath, reading: Reading) -> T_co | None:
        written = node.values.get("exponent") if isinstance(node, MappingNode) else None
        stiffness = self.keys["stiffness"]
        if written is None or not isinstance(stiffness, Number):
            return super().read(node, path, reading)
        exponent = self.keys["exponent"].read(written, path, Reading(names=reading.names))
        unit = None if exponent is None else f"{stiffness.unit}^{exponent:.10g}"
        return Record.read(replace(self, keys={**self.keys, "stiffness": _stiffness(unit)}), node, path, reading)


def _law_keys(unit: str) -> dict[str, Field[Any]]:
    """The keys of a stop's law on a coordinate in m or rad."""
    return {
        "rigid": Flag(),
        "exponent": Number(minimum=1.0),
        "stiffness": _stiffness("N*m/rad" if unit == "rad" else "N/m"),
        "restitution": Number(minimum=0.0, maximum=1.0),
        "damping": Number(f"s/{unit}", minimum=0.0),
    }


LAW_CHOICES = (
    OneOf(("stiffness", "rigid"), needed=True, hint="a rigid stop gives way to nothing"),
    OneOf(("exponent", "rigid"), hint="the exponent is that of the stiffness"),
    OneOf(("damping", "rigid"), hint="a rigid stop takes its 'restitution'"),
    OneOf(("damping", "restitution"), hint="the one follows from the other"),
)


def _is_not_plastic(stiffness: float, restitution: float) -> Iterator[Complaint]:
    """A check that the restitution of a compliant stop is not 0, which would need infinite damping."""
    if restitution == 0.0:
        hint = "give a small one, as 0.05, or rigid: true instead of 'stiffness'"
        yield Complaint(("restitution",), "the 'restitution' of a stop with 'stiffness' must be greater than 0", hint)


LAW_CHECKS = (Rule(("stiffness", "restitution"), _is_not_plastic),)


def _law(keys: Mapping[str, Any]) -> StopLaw:
    if "stiffness" not in keys:
        if not keys["rigid"]:
            raise Unfit("is not rigid and has no 'stiffness'", "give the stiffness, or rigid: true")
        return StopLaw(restitution=keys.get("restitution", 0.0))
    restitution = keys.get("restitution")
    damping = keys.get("damping", 0.0 if restitution is None else None)
    return StopLaw(keys["stiffness"], keys.get("exponent", 1.0), restitution, damping)


def limit_field(unit: str) -> Record[Limit]:
    """The record that reads the limit of a coordinate in m or rad."""
    return StopRecord(
        "a limit",
        {"range": CoordinateRange(unit), **_law_keys(unit)},
        lambda range, **law: Limit(range[0], range[1], _law(law)),
        ("range",),
        LAW_CHECKS,
        LAW_CHOICES,
    )


def _of_body(body: str, placed: Any) -> OfBody:
    """The record of a point or direction that is given in global axes, or by body in that body's axes."""
    return OfBody(body, placed[body], local=True) if isinstance(placed, Mapping) else OfBody(body, placed)


def _point(body: str, location: Any) -> OfBody:
    return _of_body(body, location)


def _plane(body: str, location: Any, normal: Any) -> tuple[OfBody, OfBody]:
    return _of_body(body, location), _of_body(body, normal)


def _stop(name: str, type: str, plane: Any = None, **keys: Any) -> Force:
    if plane is None:
        return _between_points(name, **keys)
    if "point" not in keys:
        raise Unfit("lacks 'point'", "give the point that stays on one side of the plane")
    location, normal = plane
    point = keys.pop("point")
    if point.body == location.body:
        raise Unfit(f"has its plane and its point on body '{point.body}'", "give two different bodies")
    friction, radius, axis = keys.pop("friction", None), keys.pop("radius", 0.0), keys.pop("axis", None)
    if axis is None:
        return PlaneStop(name, location, normal, point, radius, _law(keys), friction)
    if not radius > 0.0:
        raise Unfit("has an 'axis' and no 'radius'", "a wheel has both; a ball has a 'radius' alone")
    wrong = [body for body in axis if body != point.body] if isinstance(axis, Mapping) else []
    if wrong:
        raise Unfit(f"has its axis on body '{wrong[0]}'", f"the wheel is on body '{point.body}', as 'point' says")
    return PlaneStop(name, location, normal, point, radius, _law(keys), friction, _of_body(point.body, axis))


def _between_points(
    name: str, points: Any = None, bodies: Any = None, locations: Any = None, **keys: Any
) -> DistanceStop:
    bodies, pair = two_ends(points, bodies, locations)
    low, high = keys.pop("shortest", None), keys.pop("longest", None)
    if low is None and high is None:
        raise Unfit("does nothing", "give 'shortest' or 'longest'")
    ends = [OfBody(body, at, pair.local) for body, at in zip(bodies, (pair.first, pair.second), strict=True)]
    return DistanceStop(name, ends[0], ends[1], Limit(low, high, _law(keys)))


def _between(shortest: float, longest: float) -> Iterator[Complaint]:
    """A check that the shortest distance is less than the longest."""
    if not shortest < longest:
        said = f"the distance has no room: it is at least {shortest:.6g} m and at most {longest:.6g} m"
        yield Complaint(("longest",), said, "the longest is more than the shortest; a 'distance' joint keeps one")


def _record(what: str, make: Callable[..., Any], vectors: Mapping[str, Field[Any]]) -> Record[Any]:
    """The record that reads points or directions of one body."""
    keys: dict[str, Field[Any]] = {"body": NameReference("body", "bodies", (GROUND,)), **vectors}
    checks = tuple(Rule(("body", key), of_these_bodies(key)) for key in vectors)
    return Record(what, keys, make, tuple(keys), checks)


#: The keys that exclude each other: a stop limits the distance of two points, or that of a point from a plane.
_SHAPES = (
    OneOf(("points", "bodies", "plane"), needed=True, hint="a stop is between two points, or a plane and a point"),
    OneOf(("points", "locations"), hint="'points' are in global axes, 'locations' go with 'bodies'"),
    *(
        OneOf(pair, hint="a stop is between two points, or a plane and a point")
        for pair in (
            *(("plane", key) for key in ("locations", "shortest", "longest")),
            *((shape, key) for shape in ("points", "bodies") for key in ("point", "radius", "axis", "friction")),
        )
    ),
)


def stop_record(force_type: NameChoice) -> Record[Force]:
    """The record that reads the force `stop`."""
    return StopRecord(
        "a stop",
        {
            "type": force_type,
            "points": POINTS_OF,
            "bodies": TWO_BODIES,
            "locations": TWO_POINTS,
            "shortest": Number("m", above=0.0),
            "longest": Number("m", above=0.0),
            "plane": _record("a plane", _plane, {"location": BODY_POINT, "normal": BODY_DIRECTION}),
            "point": _record("a point", _point, {"location": BODY_POINT}),
            "radius": Number("m", minimum=0.0),
            "axis": BODY_DIRECTION,
            "friction": PLANE_FRICTION,
            **_law_keys("m"),
        },
        _stop,
        ("type",),
        (
            Rule(("bodies", "locations"), of_these_bodies("locations")),
            Rule(("shortest", "longest"), _between),
            *LAW_CHECKS,
        ),
        (*_SHAPES, *LAW_CHOICES, *FRICTIONLESS),
        named=True,
    )


def stop_units(joints: Mapping[str, Joint], forces: Mapping[str, Force]) -> dict[str, str]:
    """The units of the coordinates that stops limit, by the names of the stops in results."""
    units: dict[str, str] = {}
    for joint in joints.values():
        for coordinate, limit in joint.limits.items():
            unit = COORDINATE_UNITS[JOINTS[joint.type].coordinates[coordinate][0]]
            units |= dict.fromkeys(limit.names(joint.name, coordinate), unit)
    for force in forces.values():
        if isinstance(force, DistanceStop | PlaneStop):
            units |= dict.fromkeys(force.stops, "m")
    return units
