"""The scene's forces as arrays."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from mbproj.base.arrays import Array, numbers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.base.thresholds import THRESHOLDS
from mbproj.functions.elements import Element, End, Place
from mbproj.functions.program import Program
from mbproj.functions.program_set import flatten
from mbproj.joints.primitives.table import PRIMITIVES
from mbproj.model.compile.contacts import SmoothFriction
from mbproj.model.compile.frames import Pose, Seat
from mbproj.model.forces import COORDINATES, BodyForces, Bushings, Forces, Laws
from mbproj.model.primitive_set import Binding, bind
from mbproj.scene.blocks.elements import SPRINGS, element_type
from mbproj.scene.fields.rotations import from_matrix, to_matrix
from mbproj.scene.records import GROUND, BodyForce, Bushing, JointForce, Law, Matrix, PointForce
from mbproj.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class _LawEntry:
    """A law with its name and coordinate: `force` is its force, `shown` its name in results, `along` its primitive.

    `coordinate` is the number of the joint coordinate, -1 for none; a regularised dry `friction` replaces its
    program."""

    law: Law
    force: str
    shown: str
    along: Binding
    coordinate: int = -1
    friction: SmoothFriction | None = None

    @property
    def program(self) -> Program | None:
        """The part of the force beside those of a spring and a damper."""
        return self.law.function if self.friction is None else self.friction.program


class _Programs:
    """Programs collected so far, with the names of their forces."""

    def __init__(self) -> None:
        self.programs: list[Program] = []
        self.owners: list[str] = []

    def number(self, program: Program | None, owner: str) -> int:
        """Append a program and return its number; return -1 for None."""
        if program is None:
            return -1
        self.programs.append(program)
        self.owners.append(owner)
        return len(self.programs) - 1


def compile_forces(
    scene: Scene,
    seats: Mapping[str, Seat],
    poses: Mapping[str, Pose],
    coordinates: Mapping[str, Binding],
    smooth: Mapping[tuple[str, str], SmoothFriction],
    slips: Mapping[str, Binding],
) -> tuple[Forces, tuple[str, ...]]:
    """Return the forces other than stops and sticking friction, and their names in results.

    The name is the force's, followed by the coordinate where the force acts on several. `coordinates` are those of
    joints by names such as "hinge.angle", `smooth` the regularised frictions by force and coordinate. `slips` are those
    that frictions resist in joints without a coordinate for them. Raises InputError."""
    entries: list[_LawEntry] = []
    for force in scene.forces:
        if isinstance(force, PointForce | JointForce) and force.element:
            continue
        if isinstance(force, PointForce):
            entries.append(_between_points(scene, force, seats, poses))
        elif isinstance(force, JointForce):
            entries += _on_joint(force, coordinates, smooth, slips)
    body_forces = [force for force in scene.forces if isinstance(force, BodyForce)]
    elastic = [force for force in scene.forces if isinstance(force, Bushing)]
    met = _Programs()
    laws = _laws(entries, met)
    on_bodies = _on_bodies(body_forces, seats, poses, met)
    forces = Forces(
        laws,
        compile_bushings(scene, elastic, seats, poses),
        on_bodies,
        flatten(met.programs),
        law_owners=tuple(entry.force for entry in entries),
        program_owners=tuple(met.owners),
        bushing_names=tuple(force.name for force in elastic),
    )
    of_bushings = (f"{force.name}.{coordinate}" for force in elastic for coordinate in COORDINATES)
    return forces, (*(entry.shown for entry in entries), *of_bushings)


def _laws(entries: Sequence[_LawEntry], met: _Programs) -> Laws:
    laws = [entry.law for entry in entries]
    return Laws(
        coordinates=bind([Binding(entry.along.primitive, at, entry.along.slots) for at, entry in enumerate(entries)]),
        joint_coordinate=np.array([entry.coordinate for entry in entries], dtype=np.intp),
        stiffness=numbers([law.stiffness for law in laws]),
        damping=numbers([law.damping for law in laws]),
        free=numbers([law.free or 0.0 for law in laws]),
        program=np.array([met.number(entry.program, entry.force) for entry in entries], dtype=np.intp),
        loses=np.array([entry.friction is not None for entry in entries], dtype=bool),
        bearing=np.array([-1 if each.friction is None else each.friction.bearing for each in entries], dtype=np.intp),
        apart=np.zeros(len(laws), dtype=bool),
        partner=np.full(len(laws), -1, dtype=np.intp),
        sliding=np.zeros((len(laws), 2)),
    )


def _on_bodies(
    forces: Sequence[BodyForce], seats: Mapping[str, Seat], poses: Mapping[str, Pose], met: _Programs
) -> BodyForces:
    turns = [seats[force.body].turn if force.body_axes else np.eye(3) for force in forces]
    programs = [[met.number(component, force.name) for component in force.components] for force in forces]
    return BodyForces(
        body=np.array([seats[force.body].carrier for force in forces], dtype=np.intp),
        point=numbers([_point(force, seats, poses) for force in forces]).reshape(-1, 3),
        is_torque=np.array([force.torque for force in forces], dtype=bool),
        in_body=np.array([force.body_axes for force in forces], dtype=bool),
        turn=numbers(turns).reshape(-1, 3, 3),
        program=np.array(programs, dtype=np.intp).reshape(-1, 3),
    )


def _between_points(scene: Scene, force: PointForce, seats: Mapping[str, Seat], poses: Mapping[str, Pose]) -> _LawEntry:
    """Return a law on the distance of two points. The default free length is the distance at the scene's pose."""
    slots, ends = [], []
    for side, (name, local) in enumerate(zip(force.bodies, local_ends(force, poses), strict=True), 1):
        position, rotation = poses[name]
        ends.append(position + rotation @ local)
        slots.append((seats[name].carrier, side, seats[name].point(local)))
    length, place = np.linalg.norm(ends[1] - ends[0]).item(), scene.place("forces", force.name)
    if slots[0][0] == slots[1][0]:
        what = f"force '{force.name}' acts between two points of one rigid body"
        raise InputError(Problem(what, place, "fixed joints have merged its bodies"))
    if length <= THRESHOLDS.no_digits * (1.0 + np.abs(np.stack(ends)).max()):
        what = f"force '{force.name}' has no direction: its two points coincide at the scene's pose"
        raise InputError(Problem(what, place, "move one of its points"))
    law = force.law
    free = length if law.free is None else law.free
    bound = Binding(PRIMITIVES["distance"](), 0, tuple(slots))
    return _LawEntry(replace(law, free=free), force.name, force.name, bound)


