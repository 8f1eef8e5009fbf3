"""Scene to System: names become indices, joints become lists of primitives."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.constraints import PRIMITIVES, Primitive
from mbproj.errors import InputError, Place, Problem
from mbproj.joints import COORDINATE_UNITS, JOINTS
from mbproj.joints.table import Row
from mbproj.model.compile.drives import compile_motions
from mbproj.model.compile.frames import Pose, local_frames, pose
from mbproj.model.compile.friction import compile_friction
from mbproj.model.compile.loads import compile_forces
from mbproj.model.compile.rigid_groups import RigidGroups, Seat, rigid_groups
from mbproj.model.compile.stops import compile_stops
from mbproj.model.compile.tangents import joined, tangential_friction
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.meshes import compile_meshes
from mbproj.model.primitive_set import Binding, bind
from mbproj.model.reflected import compile_reflected
from mbproj.model.system import Names, System
from mbproj.scene.fields.rotations import from_matrix
from mbproj.scene.records import GROUND, Joint, Marker, Scene

#: The points and vectors of a joint by symbol: body index, side, and the vector in that body's axes.
Symbols = Mapping[str, tuple[int, int, Array]]


def compile_system(scene: Scene) -> System:
    """The mechanism that the scene describes, as frozen arrays. Raises InputError where nothing in it can move."""
    groups = rigid_groups(scene)
    if not groups.carriers:
        raise InputError(Problem("nothing can move: every body is fixed to the ground", scene.place("bodies")))
    poses = _poses(scene)
    symbols = _symbols(groups, poses)
    reactions = [_reaction(symbols[joint.name]) for joint in groups.joints]
    rows, alignment, coordinates, coordinate_names, units = [], [], [], [], []
    for owner, joint in enumerate(groups.joints):
        kind, bound, place = JOINTS[joint.type], symbols[joint.name], scene.place("joints", joint.name)
        for number, row in enumerate(kind.rows):
            primitive = _primitive(row, joint)
            slots = tuple(_slots(row, bound))
            rows.append(Binding(primitive, owner, slots, _offset(number, joint, primitive, slots, groups, place)))
        for pair in kind.aligned:
            alignment.append(Binding(PRIMITIVES["perpendicular"](), owner, tuple(_slots(("", *pair), bound))))
        for name, row in kind.coordinates.items():
            coordinates.append(Binding(PRIMITIVES[row[0]](), owner, tuple(_slots(row, bound))))
            coordinate_names.append(f"{joint.name}.{name}")
            units.append(COORDINATE_UNITS[row[0]])
    named = dict(zip(coordinate_names, coordinates, strict=True))
    dry = compile_friction(scene, groups.joints, [_axis(symbols[joint.name]) for joint in groups.joints], named)
    forces, force_names = compile_forces(scene, groups.seats, poses, named, dry.smooth)
    motions, motion_names = compile_motions(scene, named)
    reflected = compile_reflected(scene, named)
    stops, stop_names = compile_stops(scene, groups.seats, poses, named)
    tangential, tangent_names = tangential_friction(scene, groups.seats, poses, stop_names)
    frictions = joined(dry.frictions, tangential)
    turning = [] if reflected is None else reflected.joint_coordinate.tolist()
    bodies = [groups.seats[body.name] for body in scene.bodies]
    return System(
        names=Names(
            bodies=tuple(body.name for body in scene.bodies),
            carriers=tuple(carrier.name for carrier in groups.carriers),
            joints=tuple(joint.name for joint in groups.joints),
            markers=tuple(marker.name for marker in scene.markers),
            coordinates=tuple(coordinate_names),
            coordinate_units=tuple(units),
            forces=(*force_names, *(f"{coordinate_names[at]}.inertia" for at in turning)),
            force_units=(*(() if forces is None else forces.units), *(units[at] for at in turning)),
            motions=motion_names,
            motion_units=() if motions is None else motions.rows.units,
            stops=stop_names,
            stop_units=() if stops is None else stops.coordinates.units,
            frictions=(*dry.names, *tangent_names),
            friction_units=() if frictions is None else frictions.coordinates.units,
        ),
        mass=np.array([carrier.mass for carrier in groups.carriers]),
        inertia=np.array([carrier.inertia for carrier in groups.carriers]),
        gravity=np.array(scene.gravity),
        joints=bind(rows),
        coordinates=bind(coordinates),
        meshes=compile_meshes(rows, coordinates),
        alignment=bind(alignment),
        body_carrier=np.array([seat.carrier for seat in bodies], dtype=np.intp),
        body_offset=np.array([seat.offset for seat in bodies]),
        body_turn=np.array([from_matrix(seat.turn.tolist()) for seat in bodies]),
        marker_body=np.array([groups.seats[marker.body].carrier for marker in scene.markers], dtype=np.intp),
        marker_local=np.array([_marker_local(marker, poses, groups) for marker in scene.markers]).reshape(-1, 3),
        reaction_body=np.array([body for body, _, _ in reactions], dtype=np.intp),
        reaction_local=np.array([local for _, _, local in reactions]).reshape(-1, 3),
        length=_length(groups, symbols.values()),
        body_places=tuple(scene.place("bodies", carrier.name) for carrier in groups.carriers),
        joint_places=tuple(scene.place("joints", joint.name) for joint in groups.joints),
        forces=forces,
        motions=motions,
        reflected=reflected,
        stops=stops,
        frictions=frictions,
        bearings=dry.bearings,
    )


def _symbols(groups: RigidGroups, poses: Mapping[str, Pose]) -> dict[str, Symbols]:
    """What each joint binds, in the axes of the carriers; a coupling binds what the joints a and b do."""
    found: dict[str, Symbols] = {}
    for joint in groups.joints:
        if joint.couples is None:
            frame = local_frames(joint, JOINTS[joint.type].frame, poses)
            seats = [groups.seats[name] for name in joint.bodies]
            found[joint.name] = {symbol: _seated(symbol, local, seats) for symbol, local in frame.items()}
    for joint in groups.joints:
        if joint.couples is not None:
            pairs = zip("ab", joint.couples, strict=True)
            found[joint.name] = {
                f"{letter}.{symbol}": (body, side if letter == "b" else 1, local)
                for letter, name in pairs
                for symbol, (body, side, local) in found[name].items()
            }
    return found


def _seated(symbol: str, local: Array, seats: Sequence[Seat]) -> tuple[int, int, Array]:
    side = int(symbol[-1])
    seat = seats[side - 1]
    return seat.carrier, side, seat.point(local) if symbol.startswith("p") else seat.vector(local)


def _poses(scene: Scene) -> dict[str, Pose]:
    poses = {body.name: pose(body.position, body.orientation) for body in scene.bodies}
    return poses | {GROUND: (np.zeros(3), np.eye(3))}


def _slots(row: Row, bound: Symbols) -> Iterable[tuple[int, int, Array]]:
    for symbol in row[1:]:
        body, side, local = bound[symbol.lstrip("-")]
        yield body, side, -local if symbol.startswith("-") else local


def _primitive(row: Row, joint: Joint) -> Primitive:
    """The row's primitive, with the joint's parameters that it takes."""
    primitive = PRIMITIVES[row[0]]
    return primitive(**{name: joint.parameters[name] for name in primitive.parameters})


def _offset(
    number: int,
    joint: Joint,
    primitive: Primitive,
    slots: Sequence[tuple[int, int, Array]],
    groups: RigidGroups,
    place: Place | None,
) -> float:
    """What row `number` of the joint counts from: 0, or what it keeps."""
    kept = JOINTS[joint.type].kept
    if number not in kept:
        return 0.0
    name = kept[number]
    if name is not None and name in joint.parameters:
        return float(joint.parameters[name])
    points = [
        _global(body, local, kind == "point", groups)
        for (body, _, local), kind in zip(slots, primitive.slots, strict=True)
    ]
    value = float(primitive.value(np.array([points]))[0, 0])
    if name is not None and value == 0.0:
        what = f"joint '{joint.name}' keeps a distance, and its two points are one at the scene's pose"
        raise InputError(Problem(what, place, f"give its '{name}', or other points"))
    return value


def _global(body: int, local: Array, is_point: bool, groups: RigidGroups) -> Array:
    """A point or vector of a carrier as it is at the scene's pose."""
    if body == len(groups.carriers):
        return local
    carrier = groups.carriers[body]
    turned: Array = rotation_matrix(carrier.orientation) @ local
    return carrier.position + turned if is_point else turned


