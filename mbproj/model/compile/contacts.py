"""The scene's stops as arrays: one row for each side of a limit that is not open.

The resistance d of a compliant stop follows from its coefficient of restitution. A mass m meets F = k δᵖ (1 + d w), w =
δ' / √(δ'² + κ 2V/m), V = k δᵖ⁺¹ / (p + 1), and loses energy by w alone. Let σ² = δ'² / (δ'² + 2V/m) be the part of the
energy E that is kinetic. Then w = σ / √(σ² + κ (1 - σ²)), and E changes by d(ln E)/dσ = 2 d w σ / (1 + d w (1 - σ²))
while σ goes from 1 through 0 to -1. So the restitution

    ln e = - ∫ d w σ / (1 + d w (1 - σ²)) dσ   from -1 to 1

is the same at every speed and for every k, p and m. At rest w = 0, and the stop has its stiffness. It never pulls,
because d ≤ 1."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import lru_cache

import numpy as np

from mbproj.arrays import Array
from mbproj.constraints import PRIMITIVES
from mbproj.constraints.wheel_height import WheelHeight
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem
from mbproj.model.compile.frames import Pose
from mbproj.model.compile.rigid_groups import Seat
from mbproj.model.primitive_set import Binding, bind
from mbproj.model.stops import Stops
from mbproj.registry import USUAL_IMPACT_LAW
from mbproj.scene.read import Scene
from mbproj.scene.stops import DistanceStop, OfBody, PlaneStop, StopLaw
from mbproj.thresholds import THRESHOLDS

#: Nodes of the quadrature in ln σ.
NODES = 400
#: Below this restitution e, κ = 8 e⁴ with a relative error of 5e-12.
SMALL = 1e-6
TINY = float(np.finfo(float).tiny)
#: The quadrature begins this far, in ln σ, below each scale of the integrand: 1 and κ^(1/2).
BELOW = 16


@lru_cache(maxsize=256)
def resistance(e: float) -> tuple[float, float]:
    """Return d and κ of a stop with restitution e, 0 < e <= 1: κ = 1 as long as d <= 1 suffices, else d = 1."""
    if e == 1.0:
        return 0.0, 1.0
    wanted = -math.log(e)
    if wanted <= _lost(1.0, 1.0):
        return _solve(lambda d: _lost(d, 1.0) - wanted, 0.0, 1.0), 1.0
    if e < SMALL:
        return 1.0, max(8.0 * e**4, TINY)
    return 1.0, math.exp(_solve(lambda x: wanted - _lost(1.0, math.exp(x)), -4.0 * wanted, 0.0))


def _lost(d: float, kappa: float) -> float:
    """Return -ln e of a stop with d and κ. The integrand sums approach and departure at each σ > 0."""
    x, weight = _quadrature()
    least = 0.5 * math.log(kappa) - BELOW
    sigma = np.exp(0.5 * least * (1.0 - x))
    elastic = 1.0 - sigma**2
    root = np.sqrt(sigma**2 + kappa * elastic)
    # root - d σ (1 - σ²), without cancellation
    kept = kappa * elastic / (root + sigma) + (1.0 - d) * sigma + d * sigma**3
    rate = d * sigma**2 * (1.0 / kept + 1.0 / (root + d * sigma * elastic))
    return float(-0.5 * least * (weight @ (rate * sigma)))


@lru_cache(maxsize=1)
def _quadrature() -> tuple[Array, Array]:
    """Return the Gauss-Legendre nodes and weights on -1 … 1."""
    return np.polynomial.legendre.leggauss(NODES)


def _solve(rising: Callable[[float], float], low: float, high: float) -> float:
    """Return the root of a rising function, by bisection to round-off."""
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if rising(middle) < 0.0 else (low, middle)
    return middle


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
    if scene.settings.impact_law != USUAL_IMPACT_LAW and not any(np.isinf(side.law.stiffness) for side in sides):
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