def local_ends(force: PointForce, poses: Mapping[str, Pose]) -> list[Array]:
    """Return the two points of a force, each (3,) in the axes of its body."""
    ends = []
    for name, point in zip(force.bodies, (force.points.first, force.points.second), strict=True):
        position, rotation = poses[name]
        ends.append(numbers(point) if force.points.local else rotation.T @ (numbers(point) - position))
    return ends


def _distance(force: PointForce, poses: Mapping[str, Pose]) -> float:
    """Return the distance of the two points of a force at the scene's pose, in m."""
    first, second = (
        position + rotation @ local
        for (position, rotation), local in zip(
            (poses[name] for name in force.bodies), local_ends(force, poses), strict=True
        )
    )
    return float(np.linalg.norm(second - first))


def elements_of(scene: Scene, poses: Mapping[str, Pose]) -> list[Element]:
    """Return the forces that are elements, each with the coordinate that it acts along."""
    elements = []
    for force in scene.forces:
        if not isinstance(force, PointForce | JointForce) or force.element is None:
            continue
        lengths, make, values = {}, element_type(force.element.type).make, dict(force.element.values)
        if isinstance(force, PointForce):
            ends = zip(force.bodies, local_ends(force, poses), strict=True)
            first, second = (_end(body, point) for body, point in ends)
            lengths, along = {"length": (first, second)}, f"{force.name}.length"
            if force.element.type in SPRINGS and "free_length" not in values:
                values["free_length"] = _distance(force, poses)
        else:
            (coordinate,) = force.laws
            along = f"{force.joint}.{coordinate}"
        element = make(force.name, along, **values)
        forces = tuple(replace(each, name=force.name) if each.along == along else each for each in element.forces)
        elements.append(replace(element, lengths={**lengths, **element.lengths}, forces=forces))
    return elements


