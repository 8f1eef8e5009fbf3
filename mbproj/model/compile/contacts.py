"""The scene's stops as arrays: one row for each side of a limit that is not open.

The resistance d of a compliant stop follows from its coefficient of restitution. A mass m meets F = k δᵖ (1 + d w), w =
δ' / √(δ'² + κ 2V/m), V = k δᵖ⁺¹ / (p + 1), and loses energy by w alone. Let σ² = δ'² / (δ'² + 2V/m) be the part of the
energy E that is kinetic. Then w = σ / √(σ² + κ (1 - σ²)), and E changes by d(ln E)/dσ = 2 d w σ / (1 + d w (1 - σ²))
while σ goes from 1 through 0 to -1. So the restitution

    ln e = - ∫ d w σ / (1 + d w (1 - σ²)) dσ   from -1 to 1

is the same at every speed and for every k, p and m. At rest w = 0, and the stop has its stiffness. It never pulls,
because d ≤ 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem
from mbproj.base.registry import USUAL_IMPACT_LAW
from mbproj.base.thresholds import THRESHOLDS
from mbproj.functions.program import RATE, Code, Instruction, Op, Program, apply, number, variable
from mbproj.functions.standard import reading
from mbproj.joints.primitives.basic import Along
from mbproj.joints.primitives.rolling import BallSlip, Slip, WheelHeight, WheelSlipAcross, WheelSlipAlong
from mbproj.joints.primitives.table import PRIMITIVES
from mbproj.joints.table import JOINTS
from mbproj.model.compile.frames import SYMBOLS, Pose, Seat
from mbproj.model.compile.joints import primitive_of
from mbproj.model.contacts import Bearings, Frictions, Stops
from mbproj.model.primitive_set import Binding, bind, bindings
from mbproj.scene.blocks.ropes import Path
from mbproj.scene.expressions.compiled import formula
from mbproj.scene.records import Bearing, DistanceStop, DryFriction, Joint, JointForce, OfBody, PlaneStop, StopLaw
from mbproj.scene.scene import Scene

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
    difference = kappa * elastic / (root + sigma) + (1.0 - d) * sigma + d * sigma**3
    rate = d * sigma**2 * (1.0 / difference + 1.0 / (root + d * sigma * elastic))
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


# --- The scene's dry friction as arrays -------------------------------------------------------------------------------
# Frictions that can stick, the loads they depend on, and regularised frictions.


@dataclass(frozen=True, eq=False)
class _Dry:
    """A dry friction: its force, its coordinate and the `whole` name "joint.coordinate". `name` stands in results,
    `owner` in messages. `bearing`: the number of its bearing, -1 for none. `place`: its place in the scene."""

    force: str
    coordinate: str
    whole: str
    name: str
    owner: str
    dry: DryFriction
    bearing: int
    place: Place | None

    @property
    def key(self) -> tuple[str, str]:
        """Its force and its coordinate."""
        return self.force, self.coordinate


@dataclass(frozen=True, eq=False)
class SmoothFriction:
    """A regularised friction as a law: a program, times the load of the bearing of this number (-1: 1)."""

    program: Program
    bearing: int


@dataclass(frozen=True, eq=False)
class DryFrictions:
    """All dry friction of a scene: frictions that can stick, with their `names` in results; bearings; and regularised
    frictions by force and coordinate."""

    frictions: Frictions | None = None
    bearings: Bearings | None = None
    names: tuple[str, ...] = ()
    smooth: Mapping[tuple[str, str], SmoothFriction] = field(default_factory=dict)


def compile_friction(
    scene: Scene,
    joints: Sequence[Joint],
    axes: Sequence[Array],
    coordinates: Mapping[str, Binding],
    slips: Mapping[str, Binding],
) -> DryFrictions:
    """Return the dry friction on coordinates of joints.

    `joints` are the joints of the system, `axes` their z axes in the axes of body 2. `coordinates` are all coordinates
    of joints, by names such as "hinge.angle"; `slips` are those that friction resists in joints without a coordinate
    for them."""
    loads: list[_Load] = []
    frictions = list(_dry_frictions(scene, {joint.name: (at, joint) for at, joint in enumerate(joints)}, loads))
    frictions += _on_ropes(scene, joints, loads)
    sticking = [each for each in frictions if each.dry.regularised is None]
    smooth = {
        each.key: SmoothFriction(_smooth(each.dry, each.dry.regularised), each.bearing)
        for each in frictions
        if each.dry.regularised is not None
    }
    names = tuple(each.name for each in sticking)
    return DryFrictions(
        _frictions(sticking, coordinates, slips) if sticking else None,
        _bearings(loads, axes) if loads else None,
        names,
        smooth,
    )


@dataclass(frozen=True, eq=False)
class _Load:
    """A row of `Bearings`. With a `row` of the joint the load is the multiplier of this row. Without an axis the whole
    force counts."""

    joint: int
    radial: float
    axial: float
    length: float
    preload: float
    row: int | None = None
    has_axis: bool = True


def _dry_frictions(scene: Scene, joints: Mapping[str, tuple[int, Joint]], loads: list[_Load]) -> Iterator[_Dry]:
    """The dry frictions of a scene; the loads of their bearings are appended to `loads`."""
    for force in scene.forces:
        for coordinate, dry in force.coulomb.items() if isinstance(force, JointForce) else ():
            assert isinstance(force, JointForce)
            bearing = -1
            if dry.bearing is not None:
                at, joint = joints[force.joint]
                bearing = len(loads)
                loads.append(_load(at, joint, dry.unit, dry.bearing))
            place = scene.place("forces", force.name, "coulomb", coordinate)
            whole, name = f"{force.joint}.{coordinate}", force.called(coordinate)
            yield _Dry(force.name, coordinate, whole, name, f"force '{force.name}'", dry, bearing, place)


def _on_ropes(scene: Scene, joints: Sequence[Joint], loads: list[_Load]) -> Iterator[_Dry]:
    """The frictions of ropes on sheaves. The tension is T on one side and T e^(μα) on the other (Euler, Eytelwein). The
    friction is their difference, 2 tanh(μα/2) times their mean, which is the multiplier of the rope's row."""
    for at, joint in enumerate(joints):
        if "path" not in joint.parameters:
            continue
        path: Path = joint.parameters["path"]
        for one, k in enumerate(path.rubbing, 1):
            name, node = f"{joint.name}.slip_{one}", path.nodes[k]
            wrapped = reading(f"{joint.name}.wrapped_{one}")
            grip = formula("2*tanh(m*s/(2*r))", m=node.friction or 0.0, s=wrapped, r=node.radius)
            dry = DryFriction("m", grip, grip, bearing=Bearing())
            loads.append(_Load(at, 0.0, 1.0, math.inf, 0.0, 0, has_axis=False))
            place = scene.place("joints", joint.name, "path", k, "friction")
            owner = f"the friction on place {k + 1} of rope '{joint.name}'"
            yield _Dry(joint.name, f"slip_{one}", name, name, owner, dry, len(loads) - 1, place)


