"""A scene k times as large that moves alike: lengths, velocities and gravity grow by k; times and masses stay.

Forces grow by k; torques, energies and moments of inertia grow by k². It is the same mechanism in another unit of
length: k = 1000 for millimetres.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Problem
from mbproj.functions.elements import Kind
from mbproj.functions.program import (
    CHANNELS,
    COORDINATE,
    RATE,
    TIME,
    Code,
    Op,
    Program,
    apply,
    number,
    replaced,
    variable,
)
from mbproj.functions.space_curve import SpaceTrack, Track
from mbproj.joints.table import COORDINATE_UNITS, JOINTS
from mbproj.model.compile.frames import SYMBOLS, local_frames, poses_of
from mbproj.scene.blocks.elements import element_type
from mbproj.scene.blocks.ropes import Path
from mbproj.scene.blocks.signals import names_channels
from mbproj.scene.expressions.units import DAMPING, STIFFNESS, TORSION_DAMPING, TORSION_STIFFNESS
from mbproj.scene.fields.quantities import dimension_of
from mbproj.scene.fields.rotations import from_matrix, multiply
from mbproj.scene.records import (
    GROUND,
    Bearing,
    Body,
    BodyForce,
    Bushing,
    Coupled,
    DistanceStop,
    DryFriction,
    Force,
    Joint,
    JointForce,
    Law,
    Limit,
    Marker,
    Matrix,
    Motion,
    OfBody,
    Orientations,
    Pair,
    PlaneFriction,
    PlaneStop,
    PointForce,
    StopLaw,
    Vector,
)
from mbproj.scene.scene import Scene

# --- Functions of a scene combined into others ------------------------------------------------------------------------
# Multiplied, summed, or with a scaled argument.


def times(factor: float, program: Program) -> Program:
    """The program factor · f."""
    return replace(program, code=apply(Op.MULTIPLY, number(factor), program.code))


def combined(factors: Sequence[float], programs: Sequence[Program]) -> Program:
    """The program Σ factor · f."""
    reads = tuple(dict.fromkeys(name for program in programs for name in program.reads))
    parts = []
    for factor, program in zip(factors, programs, strict=True):
        by = {CHANNELS + at: variable(CHANNELS + reads.index(name)) for at, name in enumerate(program.reads)}
        parts.append(replaced(times(factor, program).code, by))
    return Program(apply(Op.ADD, *parts), ", ".join(program.text for program in programs if program.text), reads)


def with_argument(program: Program, variable: int, factor: float) -> Program:
    """The program f with its argument x replaced by factor · x. `variable` is the number of x (`TIME`, `COORDINATE`,
    `RATE`)."""
    code: Code = ()
    for step in program.code:
        is_it = step.op is Op.VARIABLE and int(step.operand) == variable
        code += apply(Op.MULTIPLY, number(factor), (step,)) if is_it else (step,)
    return replace(program, code=code)


# --- A scene k times as large that moves alike ------------------------------------------------------------------------


def rescaled(scene: Scene, k: float) -> Scene:
    """Return the scene, k times as large. Raises InputError where it has elements, signals or states, because their
    numbers have no units."""
    if scene.elements:
        what = f"element '{scene.elements[0].name}' is data without units: it cannot be made larger"
        raise InputError(Problem(what, hint="vary something else"))
    if names_channels(scene):
        what = "the numbers in signals, states and what names coordinates have no units: it cannot be made larger"
        raise InputError(Problem(what, hint="vary something else"))
    larger = _Larger(k, {joint.name: joint.type for joint in scene.joints})
    return replace(
        scene,
        gravity=larger.vector(scene.gravity),
        bodies=tuple(map(larger.body, scene.bodies)),
        joints=tuple(map(larger.joint, scene.joints)),
        markers=tuple(map(larger.marker, scene.markers)),
        forces=tuple(map(larger.force, scene.forces)),
        motions=tuple(map(larger.motion, scene.motions)),
    )


@dataclass(frozen=True)
class _Larger:
    """The factor k, and the types of the joints by name."""

    k: float
    types: dict[str, str]

    def vector(self, components: Vector) -> Vector:
        x, y, z = components
        return self.k * x, self.k * y, self.k * z

    def body(self, body: Body) -> Body:
        return replace(
            body,
            inertia=scaled_matrix(self.k**2, body.inertia),
            position=self.vector(body.position),
            velocity=self.vector(body.velocity),
        )

    def points(self, pair: Pair) -> Pair:
        return replace(pair, first=self.vector(pair.first), second=self.vector(pair.second))

    def joint(self, joint: Joint) -> Joint:
        units = {name: each.unit for name, each in JOINTS[joint.type].parameters.items()}
        parameters = {name: self._in(units.get(name, "m"), value) for name, value in joint.parameters.items()}
        return replace(
            joint,
            points=self.points(joint.points),
            start={name: self._unit(joint.name, name) * value for name, value in joint.start.items()},
            speed={name: self._unit(joint.name, name) * value for name, value in joint.speed.items()},
            parameters=parameters,
            couples=joint.couples and self._coupled(joint.couples),
            reflected_inertia={
                name: value if self._unit(joint.name, name) == self.k else self.k**2 * value
                for name, value in joint.reflected_inertia.items()
            },
            limits={name: self._limit(limit, self._unit(joint.name, name)) for name, limit in joint.limits.items()},
        )

    def _in(self, unit: str, value: Any) -> Any:
        """Return a value of the given `unit`, scaled by k for each metre in the unit: a number, a tuple, a curve or a
        path. A name stays."""
        if isinstance(value, Track | SpaceTrack):
            return value.scaled(self.k)
        if isinstance(value, Path):
            return value.changed(lambda at: replace(at, vector=self.vector(at.vector)), lambda n: n, self.k)
        if isinstance(value, str):
            return value
        if isinstance(value, tuple):
            return tuple(self._in(unit, each) for each in value)
        return self.k ** dimension_of(unit).length * value

    def _coupled(self, coupled: Coupled) -> Coupled:
        """Return a coupling, scaled. Where it couples a length, its whole row grows by k: weights and function are
        adapted to the scaled coordinates."""
        units = {name: self._unit(*name.split(".")) for name in coupled.of}
        if self.k not in units.values():
            return coupled
        function = coupled.function
        if function is not None:
            (first, *_) = units.values()
            function = times(self.k, with_argument(function, COORDINATE, 1.0 / first))
        weights = {name: weight * self.k / units[name] for name, weight in coupled.of.items()}
        constant = None if coupled.constant is None else self.k * coupled.constant
        return replace(coupled, of=weights, function=function, constant=constant)

    def marker(self, marker: Marker) -> Marker:
        return replace(marker, location=self.vector(marker.location))

    def force(self, force: Force) -> Force:
        if isinstance(force, PointForce):
            points, element = self.points(force.points), self._element(force.element)
            return replace(force, points=points, law=self._law(force.law, self.k), element=element)
        if isinstance(force, JointForce):
            laws = {name: self._law(law, self._unit(force.joint, name)) for name, law in force.laws.items()}
            coulomb = {name: self._dry(dry, self._unit(force.joint, name)) for name, dry in force.coulomb.items()}
            return replace(force, laws=laws, coulomb=coulomb, element=self._element(force.element))
        if isinstance(force, Bushing):
            return self._bushing(force)
        if isinstance(force, DistanceStop):
            ends = (self.of_body(force.first), self.of_body(force.second))
            return replace(force, first=ends[0], second=ends[1], limit=self._limit(force.limit, self.k))
        if isinstance(force, PlaneStop):
            plane, point = self.of_body(force.location), self.of_body(force.point)
            law = self._stop_law(force.law, self.k)
            rubs = force.friction and self._rubs(force.friction)
            return replace(force, location=plane, point=point, radius=self.k * force.radius, law=law, friction=rubs)
        return self._on_body(force)

    def _element(self, kind: Kind | None) -> Kind | None:
        """Return an element with each number scaled by its unit."""
        if kind is None:
            return None
        units = element_type(kind.type).units
        return replace(
            kind, values={name: self._in(units.get(name, "m"), value) for name, value in kind.values.items()}
        )

    def of_body(self, point: OfBody) -> OfBody:
        return replace(point, vector=self.vector(point.vector))

    def _limit(self, limit: Limit, unit: float) -> Limit:
        low, high = (None if bound is None else unit * bound for bound in (limit.low, limit.high))
        return Limit(low, high, self._stop_law(limit.law, unit))

    def _stop_law(self, law: StopLaw, unit: float) -> StopLaw:
        """Return the law of a stop, scaled, where the coordinate is multiplied by `unit` (k for a length, 1 for an
        angle)."""
        stiffer = self.k if unit == self.k else self.k**2
        damping = None if law.damping is None else law.damping / unit
        return replace(law, stiffness=stiffer * law.stiffness / unit**law.exponent, damping=damping)

    def _rubs(self, friction: PlaneFriction) -> PlaneFriction:
        speed = friction.stribeck_speed
        return replace(friction, stribeck_speed=None if speed is None else self.k * speed)

    def _dry(self, dry: DryFriction, unit: float) -> DryFriction:
        """Return dry friction, scaled, where the coordinate is multiplied by `unit`. Friction coefficients stay."""
        larger = 1.0 if dry.bearing is not None else self.k if unit == self.k else self.k**2

        def speed(value: float | None) -> float | None:
            return None if value is None else unit * value

        return replace(
            dry,
            sliding=self._larger(larger, dry.sliding),
            static=self._larger(larger, dry.static),
            stribeck_speed=speed(dry.stribeck_speed),
            regularised=speed(dry.regularised),
            bearing=None if dry.bearing is None else self._bearing(dry.bearing),
        )

    def _larger(self, factor: float, size: float | Program) -> float | Program:
        return times(factor, size) if isinstance(size, Program) else factor * size

    def _bearing(self, bearing: Bearing) -> Bearing:
        radius, axial = (None if arm is None else self.k * arm for arm in (bearing.radius, bearing.axial_radius))
        return Bearing(radius, axial, self.k * bearing.length, self.k * bearing.preload)

    def _bushing(self, force: Bushing) -> Bushing:
        """Return a bushing whose torsional stiffness and damping are k² times as large. Translational ones stay: forces
        and lengths both grow by k."""
        (elastic, torsional), (viscous, turning), (push, twist) = force.stiffness, force.damping, force.preload
        return replace(
            force,
            points=self.points(force.points),
            stiffness=(elastic, scaled_matrix(self.k**2, torsional)),
            damping=(viscous, scaled_matrix(self.k**2, turning)),
            preload=(self.vector(push), self.vector(self.vector(twist))),
        )

    def motion(self, motion: Motion) -> Motion:
        return replace(motion, function=times(self._unit(motion.joint, motion.coordinate), motion.function))

    def _on_body(self, force: BodyForce) -> BodyForce:
        factor = self.k**2 if force.torque else self.k
        first, second, third = (times(factor, component) for component in force.components)
        location = None if force.location is None else self.vector(force.location)
        return replace(force, components=(first, second, third), location=location)

    def _unit(self, joint: str, coordinate: str) -> float:
        """The factor of a joint coordinate: k where it is in metres, 1 for an angle."""
        row = JOINTS[self.types[joint]].coordinates[coordinate]
        return self.k if COORDINATE_UNITS[row[0]] == "m" else 1.0

    def _law(self, law: Law, unit: float) -> Law:
        """Return a law, scaled, where the coordinate is multiplied by `unit`: a force grows by k, a torque by k²."""
        stiffer = 1.0 if unit == self.k else self.k**2
        return replace(
            law,
            stiffness=stiffer * law.stiffness,
            damping=stiffer * law.damping,
            free=None if law.free is None else unit * law.free,
            function=None if law.function is None else self._function(law.function, stiffer * unit, unit),
        )

    def _function(self, function: Program, factor: float, unit: float) -> Program:
        inside = with_argument(with_argument(function, COORDINATE, 1.0 / unit), RATE, 1.0 / unit)
        return times(factor, inside)


def scaled_matrix(factor: float, matrix: Matrix) -> Matrix:
    """The product of a number and a matrix of a record."""
    first, second, third = ((factor * x, factor * y, factor * z) for x, y, z in matrix)
    return first, second, third


# --- A scene turned and shifted as a whole, with gravity and forces ---------------------------------------------------


def _with_x_axes(scene: Scene) -> list[Joint]:
    """The joints of a scene, each with the direction of its x also where the model chooses it. The model takes it from
    the global axes, which do not turn with the scene."""
    free = [joint for joint in scene.joints if joint.x_axis is None and JOINTS[joint.type].x_axis == "optional"]
    frames = local_frames(free, poses_of(scene))
    x1, x2 = SYMBOLS.index("x1"), SYMBOLS.index("x2")
    axes = {
        joint.name: Pair(_vector(frame[x1]), _vector(frame[x2]), local=True)
        for joint, frame in zip(free, frames, strict=True)
    }
    return [replace(joint, x_axis=axes.get(joint.name, joint.x_axis)) for joint in scene.joints]


@dataclass(frozen=True, eq=False)
class RigidMotion:
    """The rigid motion x -> R x + s with a rotation R (3, 3) and a shift s (3,) in m."""

    rotation: Array
    shift: Array

    @property
    def parameters(self) -> Array:
        """The Euler parameters of R, (4,)."""
        return np.array(from_matrix(_rows(self.rotation)))

    def scene(self, scene: Scene) -> Scene:
        """Return the scene, moved."""
        return replace(
            scene,
            gravity=self._direction(scene.gravity),
            bodies=tuple(map(self._body, scene.bodies)),
            joints=tuple(map(self._joint, _with_x_axes(scene))),
            markers=tuple(map(self._marker, scene.markers)),
            forces=tuple(map(self._force, scene.forces)),
        )

    def _direction(self, vector: Vector) -> Vector:
        return _vector(self.rotation @ np.array(vector))

    def _point(self, vector: Vector) -> Vector:
        return _vector(self.rotation @ np.array(vector) + self.shift)

    def _body(self, body: Body) -> Body:
        return replace(
            body,
            position=self._point(body.position),
            orientation=multiply(from_matrix(_rows(self.rotation)), body.orientation),
            velocity=self._direction(body.velocity),
        )

    def _joint(self, joint: Joint) -> Joint:
        """Return a joint, moved. Vectors in a body's axes stay; those in the ground's axes, which are global, are
        turned."""
        points = [self._point(joint.points.first), self._point(joint.points.second)]
        parameters, path = joint.parameters, joint.parameters.get("path")
        if path is not None:
            parameters = {**parameters, "path": path.changed(self._of_body, self._direction)}
        return replace(
            joint,
            parameters=parameters,
            points=_of_ground(joint, joint.points, points),
            axes=joint.axes and self._directions(joint, joint.axes),
            x_axis=joint.x_axis and self._directions(joint, joint.x_axis),
        )

    def _directions(self, joint: Joint, pair: Pair) -> Pair:
        return _of_ground(joint, pair, [self._direction(pair.first), self._direction(pair.second)])

    def _marker(self, marker: Marker) -> Marker:
        stays = marker.local and marker.body != "ground"
        return marker if stays else replace(marker, location=self._point(marker.location))

    def _orientations(self, bodies: tuple[str, str], axes: Orientations) -> Orientations:
        """Return two frames, moved: both where they are global, otherwise only the one given in the ground's axes."""
        first, second = (
            old if axes.local and name != "ground" else multiply(from_matrix(_rows(self.rotation)), old)
            for name, old in zip(bodies, (axes.first, axes.second), strict=True)
        )
        return replace(axes, first=first, second=second)

    def _force(self, force: Force) -> Force:
        if isinstance(force, PointForce | Bushing):
            moved = [self._point(force.points.first), self._point(force.points.second)]
            points = _of_ground(force, force.points, moved)
            if isinstance(force, PointForce):
                return replace(force, points=points)
            return replace(force, points=points, axes=self._orientations(force.bodies, force.axes))
        if isinstance(force, BodyForce):
            components = force.components
            if not force.body_axes:
                first, second, third = (combined(row.tolist(), components) for row in self.rotation)
                components = (first, second, third)
            point = force.location
            location = point if point is None or force.local else self._point(point)
            return replace(force, components=components, location=location)
        if isinstance(force, DistanceStop):
            return replace(force, first=self._of_body(force.first), second=self._of_body(force.second))
        if isinstance(force, PlaneStop):
            normal = force.normal
            if not _stays(normal):
                normal = replace(normal, vector=self._direction(normal.vector))
            return replace(
                force, location=self._of_body(force.location), normal=normal, point=self._of_body(force.point)
            )
        return force

    def _of_body(self, point: OfBody) -> OfBody:
        return point if _stays(point) else replace(point, vector=self._point(point.vector))


