"""The rows and coordinates of joints, from the joint table and the joints' points and vectors."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from mbproj.base.arrays import Array, numbers
from mbproj.base.errors import InputError, Place, Problem, placed_at
from mbproj.joints.primitives.basic import Primitive
from mbproj.joints.primitives.table import PRIMITIVES
from mbproj.joints.table import JOINTS, Row
from mbproj.model.compile.frames import RigidGroups
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.primitive_set import Binding
from mbproj.scene.blocks.coordinates import SLIP
from mbproj.scene.records import Joint

if TYPE_CHECKING:
    from mbproj.scene.records import Coupled

#: The points and vectors of a joint by symbol: body index, side, and the vector in that body's axes.
Symbols = Mapping[str, tuple[int, int, Array]]
_DISTANCE = PRIMITIVES["distance"]()


def coordinates_of(owner: int, joint: Joint, symbols: Symbols) -> dict[str, Binding]:
    """The coordinates of a joint by name."""
    rows = JOINTS[joint.type].coordinates
    return {name: Binding(primitive_of(row, joint), owner, tuple(slots_of(row, symbols))) for name, row in rows.items()}


def slips_of(joints: Sequence[Joint], symbols: Mapping[str, Symbols]) -> dict[str, Binding]:
    """The slip that dry friction resists in each joint without a coordinate for it, by "joint.slip"."""
    return {
        f"{joint.name}.{SLIP}": Binding(primitive_of(row, joint), at, tuple(slots_of(row, symbols[joint.name])))
        for at, joint in enumerate(joints)
        if (row := JOINTS[joint.type].slip)
    }


def slots_of(row: Row, bound: Symbols) -> Iterable[tuple[int, int, Array]]:
    for symbol in row[1:]:
        body, side, local = bound[symbol.lstrip("-")]
        yield body, side, -local if symbol.startswith("-") else local


def rows_of(
    owner: int,
    joint: Joint,
    symbols: Symbols,
    coordinates: Mapping[str, Binding],
    groups: RigidGroups,
    place: Place | None,
) -> Iterator[Binding]:
    """The rows of a joint; `coordinates` are those of all joints, by names such as "hinge.angle"."""
    if joint.couples is not None:
        from mbproj.model.compile.couplings import row_binding

        parts = [coordinates[name] for name in joint.couples.of]
        with placed_at(place):
            yield row_binding(
                f"'{joint.name}'", joint.couples, _coupling_constant(joint.couples, parts, groups), parts, owner
            )
        return
    for number, row in enumerate(JOINTS[joint.type].rows):
        primitive, slots = primitive_of(row, joint), tuple(slots_of(row, symbols))
        yield Binding(primitive, owner, slots, _offset(number, joint, primitive, slots, groups, place))


def primitive_of(row: Row, joint: Joint) -> Primitive:
    """Return the primitive of a row, with the values it takes from the joint's parameters."""
    kind = PRIMITIVES[row[0]]
    following = _following(kind, joint) if kind.follows else None
    if following is not None:
        return following
    parameters = numbers_of(joint.parameters)
    return kind(**{name: parameters[name] for name in kind.parameters})


def _following(kind: Any, joint: Joint) -> Primitive | None:
    """Return the primitive of a row that follows curves or couples coordinates; None for rows with numbers alone."""
    from mbproj.model.compile import couplings

    primitive: Primitive | None = None
    if kind.follows == "curve":
        primitive = couplings.on_curve(kind, joint)
    elif kind.follows == "space curve":
        primitive = kind(joint.parameters["curve"].line)
    elif kind.follows == "two curves":
        primitive = couplings.two_curves(kind, joint)
    elif "curve" in joint.parameters:
        primitive = couplings.rolling(joint)
    elif (coupling := JOINTS[joint.type].coupling) is not None:
        weights, period, _ = coupling(**joint.parameters)
        primitive = kind(JOINTS[joint.type].couples, weights, period or 0.0)
    return primitive


def numbers_of(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return a joint's parameters by the names that primitives use: a tuple `name` becomes name_1, name_2 and so on."""
    several = {name: value for name, value in parameters.items() if isinstance(value, tuple)}
    numbered = {f"{name}_{at}": each for name, value in several.items() for at, each in enumerate(value, 1)}
    return {**parameters, **numbered}


def _offset(
    number: int,
    joint: Joint,
    primitive: Primitive,
    slots: Sequence[tuple[int, int, Array]],
    groups: RigidGroups,
    place: Place | None,
) -> float:
    """Return the offset of row `number` of a joint: 0, or the value that the row keeps."""
    parameter_of = JOINTS[joint.type].constant_rows
    if number not in parameter_of:
        return 0.0
    name = parameter_of[number]
    if name is not None and name in joint.parameters:
        value: float = joint.parameters[name]
        return value
    value = _value(primitive, slots, groups)
    if name is not None and value == 0.0:
        what = f"joint '{joint.name}' keeps a distance, and its two points coincide at the scene's pose"
        raise InputError(Problem(what, place, f"give its '{name}', or other points"))
    return value


def _coupling_constant(coupled: Coupled, parts: Sequence[Binding], groups: RigidGroups) -> float:
    """Return the constant of a coupling. Where none is given, weighted lengths keep the sum they have at the scene's
    pose."""
    if coupled.constant is not None:
        return coupled.constant
    weighted = zip(coupled.of.values(), parts, strict=True)
    return (
        0.0 if coupled.function is not None else sum(weight * at_scenes_pose(part, groups) for weight, part in weighted)
    )


def at_scenes_pose(coordinate: Binding, groups: RigidGroups) -> float:
    """Return a coordinate at the scene's pose, in m or rad: all but lengths are zero there."""
    is_length = coordinate.primitive == _DISTANCE or coordinate.primitive.follows == "rope"
    return _value(coordinate.primitive, coordinate.slots, groups) if is_length else 0.0


def _value(primitive: Primitive, slots: Sequence[tuple[int, int, Array]], groups: RigidGroups) -> float:
    """Return the value of the first row of a primitive at the scene's pose."""
    points = [
        _global(body, local, kind == "point", groups)
        for (body, _, local), kind in zip(slots, primitive.slots, strict=True)
    ]
    value: float = primitive.value(numbers([points]))[0, 0].item()
    return value


def _global(body: int, local: Array, is_point: bool, groups: RigidGroups) -> Array:
    """Return a point or vector of a carrier in global axes at the scene's pose."""
    if body == len(groups.carriers):
        return local
    carrier = groups.carriers[body]
    turned: Array = rotation_matrix(carrier.orientation) @ local
    return carrier.position + turned if is_point else turned
