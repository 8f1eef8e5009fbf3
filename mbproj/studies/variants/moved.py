"""A scene turned and shifted as a whole, with gravity and forces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.scene.fields.rotations import from_matrix, multiply
from mbproj.scene.read import Scene
from mbproj.scene.records import Body, BodyForce, Bushing, Force, Joint, Marker, Orientations, Pair, PointForce, Vector
from mbproj.scene.stops import DistanceStop, OfBody, PlaneStop
from mbproj.studies.variants.programs import combined


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
            joints=tuple(map(self._joint, scene.joints)),
            markers=tuple(map(self._marker, scene.markers)),
            forces=tuple(map(self._force, scene.forces)),
        )

    def _direction(self, given: Vector) -> Vector:
        return _vector(self.rotation @ np.array(given))

    def _point(self, given: Vector) -> Vector:
        return _vector(self.rotation @ np.array(given) + self.shift)

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
            given = force.location
            location = given if given is None or force.local else self._point(given)
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
    kept = (pair.first, pair.second)
    ends = [new if name == "ground" else old for name, old, new in zip(holder.bodies, kept, moved, strict=True)]
    return Pair(ends[0], ends[1], local=True)


def _vector(values: Array) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _rows(matrix: Array) -> tuple[Vector, Vector, Vector]:
    first, second, third = (_vector(row) for row in matrix)
    return first, second, third