def _stays(placed: OfBody) -> bool:
    """Whether a point or direction is given in the axes of a moving body, so that it does not change."""
    return placed.local and placed.body != "ground"


def _of_ground(holder: Joint | PointForce | Bushing, pair: Pair, moved: list[Vector]) -> Pair:
    """Return a pair of vectors, moved: both where it is global, otherwise only the one given in the ground's axes."""
    if not pair.local:
        return Pair(moved[0], moved[1])
    unmoved = (pair.first, pair.second)
    ends = [new if name == "ground" else old for name, old, new in zip(holder.bodies, unmoved, moved, strict=True)]
    return Pair(ends[0], ends[1], local=True)


def _vector(values: Array) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _rows(matrix: Array) -> tuple[Vector, Vector, Vector]:
    first, second, third = (_vector(row) for row in matrix)
    return first, second, third


# --- Variants of a scene that move faster, or have stiffer springs or dampers -----------------------------------------


def with_speed(scene: Scene, factor: float) -> Scene:
    """Multiply the start's velocities and the speed of all motions by a factor. Gravity and forces stay."""
    moving = any(any(body.velocity) or any(body.angular_velocity) for body in scene.bodies)
    if not (moving or scene.motions or any(any(joint.speed.values()) for joint in scene.joints)):
        what = "the scene starts at rest and has no motions: there is no speed to vary"
        raise InputError(Problem(what, hint="give a joint a 'speed', or a body a 'velocity'"))

    def faster(vector: Vector) -> Vector:
        x, y, z = vector
        return factor * x, factor * y, factor * z

    def driven(motion: Motion) -> Motion:
        return replace(motion, function=with_argument(motion.function, TIME, factor))

    return replace(
        scene,
        bodies=tuple(
            replace(body, velocity=faster(body.velocity), angular_velocity=faster(body.angular_velocity))
            for body in scene.bodies
        ),
        joints=tuple(
            replace(joint, speed={name: factor * value for name, value in joint.speed.items()})
            for joint in scene.joints
        ),
        motions=tuple(map(driven, scene.motions)),
    )