def _reaction(bound: Symbols) -> tuple[int, int, Array]:
    """Body 2 of a joint and its point there."""
    return bound["p2"] if "p2" in bound else bound["b.p2"]


def _axis(bound: Symbols) -> Array:
    """A joint's axis z in the axes of its body 2."""
    return (bound["z2"] if "z2" in bound else bound["b.z2"])[2]


def _marker_local(marker: Marker, poses: Mapping[str, Pose], groups: RigidGroups) -> Array:
    location = np.array(marker.location)
    position, rotation = poses[marker.body]
    return groups.seats[marker.body].point(location if marker.local else rotation.T @ (location - position))


def _length(groups: RigidGroups, symbols: Iterable[Symbols]) -> float:
    """The largest distance of a joint's point from its body's centre of mass; without joints the largest radius of
    gyration; 1 m where there is neither."""
    ground = len(groups.carriers)
    arms = [
        float(np.linalg.norm(local))
        for bound in symbols
        for symbol, (body, _, local) in bound.items()
        if symbol.startswith("p") and body != ground
    ]
    gyration = [
        float(np.sqrt(np.trace(carrier.inertia) / carrier.mass)) for carrier in groups.carriers if carrier.mass > 0.0
    ]
    return max(arms, default=0.0) or max(gyration, default=0.0) or 1.0
