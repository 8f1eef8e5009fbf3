"""A scene k times as large that moves alike: lengths, velocities and gravity grow by k; times and masses stay.

Forces grow by k; torques, energies and moments of inertia grow by k². It is the same mechanism in another unit of
length: k = 1000 for millimetres.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from mbproj.dataclass import dataclass
from mbproj.elements import Kind
from mbproj.errors import InputError, Problem
from mbproj.functions.curves.track import SpaceTrack, Track
from mbproj.functions.program import COORDINATE, RATE, Program
from mbproj.joints import COORDINATE_UNITS, JOINTS
from mbproj.scene.blocks.control.known_names import names_channels
from mbproj.scene.blocks.elements import element_type
from mbproj.scene.blocks.ropes.path import Path
from mbproj.scene.coupled import Coupled
from mbproj.scene.fields.quantities import dimension_of
from mbproj.scene.friction import Bearing, DryFriction
from mbproj.scene.read import Scene
from mbproj.scene.records import (
    Body,
    BodyForce,
    Bushing,
    Force,
    Joint,
    JointForce,
    Law,
    Marker,
    Matrix,
    Motion,
    Pair,
    PointForce,
    Vector,
)
from mbproj.scene.stops import DistanceStop, Limit, OfBody, PlaneFriction, PlaneStop, StopLaw
from mbproj.studies.variants.programs import times, with_argument


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

    def vector(self, given: Vector) -> Vector:
        x, y, z = given
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
        own = {name: self._in(units.get(name, "m"), value) for name, value in joint.parameters.items()}
        return replace(
            joint,
            points=self.points(joint.points),
            start={name: self._unit(joint.name, name) * value for name, value in joint.start.items()},
            speed={name: self._unit(joint.name, name) * value for name, value in joint.speed.items()},
            parameters=own,
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

        def speed(given: float | None) -> float | None:
            return None if given is None else unit * given

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