def with_stiffness(scene: Scene, factor: float) -> Scene:
    """Multiply every stiffness by a factor, also those of stops. Dampers, tables and functions stay."""
    return _with_laws(scene, "stiffness", factor)


def with_damping(scene: Scene, factor: float) -> Scene:
    """Multiply every damping by a factor. Springs, tables and functions stay."""
    return _with_laws(scene, "damping", factor)


def _with_laws(scene: Scene, of: str, factor: float) -> Scene:
    """Multiply the `stiffness` or the `damping` of every law, bushing and compliant stop by a factor. `of` names
    which."""
    limits = [limit.law for joint in scene.joints for limit in joint.limits.values()]
    if not any(_has(force, of) for force in scene.forces) and not any(_gives(law, of) for law in limits):
        what = f"no force of the scene has a '{of}' to vary"
        raise InputError(Problem(what, hint="add a spring_damper, or vary something else"))

    k, c = (factor, 1.0) if of == "stiffness" else (1.0, factor)

    def scaled(law: Law) -> Law:
        return replace(law, stiffness=k * law.stiffness, damping=c * law.damping)

    def stopping(law: StopLaw) -> StopLaw:
        damping = None if law.damping is None else c * law.damping
        return replace(law, stiffness=k * law.stiffness, damping=damping)

    def element(kind: Kind | None) -> Kind | None:
        if kind is None:
            return None
        names = _in_units(kind, of)
        return replace(kind, values={**kind.values, **{name: factor * kind.values[name] for name in names}})

    def limit(old: Limit) -> Limit:
        return replace(old, law=stopping(old.law))

    def changed(force: Force) -> Force:
        if isinstance(force, BodyForce):
            return force
        if isinstance(force, DistanceStop):
            return replace(force, limit=limit(force.limit))
        if isinstance(force, PlaneStop):
            return replace(force, law=stopping(force.law))
        if isinstance(force, JointForce):
            laws = {name: scaled(law) for name, law in force.laws.items()}
            return replace(force, laws=laws, element=element(force.element))
        if isinstance(force, Bushing):
            (k_t, k_r), (c_t, c_r) = force.stiffness, force.damping
            stiffness = scaled_matrix(k, k_t), scaled_matrix(k, k_r)
            return replace(force, stiffness=stiffness, damping=(scaled_matrix(c, c_t), scaled_matrix(c, c_r)))
        return replace(force, law=scaled(force.law), element=element(force.element))

    return replace(
        scene,
        forces=tuple(map(changed, scene.forces)),
        joints=tuple(
            replace(joint, limits={name: limit(old) for name, old in joint.limits.items()}) for joint in scene.joints
        ),
    )