def _load(at: int, joint: Joint, unit: str, bearing: Bearing) -> _Load:
    """Return the load of a bearing of joint number `at`: in N m for an angle, in N for a displacement."""
    radius, kind = bearing.radius or 0.0, JOINTS[joint.type]
    if kind.slip:
        return _Load(at, 0.0, 1.0, math.inf, bearing.preload, 0, has_axis=False)
    if unit == "m":
        in_space = "space_arc" in (row[0] for row in kind.coordinates.values())
        return _Load(at, 1.0, 0.0, bearing.length, bearing.preload, has_axis=not in_space)
    if kind.is_threaded and bearing.axial_radius is None:
        return _Load(at, 0.0, radius, bearing.length, bearing.preload * radius)
    return _Load(at, radius, bearing.axial_radius or 0.0, bearing.length, bearing.preload * radius)


def _bearings(loads: Sequence[_Load], axes: Sequence[Array]) -> Bearings:
    def column(name: str) -> Array:
        return np.array([getattr(load, name) for load in loads], dtype=float)

    return Bearings(
        joint=np.array([load.joint for load in loads], dtype=np.intp),
        axis=np.array([axes[load.joint] if load.has_axis else np.zeros(3) for load in loads]),
        radial=column("radial"),
        axial=column("axial"),
        length=column("length"),
        preload=column("preload"),
        parts=tuple(() if load.row is None else ((load.joint, load.row, 1.0),) for load in loads),
    )


