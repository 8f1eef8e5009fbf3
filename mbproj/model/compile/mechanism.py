"""Compiles a scene to a System: names become indices, joints become lists of primitives."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mbproj.base.arrays import Array, numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.registry import load
from mbproj.joints.primitives.table import PRIMITIVES
from mbproj.joints.table import JOINTS
from mbproj.model.compile.frames import SYMBOLS, Pose, RigidGroups, local_frames, poses_of, rigid_groups
from mbproj.model.compile.joints import Symbols, at_scenes_pose, coordinates_of, rows_of, slips_of, slots_of
from mbproj.model.couplings import compile_couplings
from mbproj.model.euler_parameters import matrix_L, product, rotation_matrix
from mbproj.model.forces import NO_FORCES, Forces
from mbproj.model.primitive_set import Binding, bind
from mbproj.model.system import Conditions, Names, System
from mbproj.scene.fields.rotations import from_matrix
from mbproj.scene.records import Joint, Marker
from mbproj.scene.scene import Scene

if TYPE_CHECKING:
    from mbproj.functions.elements import Element
    from mbproj.model.compile.ropes import Wound
    from mbproj.model.contacts import Bearings, Frictions, Stops


_PERPENDICULAR = PRIMITIVES["perpendicular"]()


def with_elements_of(scene: Scene, system: System, derived: list[Element]) -> System:
    """Return the system with the scene's elements, and with those that come from its joints and motions. Raises
    InputError where an element names something that does not exist."""
    if scene.forces:
        derived += load("mbproj.model.compile.forces:elements_of")(scene, poses_of(scene))
    if scene.states:
        derived.append(load("mbproj.model.compile.elements:states_of")(scene.states))
    if scene.controllers:
        derived += load("mbproj.model.compile.elements:held_by_controllers")(scene.controllers)
    elements, reads = (*derived, *scene.elements), any(system.forces.programs.reads)
    rubs = system.frictions is not None and system.frictions.varies
    if elements or scene.signals or reads or rubs:
        with_elements = load("mbproj.model.compile.elements:with_elements")
        system = with_elements(system, elements, scene.signals, scene.controllers)
    return system


def without_elements(scene: Scene) -> tuple[System, list[Element]]:
    """Return the mechanism of the scene as frozen arrays, without elements, and the elements that come from its joints
    and motions. Raises InputError where nothing can move."""
    groups = rigid_groups(scene)
    if not groups.carriers:
        raise InputError(Problem("nothing can move: every body is fixed to the ground", scene.place("bodies")))
    poses = poses_of(scene)
    symbols = _symbols(groups, poses)
    reactions = [_reaction(symbols[joint.name]) for joint in groups.joints]
    alignment: list[Binding] = []
    coordinates: list[Binding] = []
    coordinate_names: list[str] = []
    units: list[str] = []
    ropes: dict[str, Wound] = {}
    for owner, joint in enumerate(groups.joints):
        kind = JOINTS[joint.type]
        for pair in kind.aligned:
            alignment.append(Binding(_PERPENDICULAR, owner, tuple(slots_of(("", *pair), symbols[joint.name]))))
        if kind.frame == "path":
            place = scene.place("joints", joint.name)
            wound = load("mbproj.model.compile.ropes:wound")
            rope = ropes.setdefault(joint.name, wound(joint, owner, groups.seats, poses, place))
            joint_coordinates = rope.coordinates
        else:
            joint_coordinates = coordinates_of(owner, joint, symbols[joint.name])
        coordinates += joint_coordinates.values()
        coordinate_names += [f"{joint.name}.{name}" for name in joint_coordinates]
        units += [each.primitive.unit for each in joint_coordinates.values()]
    by_name = dict(zip(coordinate_names, coordinates, strict=True))
    rows = [
        row
        for owner, joint in enumerate(groups.joints)
        for row in (
            ropes[joint.name].rows
            if joint.name in ropes
            else rows_of(owner, joint, symbols[joint.name], by_name, groups, scene.place("joints", joint.name))
        )
    ]
    acting = _acting(scene, groups, poses, symbols, by_name)
    forces, stops, frictions = acting.forces, acting.stops, acting.frictions
    teeth, touching, touching_names = (), None, ()
    if any(joint.couples or "curve" in joint.parameters or "curves" in joint.parameters for joint in groups.joints):
        teeth = load("mbproj.model.compile.couplings:toothed")(scene, groups.joints, coordinate_names)
        touching, touching_names = load("mbproj.model.compile.couplings:touching_of")(groups.joints, coordinate_names)
    bodies = [groups.seats[body.name] for body in scene.bodies]
    system = System(
        names=Names(
            bodies=tuple(body.name for body in scene.bodies),
            carriers=tuple(carrier.name for carrier in groups.carriers),
            joints=tuple(joint.name for joint in groups.joints),
            markers=tuple(marker.name for marker in scene.markers),
            coordinates=tuple(coordinate_names),
            coordinate_units=tuple(units),
            forces=acting.force_names,
            force_units=forces.units,
            applied=tuple(forces.program_owners[components[0]] for components in forces.on_bodies.program),
            applied_units=tuple("rad" if turns else "m" for turns in forces.on_bodies.is_torque),
            stops=acting.stop_names,
            stop_units=() if stops is None else stops.coordinates.units,
            frictions=acting.friction_names,
            tensions=tuple(_tensions(scene, groups.joints, ropes)),
            touching=touching_names,
            friction_units=() if frictions is None else frictions.coordinates.units,
        ),
        mass=numbers([carrier.mass for carrier in groups.carriers]),
        inertia=numbers([carrier.inertia for carrier in groups.carriers]),
        gravity=numbers(scene.gravity),
        joints=bind(rows),
        coordinates=bind(coordinates),
        couplings=replace(compile_couplings(rows, coordinates), teeth=teeth),
        alignment=bind(alignment),
        body_carrier=np.array([seat.carrier for seat in bodies], dtype=np.intp),
        body_offset=numbers([seat.offset for seat in bodies]),
        body_turn=numbers([from_matrix(seat.turn.tolist()) for seat in bodies]),
        marker_body=np.array([groups.seats[marker.body].carrier for marker in scene.markers], dtype=np.intp),
        marker_local=numbers([_marker_local(marker, poses, groups) for marker in scene.markers]).reshape(-1, 3),
        reaction_body=np.array([body for body, _, _ in reactions], dtype=np.intp),
        reaction_local=numbers([local for _, _, local in reactions]).reshape(-1, 3),
        length=_length(groups, symbols.values()),
        drawn=_drawn(groups),
        body_places=tuple(scene.place("bodies", carrier.name) for carrier in groups.carriers),
        joint_places=tuple(scene.place("joints", joint.name) for joint in groups.joints),
        forces=forces,
        stops=stops,
        frictions=frictions,
        bearings=acting.bearings,
        touching=touching,
    )
    return system, _of_joints(scene, by_name, groups)


class _Acting(NamedTuple):
    """Forces, stops and dry frictions, with their names in results."""

    forces: Forces = NO_FORCES
    force_names: tuple[str, ...] = ()
    stops: Stops | None = None
    stop_names: tuple[str, ...] = ()
    frictions: Frictions | None = None
    friction_names: tuple[str, ...] = ()
    bearings: Bearings | None = None


def _acting(
    scene: Scene,
    groups: RigidGroups,
    poses: Mapping[str, Pose],
    symbols: Mapping[str, Symbols],
    coordinates: Mapping[str, Binding],
) -> _Acting:
    """Return the forces, stops and dry frictions; `coordinates` are those of joints by names such as "hinge.angle"."""
    if not (scene.forces or any(joint.limits or "path" in joint.parameters for joint in groups.joints)):
        return _Acting()
    from mbproj.model.compile.contacts import all_frictions, compile_friction, compile_stops, tangential_friction
    from mbproj.model.compile.forces import compile_forces

    slips = slips_of(groups.joints, symbols)
    axes = [_axis(symbols[joint.name]) for joint in groups.joints]
    dry = compile_friction(scene, groups.joints, axes, coordinates, slips)
    forces, force_names = compile_forces(scene, groups.seats, poses, coordinates, dry.smooth, slips)
    stops, stop_names = compile_stops(scene, groups.seats, poses, coordinates)
    tangential, tangent_names = tangential_friction(scene, groups.seats, poses, stop_names)
    frictions = all_frictions(dry.frictions, tangential)
    return _Acting(forces, force_names, stops, stop_names, frictions, (*dry.names, *tangent_names), dry.bearings)


def _tensions(scene: Scene, joints: Sequence[Joint], ropes: Mapping[str, Wound]) -> Iterator[str]:
    """The name of the tension of each portion of a rope whose length is held or limited."""
    driven = {motion.joint for motion in scene.motions}
    for joint in joints:
        if joint.name in ropes:
            path = joint.parameters["path"]
            count = path.portions if path.taut or joint.name in driven else 1 if joint.limits else 0
            yield from (f"{joint.name}.tension_{number}" for number in range(1, count + 1))


def _of_joints(scene: Scene, coordinates: Mapping[str, Binding], groups: RigidGroups) -> list[Element]:
    """Return the motions and reflected inertias of a scene as an element. A motion is a row of a coordinate and the
    time; `coordinates` are those of joints by names such as "hinge.angle"."""
    if not (scene.motions or any(joint.reflected_inertia for joint in scene.joints)):
        return []
    from mbproj.functions.elements import Element, Row

    starts = {f"{joint.name}.{name}": start for joint in scene.joints for name, start in joint.start.items()}
    rows, inertias = list[Row](), dict[str, float]()
    for motion in scene.motions:
        name, place = f"{motion.joint}.{motion.coordinate}", scene.place("motions", motion.name, motion.coordinate)
        start = starts.get(name, at_scenes_pose(coordinates[name], groups)) if motion.from_start else 0.0
        rows.append(Row(motion.name, {name: 1.0}, motion.function, constant=start, place=place))
    for joint in scene.joints:
        inertias |= {f"{joint.name}.{name}": inertia for name, inertia in joint.reflected_inertia.items()}
    return [Element("", rows=tuple(rows), inertias=inertias)]


def _symbols(groups: RigidGroups, poses: Mapping[str, Pose]) -> dict[str, Symbols]:
    """Return the points and vectors of each joint in the axes of the carriers. A coupling has the symbols of its last
    joint, where its reaction acts."""
    uncoupled = [joint for joint in groups.joints if joint.couples is None]
    symbols: dict[str, Symbols] = {}
    for joint, frame in zip(uncoupled, _seated(uncoupled, local_frames(uncoupled, poses), groups), strict=True):
        carriers = [groups.seats[name].carrier for name in joint.bodies]
        symbols[joint.name] = {symbol: (carriers[at // 4], 1 + at // 4, frame[at]) for at, symbol in enumerate(SYMBOLS)}
    for joint in groups.joints:
        if joint.couples is not None:
            symbols[joint.name] = symbols[joint.couples.joints[-1]]
    return symbols


def _seated(joints: Sequence[Joint], frames: Array, groups: RigidGroups) -> Array:
    """Return the frames (joints, 8, 3) of joints in the axes of the carriers, from those in the axes of the bodies."""
    number = {name: at for at, name in enumerate(groups.seats)}
    bodies = np.array([[number[name] for name in joint.bodies] for joint in joints], dtype=np.intp).reshape(-1, 2)
    turn = numbers([seat.turn for seat in groups.seats.values()])[bodies]
    seated = frames.reshape(-1, 2, 4, 3) @ np.swapaxes(turn, -1, -2)
    seated[:, :, 0] += numbers([seat.offset for seat in groups.seats.values()])[bodies]
    joint_frames: Array = seated.reshape(frames.shape)
    return joint_frames


def _reaction(bound: Symbols) -> tuple[int, int, Array]:
    """Return body 2 of a joint, its side, and the joint's point on it."""
    return bound["p2"]