def _end(body: str, point: Array) -> End:
    x, y, z = point.tolist()
    return (x, y, z) if body == GROUND else Place(body, (x, y, z))


def _on_joint(
    force: JointForce,
    coordinates: Mapping[str, Binding],
    smooth: Mapping[tuple[str, str], SmoothFriction],
    slips: Mapping[str, Binding],
) -> list[_LawEntry]:
    """Return the laws on coordinates of a joint."""
    index = {name: number for number, name in enumerate(coordinates)}
    entries = []
    for coordinate in force.coordinates:
        whole, friction = f"{force.joint}.{coordinate}", smooth.get((force.name, coordinate))
        if coordinate in force.laws or friction is not None:
            law = force.laws.get(coordinate, Law())
            shown, along = force.called(coordinate), coordinates.get(whole) or slips[whole]
            entries.append(_LawEntry(law, force.name, shown, along, index.get(whole, -1), friction))
    return entries


def _point(force: BodyForce, seats: Mapping[str, Seat], poses: Mapping[str, Pose]) -> Array:
    """Return the point of action of a force on a body, in the axes of its carrier."""
    if force.location is None:
        return seats[force.body].offset
    position, rotation = poses[force.body]
    location = numbers(force.location)
    return seats[force.body].point(location if force.local else rotation.T @ (location - position))


def compile_bushings(
    scene: Scene, bushings: Sequence[Bushing], seats: Mapping[str, Seat], poses: Mapping[str, Pose]
) -> Bushings:
    """Return all bushings. Raises InputError where a bushing connects two frames of one rigid body."""
    frames = [[_frame(bushing, side, seats, poses) for side in (0, 1)] for bushing in bushings]
    body = np.array([[seats[name].carrier for name in bushing.bodies] for bushing in bushings], dtype=np.intp)
    for bushing, (first, second) in zip(bushings, body.reshape(-1, 2), strict=True):
        if first == second:
            what = f"force '{bushing.name}' acts between two frames of one rigid body"
            raise InputError(Problem(what, scene.place("forces", bushing.name), "fixed joints have merged its bodies"))
    return Bushings(
        body=body.reshape(-1, 2),
        origin=numbers([[origin for origin, _ in pair] for pair in frames]).reshape(-1, 2, 3),
        turn=numbers([[turn for _, turn in pair] for pair in frames]).reshape(-1, 2, 4),
        stiffness=_blocks([bushing.stiffness for bushing in bushings]),
        damping=_blocks([bushing.damping for bushing in bushings]),
        preload=numbers([bushing.preload for bushing in bushings]).reshape(-1, 6),
    )


def _frame(
    bushing: Bushing, side: int, seats: Mapping[str, Seat], poses: Mapping[str, Pose]
) -> tuple[Array, tuple[float, ...]]:
    """Return the origin (3,) of a bushing's frame in the axes of its carrier, and the Euler parameters of the rotation
    from frame to carrier."""
    name = bushing.bodies[side]
    position, rotation = poses[name]
    point = numbers((bushing.points.first, bushing.points.second)[side])
    axes = numbers(to_matrix((bushing.axes.first, bushing.axes.second)[side]))
    origin = point if bushing.points.local else rotation.T @ (point - position)
    turn = axes if bushing.axes.local else rotation.T @ axes
    return seats[name].point(origin), from_matrix((seats[name].turn @ turn).tolist())


def _blocks(pairs: Sequence[tuple[Matrix, Matrix]]) -> Array:
    """Return block-diagonal matrices (B, 6, 6) from pairs of blocks (3, 3), translation and rotation."""
    blocks = numbers(pairs).reshape(-1, 2, 3, 3)
    matrices = np.zeros((len(pairs), 6, 6), like=blocks)
    matrices[:, :3, :3], matrices[:, 3:, 3:] = blocks[:, 0], blocks[:, 1]
    return matrices
