"""The scene's forces as arrays."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from mbproj.arrays import Array
from mbproj.constraints import PRIMITIVES
from mbproj.errors import InputError, Problem
from mbproj.functions.program import Program
from mbproj.functions.program_set import flatten
from mbproj.model.forces import BodyForces, Forces, Laws
from mbproj.model.frames import Pose
from mbproj.model.primitive_set import Binding, bind
from mbproj.model.rigid_groups import Seat
from mbproj.scene.records import BodyForce, JointForce, Law, PointForce, Scene

#: Two points that are closer than this, over 1 m + their coordinates, are one.
COINCIDENT = 1e-14

#: A law, the name of its force, what results call it, the primitive it acts along, the joint coordinate's number or -1.
Entry = tuple[Law, str, str, Binding, int]


def compile_forces(
    scene: Scene, seats: Mapping[str, Seat], poses: Mapping[str, Pose], coordinates: Mapping[str, Binding]
) -> tuple[Forces | None, tuple[str, ...]]:
    """The forces, None where there are none, and what results call the laws: the force's name, with the coordinate
    where it acts on several. `coordinates` are the joints' by whole name. Raises InputError."""
    if not scene.forces:
        return None, ()
    entries: list[Entry] = []
    for force in scene.forces:
        if isinstance(force, PointForce):
            entries.append(_between_points(scene, force, seats, poses))
        elif isinstance(force, JointForce):
            entries += _on_joint(force, coordinates)
    given = [force for force in scene.forces if isinstance(force, BodyForce)]
    programs: list[Program] = []
    owners: list[str] = []

    def number(program: Program | None, owner: str) -> int:
        if program is None:
            return -1
        programs.append(program)
        owners.append(owner)
        return len(programs) - 1

    laws = [entry[0] for entry in entries]
    bindings = [Binding(bound.primitive, at, bound.slots) for at, (_, _, _, bound, _) in enumerate(entries)]
    forces = Forces(
        laws=Laws(
            coordinates=bind(bindings),
            joint_coordinate=np.array([entry[4] for entry in entries], dtype=np.intp),
            stiffness=np.array([law.stiffness for law in laws], dtype=float),
            damping=np.array([law.damping for law in laws], dtype=float),
            free=np.array([law.free or 0.0 for law in laws], dtype=float),
            program=np.array([number(entry[0].function, entry[1]) for entry in entries], dtype=np.intp),
        ),
        on_bodies=BodyForces(
            body=np.array([seats[force.body].carrier for force in given], dtype=np.intp),
            point=np.array([_point(force, seats, poses) for force in given], dtype=float).reshape(-1, 3),
            is_torque=np.array([force.torque for force in given], dtype=bool),
            in_body=np.array([force.body_axes for force in given], dtype=bool),
            turn=np.array(
                [seats[force.body].turn if force.body_axes else np.eye(3) for force in given], dtype=float
            ).reshape(-1, 3, 3),
            program=np.array(
                [[number(each, force.name) for each in force.components] for force in given], dtype=np.intp
            ).reshape(-1, 3),
        ),
        programs=flatten(programs),
        law_owners=tuple(entry[1] for entry in entries),
        program_owners=tuple(owners),
    )
    return forces, tuple(entry[2] for entry in entries)


def _between_points(
    scene: Scene, force: PointForce, seats: Mapping[str, Seat], poses: Mapping[str, Pose]
) -> Entry:
    """A law on the distance of two points; without a free length it is that of the scene's pose."""
    slots, ends = [], []
    for side, (name, point) in enumerate(zip(force.bodies, (force.points.first, force.points.second), strict=True), 1):
        position, rotation = poses[name]
        local = np.array(point) if force.points.local else rotation.T @ (np.array(point) - position)
        ends.append(position + rotation @ local)
        slots.append((seats[name].carrier, side, seats[name].point(local)))
    length, place = float(np.linalg.norm(ends[1] - ends[0])), scene.place("forces", force.name)
    if slots[0][0] == slots[1][0]:
        what = f"force '{force.name}' acts between two points of one rigid body"
        raise InputError(Problem(what, place, "fixed joints have made its bodies one"))
    if length <= COINCIDENT * (1.0 + np.abs(ends).max()):
        what = f"force '{force.name}' has no direction: its two points are one at the scene's pose"
        raise InputError(Problem(what, place, "move one of its points"))
    law = force.law
    free = length if law.free is None else law.free
    bound = Binding(PRIMITIVES["distance"](), 0, tuple(slots))
    return Law(law.stiffness, law.damping, free, law.function), force.name, force.name, bound, -1


def _on_joint(force: JointForce, coordinates: Mapping[str, Binding]) -> list[Entry]:
    """The laws on coordinates of a joint."""
    index = {name: number for number, name in enumerate(coordinates)}
    several = len(force.laws) > 1
    entries = []
    for coordinate, law in force.laws.items():
        whole = f"{force.joint}.{coordinate}"
        shown = f"{force.name}.{coordinate}" if several else force.name
        entries.append((law, force.name, shown, coordinates[whole], index[whole]))
    return entries


def _point(force: BodyForce, seats: Mapping[str, Seat], poses: Mapping[str, Pose]) -> Array:
    """Where a given force acts, in its carrier's axes."""
    if force.location is None:
        return seats[force.body].offset
    position, rotation = poses[force.body]
    location = np.array(force.location)
    return seats[force.body].point(location if force.local else rotation.T @ (location - position))