def _gives(law: StopLaw, of: str) -> bool:
    """Whether a stop has a finite, positive stiffness, or damping."""
    value = getattr(law, of)
    return value is not None and 0.0 < value < math.inf


def _in_units(kind: Kind, of: str) -> list[str]:
    """The names of an element's numbers that are a stiffness, or a damping, by their units; torsional ones included."""
    able = (STIFFNESS, TORSION_STIFFNESS) if of == "stiffness" else (DAMPING, TORSION_DAMPING)
    units = element_type(kind.type).units
    return [
        name
        for name, value in kind.values.items()
        if isinstance(value, float) and dimension_of(units[name]) in able and value
    ]


def _has(force: Force, of: str) -> bool:
    """Whether a force has any stiffness, or damping."""
    if isinstance(force, BodyForce):
        return False
    if isinstance(force, Bushing):
        return any(any(row) for matrix in getattr(force, of) for row in matrix)
    if isinstance(force, DistanceStop | PlaneStop):
        return _gives(force.limit.law if isinstance(force, DistanceStop) else force.law, of)
    if force.element is not None:
        return bool(_in_units(force.element, of))
    laws = force.laws.values() if isinstance(force, JointForce) else [force.law]
    return any(getattr(law, of) > 0.0 for law in laws)


# --- Variants with uneven masses or moments of inertia ----------------------------------------------------------------
# Every second body, counted from the ground, is heavier.


