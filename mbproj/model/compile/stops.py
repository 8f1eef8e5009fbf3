"""The scene's stops as arrays: one row for each side of a limit that is not open."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.constraints import PRIMITIVES
from mbproj.constraints.wheel_height import WheelHeight
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem
from mbproj.model.compile.frames import Pose
from mbproj.model.compile.restitution import resistance
from mbproj.model.compile.rigid_groups import Seat
from mbproj.model.primitive_set import Binding, bind
from mbproj.model.stops import Stops
from mbproj.scene.records import Scene
from mbproj.scene.stops import DistanceStop, OfBody, PlaneStop, StopLaw
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True, eq=False)
class _Side:
    """One side of a limit; `coordinate` means the same as `Stops.joint_coordinate`."""

    name: str
    owner: str
    place: Place | None
    along: Binding
    side: float
    bound: float
    law: StopLaw
    coordinate: int = -1


def compile_stops(
    scene: Scene, seats: Mapping[str, Seat], poses: Mapping[str, Pose], coordinates: Mapping[str, Binding]
) -> tuple[Stops | None, tuple[str, ...]]:
    """Return the stops, None without any, and their names; stops of joints come first.

    `coordinates` are those of joints, by names such as "hinge.angle". Raises InputError where a stop acts between two
    points of one rigid body, or where a law of impacts is chosen without a rigid stop."""
    sides = [*_of_joints(scene, coordinates), *_of_forces(scene, seats, poses)]
    if scene.settings.impact_law != "newton" and not any(np.isinf(side.law.stiffness) for side in sides):
        said = "'impact_law' does nothing: the scene has no rigid stop"
        raise InputError(Problem(said, scene.place("simulation", "impact_law"), "leave it out"))
    if not sides:
        return None, ()
    laws = [side.law for side in sides]
    resistances = [_resistance(law) for law in laws]
    stops = Stops(
        coordinates=bind([Binding(each.along.primitive, at, each.along.slots) for at, each in enumerate(sides)]),
        joint_coordinate=np.array([each.coordinate for each in sides], dtype=np.intp),
        side=np.array([each.side for each in sides]),
        bound=np.array([each.bound for each in sides]),
        stiffness=np.array([law.stiffness for law in laws]),
        exponent=np.array([law.exponent for law in laws]),
        restitution=_or_nan([law.restitution for law in laws]),
        damping=_or_nan([law.damping for law in laws]),
        resistance=np.array([d for d, _ in resistances]),
        softening=np.array([κ for _, κ in resistances]),
        owners=tuple(each.owner for each in sides),
        places=tuple(each.place for each in sides),
        impact_law=scene.settings.impact_law,
    )
    return stops, tuple(each.name for each in sides)


def _or_nan(numbers: Sequence[float | None]) -> Array:
    return np.array([np.nan if number is None else number for number in numbers])


def _resistance(law: StopLaw) -> tuple[float, float]:
    """Return d and κ of a stop's law; 0 and 1 where no restitution is asked for."""
    if law.restitution is None or np.isinf(law.stiffness):
        return 0.0, 1.0
    return resistance(law.restitution)


def _side(at: int) -> float:
    """Return `Stops.side` of the lower (0) or the upper (1) bound."""
    return -1.0 if at else 1.0


def _of_joints(scene: Scene, coordinates: Mapping[str, Binding]) -> Iterator[_Side]:
    index = {name: number for number, name in enumerate(coordinates)}
    for joint in scene.joints:
        for coordinate, limit in joint.limits.items():
            whole, owner = f"{joint.name}.{coordinate}", f"joint '{joint.name}'"
            for name, (at, bound) in zip(limit.names(joint.name, coordinate), limit.sides(), strict=True):
                place = scene.place("joints", joint.name, "limits", coordinate, "range", at)
                yield _Side(name, owner, place, coordinates[whole], _side(at), bound, limit.law, index[whole])