def _frictions(sticking: Sequence[_Dry], coordinates: Mapping[str, Binding], slips: Mapping[str, Binding]) -> Frictions:
    index = {name: at for at, name in enumerate(coordinates)}
    along = [coordinates.get(each.whole) or slips[each.whole] for each in sticking]
    laws = [each.dry for each in sticking]
    return Frictions(
        coordinates=bind([Binding(each.primitive, at, each.slots) for at, each in enumerate(along)]),
        joint_coordinate=np.array([index.get(each.whole, -1) for each in sticking], dtype=np.intp),
        sliding=np.array([np.nan if dry.varies else dry.sliding for dry in laws], dtype=float),
        static=np.array([np.nan if dry.varies else dry.static for dry in laws], dtype=float),
        stribeck=np.array([dry.stribeck_speed or 0.0 for dry in laws], dtype=float),
        bearing=np.array([each.bearing for each in sticking], dtype=np.intp),
        stop=np.full(len(sticking), -1, dtype=np.intp),
        partner=np.full(len(sticking), -1, dtype=np.intp),
        owners=tuple(each.owner for each in sticking),
        places=tuple(each.place for each in sticking),
        varies={at: _sizes(dry) for at, dry in enumerate(laws) if dry.varies},
    )


def _sizes(dry: DryFriction) -> tuple[Program, Program]:
    """Return the sliding and the static friction as functions: at least 0, and static at least sliding."""
    sliding = formula("max(0, f)", f=dry.sliding)
    return sliding, sliding if dry.static is dry.sliding else formula("max(f, g)", f=sliding, g=dry.static)


def _smooth(dry: DryFriction, width: float) -> Program:
    """Return -(sliding + (static - sliding) exp(-(s'/stribeck_speed)²)) tanh(s'/width) as a program. Its variables are
    the rate s' and the channels on which the friction depends."""
    rate = variable(RATE)
    if isinstance(dry.sliding, Program) or isinstance(dry.static, Program):
        (f, g), v = _sizes(dry), Program(rate)
        if dry.stribeck_speed is not None:
            f = formula("f + (g - f)*exp(-(v/fallen)**2)", f=f, g=g, v=v, fallen=dry.stribeck_speed)
        return formula("-f*tanh(v/width)", f=f, v=v, width=width)
    size: Code = number(dry.sliding)
    if dry.stribeck_speed is not None:
        part = apply(Op.DIVIDE, rate, number(dry.stribeck_speed))
        fall = apply(Op.EXP, apply(Op.NEGATE, (*part, Instruction(Op.POWER, 2.0))))
        size = apply(Op.ADD, size, apply(Op.MULTIPLY, number(dry.static - dry.sliding), fall))
    sign = apply(Op.TANH, apply(Op.DIVIDE, rate, number(width)))
    return Program(apply(Op.NEGATE, apply(Op.MULTIPLY, size, sign)))


# --- Dry friction of points, balls and wheels on planes as arrays -----------------------------------------------------
# Along two tangents of each plane.


def tangential_friction(
    scene: Scene, seats: Mapping[str, Seat], poses: Mapping[str, Pose], stops: Sequence[str]
) -> tuple[Frictions | None, tuple[str, ...]]:
    """Return the friction at plane stops, None without any, and its names: "floor.1", "floor.2"."""
    rubbing = [force for force in scene.forces if isinstance(force, PlaneStop) and force.friction is not None]
    if not rubbing:
        return None, ()
    laws = [force.friction for force in rubbing if force.friction is not None]
    along = [binding for force in rubbing for binding in _tangents(force, seats, poses)]
    none = np.full(2 * len(rubbing), -1, dtype=np.intp)
    frictions = Frictions(
        coordinates=bind([replace(each, owner=at) for at, each in enumerate(along)]),
        joint_coordinate=none,
        sliding=np.repeat([law.sliding for law in laws], 2),
        static=np.repeat([law.static for law in laws], 2),
        stribeck=np.repeat([law.stribeck_speed or 0.0 for law in laws], 2),
        bearing=none,
        stop=np.repeat([stops.index(force.name) for force in rubbing], 2),
        partner=np.arange(len(none)) ^ 1,
        owners=tuple(f"force '{force.name}'" for force in rubbing for _ in range(2)),
        places=tuple(scene.place("forces", force.name, "friction") for force in rubbing for _ in range(2)),
    )
    return frictions, tuple(name for force in rubbing for name in force.frictions)