def with_mass_ratio(scene: Scene, r: float) -> Scene:
    """Multiply mass and inertia by √r for bodies at an odd number of joints from the ground, and by 1/√r for the
    others."""
    return _alternating(
        scene,
        r,
        "mass",
        lambda body, factor: replace(body, mass=factor * body.mass, inertia=scaled_matrix(factor, body.inertia)),
    )


def with_inertia_ratio(scene: Scene, r: float) -> Scene:
    """Multiply only the inertia by √r for bodies at an odd number of joints from the ground, and by 1/√r for the
    others."""
    return _alternating(
        scene, r, "inertia", lambda body, factor: replace(body, inertia=scaled_matrix(factor, body.inertia))
    )


def _alternating(scene: Scene, r: float, what: str, changed: Callable[[Body, float], Body]) -> Scene:
    distance = joints_from_ground(scene)
    if len({number % 2 for number in distance.values()}) < 2:
        said = f"no two bodies are joined to each other: there is no {what} ratio between neighbours"
        raise InputError(Problem(said, hint="vary something else, 'step' for example"))
    factors = {name: r**0.5 if number % 2 else r**-0.5 for name, number in distance.items()}
    return replace(scene, bodies=tuple(changed(body, factors[body.name]) for body in scene.bodies))


def joints_from_ground(scene: Scene) -> dict[str, int]:
    """The number of joints on the shortest path from the ground to each body. In a group of bodies that is not joined
    to the ground, the first body counts as one joint away."""
    ways: dict[str, list[str]] = {name: [] for name in (GROUND, *(body.name for body in scene.bodies))}
    for joint in scene.joints:
        first, second = joint.bodies
        ways[first].append(second)
        ways[second].append(first)
    distance = {GROUND: 0}
    for start in (GROUND, *ways):
        waiting = deque([start])
        distance.setdefault(start, 1)
        while waiting:
            name = waiting.popleft()
            for other in ways[name]:
                if other not in distance:
                    distance[other] = distance[name] + 1
                    waiting.append(other)
    return {name: number for name, number in distance.items() if name != GROUND}