def _of_forces(scene: Scene, seats: Mapping[str, Seat], poses: Mapping[str, Pose]) -> Iterator[_Side]:
    for force in scene.forces:
        if isinstance(force, DistanceStop):
            along = _distance(scene, force, seats, poses)
            for name, (at, bound) in zip(force.stops, force.limit.sides(), strict=True):
                place = scene.place("forces", force.name, ("shortest", "longest")[at])
                yield _Side(name, f"force '{force.name}'", place, along, _side(at), bound, force.limit.law)
        elif isinstance(force, PlaneStop):
            place = scene.place("forces", force.name)
            along = _from_plane(scene, force, seats, poses)
            bound = force.radius if force.axis is None else 0.0
            yield _Side(force.name, f"force '{force.name}'", place, along, _side(0), bound, force.law)


def _distance(scene: Scene, force: DistanceStop, seats: Mapping[str, Seat], poses: Mapping[str, Pose]) -> Binding:
    """Return the distance of the two points of a stop, as a binding."""
    points = [local_point(end, poses) for end in (force.first, force.second)]
    first, second = (
        position + rotation @ point
        for point, (position, rotation) in zip(points, (poses[force.first.body], poses[force.second.body]), strict=True)
    )
    _refuse_one_body(scene, force.name, "two points", seats[force.first.body], seats[force.second.body])
    size = max(np.abs(first).max(), np.abs(second).max())
    if np.linalg.norm(second - first) <= THRESHOLDS.no_digits * (1.0 + size):
        what = f"force '{force.name}' has no direction: its two points coincide at the scene's pose"
        raise InputError(Problem(what, scene.place("forces", force.name), "move one of its points"))
    on_carriers = [seated(end, point, seats) for end, point in zip((force.first, force.second), points, strict=True)]
    slots = tuple((carrier, side, local) for side, (carrier, local) in enumerate(on_carriers, 1))
    return Binding(PRIMITIVES["distance"](), 0, slots)


def _from_plane(scene: Scene, force: PlaneStop, seats: Mapping[str, Seat], poses: Mapping[str, Pose]) -> Binding:
    """Return the distance from a plane, along its normal, of a point or of the lowest point of a wheel."""
    _refuse_one_body(scene, force.name, "a plane and a point", seats[force.location.body], seats[force.point.body])
    carrier, location = seated(force.location, local_point(force.location, poses), seats)
    other, point = seated(force.point, local_point(force.point, poses), seats)
    plane, normal, centre = (
        (carrier, 1, location),
        (carrier, 1, local_vector(force.normal, seats, poses)),
        (other, 2, point),
    )
    if force.axis is None:
        return Binding(PRIMITIVES["along"](), 0, (normal, plane, centre))
    axis = (other, 2, local_vector(force.axis, seats, poses))
    return Binding(WheelHeight(force.radius), 0, (plane, normal, centre, axis))


def local_point(placed: OfBody, poses: Mapping[str, Pose]) -> Array:
    """Return a point in the axes of its body."""
    position, rotation = poses[placed.body]
    point = np.array(placed.vector)
    return point if placed.local else rotation.T @ (point - position)


def local_vector(placed: OfBody, seats: Mapping[str, Seat], poses: Mapping[str, Pose]) -> Array:
    """Return a direction in the axes of its body's carrier."""
    vector = np.array(placed.vector)
    return seats[placed.body].vector(vector if placed.local else poses[placed.body][1].T @ vector)


def seated(placed: OfBody, local: Array, seats: Mapping[str, Seat]) -> tuple[int, Array]:
    """Return the carrier of a point, and the point in the carrier's axes."""
    seat = seats[placed.body]
    return seat.carrier, seat.point(local)


def _refuse_one_body(scene: Scene, name: str, what: str, first: Seat, second: Seat) -> None:
    if first.carrier == second.carrier:
        said = f"force '{name}' acts between {what} of one rigid body"
        raise InputError(Problem(said, scene.place("forces", name), "fixed joints have merged its bodies"))