def _axis(bound: Symbols) -> Array:
    """A joint's axis z in the axes of its body 2."""
    return bound["z2"][2]


def _marker_local(marker: Marker, poses: Mapping[str, Pose], groups: RigidGroups) -> Array:
    location = numbers(marker.location)
    position, rotation = poses[marker.body]
    return groups.seats[marker.body].point(location if marker.local else rotation.T @ (location - position))


def _drawn(groups: RigidGroups) -> Array:
    """Return the coordinates (7n,) at which the scene draws the carriers."""
    position = numbers([carrier.position for carrier in groups.carriers])
    orientation = numbers([carrier.orientation for carrier in groups.carriers])
    return np.hstack([position, orientation]).ravel()


def _length(groups: RigidGroups, symbols: Iterable[Symbols]) -> float:
    """Return the length of the mechanism: the largest distance of a joint's point from its body's centre of mass.
    Without joints it is the largest radius of gyration, and else 1 m."""
    ground = len(groups.carriers)
    ends = [bound[point] for bound in symbols for point in ("p1", "p2") if point in bound]
    arm: float = np.sqrt(numbers([local @ local for body, _, local in ends if body != ground]).max(initial=0.0)).item()
    if arm:
        return arm
    squares = [np.trace(carrier.inertia) for carrier in groups.carriers if carrier.mass > 0.0]
    masses = [carrier.mass for carrier in groups.carriers if carrier.mass > 0.0]
    gyration: float = (np.sqrt(numbers(squares)) / np.sqrt(numbers(masses))).max(initial=0.0).item()
    return gyration or 1.0