def all_frictions(first: Frictions | None, second: Frictions | None) -> Frictions | None:
    """Return the frictions of joints, and after them those of stops."""
    if first is None or second is None:
        return first or second
    both = [*bindings(first.coordinates), *bindings(second.coordinates)]
    partner = np.where(second.partner >= 0, second.partner + first.size, -1)

    def of_both(name: str) -> Any:
        return np.concatenate([getattr(first, name), getattr(second, name)])

    return Frictions(
        coordinates=bind([replace(each, owner=at) for at, each in enumerate(both)]),
        joint_coordinate=of_both("joint_coordinate"),
        sliding=of_both("sliding"),
        static=of_both("static"),
        stribeck=of_both("stribeck"),
        bearing=of_both("bearing"),
        stop=of_both("stop"),
        partner=np.append(first.partner, partner),
        owners=(*first.owners, *second.owners),
        places=(*first.places, *second.places),
        varies=first.varies,
    )


def _tangents(force: PlaneStop, seats: Mapping[str, Seat], poses: Mapping[str, Pose]) -> list[Binding]:
    """Return the rows along both tangents. A point moves along them; a ball or a wheel slips at its lowest point."""
    seat, triad = seats[force.normal.body], _triad(force, poses)
    carrier, location = seated(force.location, local_point(force.location, poses), seats)
    other, point = seated(force.point, local_point(force.point, poses), seats)
    plane, centre = (carrier, 1, location), (other, 2, point)
    x, y, z = ((carrier, 1, seat.vector(vector)) for vector in triad)
    if force.radius == 0.0:
        return [Binding(Along(), 0, (tangent, plane, centre)) for tangent in (x, y)]
    if force.axis is None:
        back, of_ball = (carrier, 1, -x[2]), _slots(other, np.eye(3))
        both = ((plane, *axes, centre, *of_ball) for axes in ((x, y, z), (y, back, z)))
        return [Binding(BallSlip(force.radius), 0, slots) for slots in both]
    axis = local_vector(force.axis, seats, poses)
    across = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    across /= np.linalg.norm(across)
    slots = (plane, x, y, z, centre, *_slots(other, np.array([np.cross(across, axis), across, axis])))
    return [Binding(slip(force.radius), 0, slots) for slip in (WheelSlipAlong, WheelSlipAcross)]


def _triad(force: PlaneStop, poses: Mapping[str, Pose]) -> Array:
    """Return two tangents of the plane and its normal as rows (3, 3), in the axes of its body. The first is as near as
    can be to the global axis most nearly normal to the plane's normal. So planes along global axes have tangents along
    these."""
    rotation = poses[force.normal.body][1]
    normal = np.array(force.normal.vector)
    normal = rotation @ normal if force.normal.local else normal
    axis = np.eye(3)[int(np.argmin(np.abs(normal)))]
    across = np.cross(normal, axis)
    across /= np.linalg.norm(across)
    first = np.cross(across, normal)
    return np.array([first / np.linalg.norm(first), across, normal]) @ rotation


def _slots(carrier: int, vectors: Array) -> list[tuple[int, int, Array]]:
    """Return vectors of the second body as slots of a row."""
    return [(carrier, 2, vector) for vector in vectors]


# --- The point of contact of a joint that rolls on a plane ------------------------------------------------------------
# No body carries this point along.


#: The primitive whose point of contact is that of a wheel. A joint that rolls along a line has no row of slip, but
#: touches its plane as a wheel does.
WHEEL = "wheel_slip_along"


def place_of_contact(joint: Joint) -> Callable[[Array], Array] | None:
    """Return a function from the joint's symbols (T, 8, 3) to its points of contact (T, 3), all global. None for a
    joint that does not roll."""
    kinds = [row[0] for row in JOINTS[joint.type].rows]
    slips = [kind for kind in kinds if issubclass(PRIMITIVES[kind], Slip)]
    if not slips and not JOINTS[joint.type].is_on_plane:
        return None
    slip = primitive_of((slips[0] if slips else WHEEL,), joint)
    assert isinstance(slip, Slip)

    def place(symbols: Array) -> Array:
        arm, _ = slip.contact(symbols)
        return np.asarray(symbols[:, SYMBOLS.index("p2")] + arm, dtype=float)

    return place