# --- The start that a scene asks for ----------------------------------------------------------------------------------
# A guess of poses and velocities, and conditions on joint coordinates.


@dataclass(frozen=True, eq=False)
class Guess:
    """Coordinates q (7n,) and velocities v = q' (7n,) to start assembly from, and conditions on joint coordinates."""

    q: Array
    v: Array
    start: Conditions
    speed: Conditions


def initial_guess(scene: Scene, system: System) -> Guess:
    """Return the guess from the poses and velocities of the scene's bodies, and the conditions of its joints.

    Λ' = ½ Lᵀ ω (Eq. 16). A body with a pose at the start carries the other bodies of its rigid group along."""
    carriers = rigid_groups(scene).carriers
    position = numbers([carrier.position for carrier in carriers])
    orientation = numbers([carrier.orientation for carrier in carriers])
    velocity = numbers([carrier.velocity for carrier in carriers])
    for body, (carrier, offset, turn) in zip(
        scene.bodies, zip(system.body_carrier, system.body_offset, system.body_turn, strict=True), strict=True
    ):
        if body.start is not None and carrier < system.bodies:
            orientation[carrier] = product(numbers(body.start[1]), turn * [1.0, -1.0, -1.0, -1.0])
            position[carrier] = body.start[0] - rotation_matrix(orientation[carrier]) @ offset
    omega = numbers([carrier.angular_velocity for carrier in carriers])
    rate = 0.5 * np.einsum("nij,ni->nj", matrix_L(orientation), omega)
    return Guess(
        q=np.hstack([position, orientation]).ravel(),
        v=np.hstack([velocity, rate]).ravel(),
        start=_conditions(scene, system, "start"),
        speed=_conditions(scene, system, "speed"),
    )


def _conditions(scene: Scene, system: System, kind: str) -> Conditions:
    wanted = {
        f"{joint.name}.{coordinate}": value
        for joint in scene.joints
        for coordinate, value in getattr(joint, kind).items()
    }
    index = [index for index, name in enumerate(system.names.coordinates) if name in wanted]
    value = [wanted[system.names.coordinates[i]] for i in index]
    return Conditions(np.array(index, dtype=np.intp), numbers(value))
