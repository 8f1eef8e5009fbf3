"""Rules on values: turned into what the records hold, or Unfit; and rules on several values of a joint or marker."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping

from mbproj.scene.fields import inertia, rotations
from mbproj.scene.fields.containers import Complaint
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.records import Matrix, Pair, Quaternion, Vector
from mbproj.scene.text.suggestions import did_you_mean

#: A point or direction as read: one for both bodies, or one by body in its own axes.
Placed = Pair | Mapping[str, Vector]

#: The sine below which two axes count as parallel.
PARALLEL = 1e-9


def direction(vector: Vector) -> Vector:
    """The unit vector along `vector`."""
    found = rotations.unit(vector)
    if found is None:
        raise Unfit("is a zero vector", "a direction needs a length")
    x, y, z = found
    return (x, y, z)


def unit_quaternion(quaternion: Quaternion) -> Quaternion:
    """The quaternion over its norm."""
    found = rotations.unit(quaternion)
    if found is None:
        raise Unfit("is zero", "write [1, 0, 0, 0] for no rotation")
    w, x, y, z = found
    return (w, x, y, z)


def orientation_of(matrix: Matrix) -> Quaternion:
    """The quaternion of a rotation matrix."""
    error = rotations.orthonormality_error(matrix)
    if not error <= rotations.ORTHONORMAL:
        raise Unfit(f"is not orthonormal (off by {error:.2g})", "give 7 digits, or expressions like cos(30 deg)")
    if rotations.determinant(matrix) < 0:
        raise Unfit("is a reflection: its determinant is -1", "its columns are the body's axes, right-handed")
    return rotations.from_matrix(matrix)


def inertia_of(matrix: Matrix) -> Matrix:
    """The tensor, made exactly symmetric, of a body that can be."""
    symmetric = inertia.symmetric(matrix)
    if symmetric is None:
        raise Unfit("is not symmetric", "Ixy stands in row 1, column 2 and in row 2, column 1")
    reason = inertia.impossible(symmetric)
    if reason is not None:
        raise Unfit(reason, "it is about the centre of mass, in kg m^2")
    return symmetric


def different(names: tuple[str, ...]) -> tuple[str, ...]:
    """The names of different bodies or joints."""
    for at, name in enumerate(names):
        if name in names[:at]:
            count = {2: "two", 3: "three"}[len(names)]
            raise Unfit(f"names '{name}' twice", f"give {count} different ones")
    return names


def nonzero(number: float) -> float:
    """A number other than zero."""
    if number == 0.0:
        raise Unfit("is zero")
    return number


def tooth_count(number: float) -> float:
    """A whole number other than zero; its sign says which way the wheel turns."""
    if number == 0.0 or not number.is_integer():
        raise Unfit(
            f"has {number:g} for a number of teeth", "give a whole number; a negative one is an internal gear or a belt"
        )
    return number


def slot_count(number: float) -> float:
    """A whole number of slots, with room for a pin between them."""
    if number < 3.0 or not number.is_integer():
        raise Unfit(f"has {number:g} for a number of slots", "give a whole number, 3 or more")
    return number


def two_points(points: tuple[Vector, Vector]) -> Pair:
    """A pair of global points, the first in the first body, that are not the same."""
    if points[0] == points[1]:
        raise Unfit("are one point", "give two points, or use a spherical joint")
    return Pair(*points)


def two_axes(axes: tuple[Vector, Vector]) -> Pair:
    """A pair of global axes that span a plane."""
    if math.hypot(*rotations.cross(*axes)) <= PARALLEL:
        raise Unfit("are parallel", "the two axes must span a plane")
    return Pair(*axes)


def shared(vector: Vector) -> Pair:
    """One global vector for both bodies."""
    return Pair(vector, vector)


def pair_of(placed: Placed, bodies: tuple[str, str]) -> Pair:
    """The pair in the order of `bodies`; what only the first body has stands for both."""
    if isinstance(placed, Pair):
        return placed
    return Pair(placed[bodies[0]], placed.get(bodies[1], placed[bodies[0]]), local=True)


def of_these_bodies(
    key: str, alone: bool = False
) -> Callable[[tuple[str, str] | str, Placed | Vector], Iterator[Complaint]]:
    """A check that what is given by body under `key` is given for the bodies at hand (one or two), and no other; for
    the first of two `alone` where only that one has it."""

    def find(bodies: tuple[str, str] | str, placed: Placed | Vector) -> Iterator[Complaint]:
        wanted = (bodies,) if isinstance(bodies, str) else bodies[:1] if alone else bodies
        if not isinstance(placed, Mapping):
            return
        needs = f"it is given for {' and '.join(repr(name) for name in wanted)}"
        for name in placed:
            if name not in wanted:
                hint = did_you_mean(name, wanted) or needs
                yield Complaint((key, name), f"unexpected '{name}' in '{key}'", hint)
        for name in wanted:
            if name not in placed:
                yield Complaint((key,), f"'{key}' lacks '{name}'", needs)

    return find


def same_kind(point: str, key: str) -> Callable[[Placed, Placed], Iterator[Complaint]]:
    """A check that the points under `point` and the axes under `key` are both global or both by body."""

    def find(location: Placed, axes: Placed) -> Iterator[Complaint]:
        if isinstance(location, Pair) != isinstance(axes, Pair):
            kinds = ("global", "by body") if isinstance(axes, Pair) else ("by body", "global")
            yield Complaint(
                (key,),
                f"'{key}' is {kinds[0]} but '{point}' is {kinds[1]}",
                "give both as lists (global), or both by body in the bodies' axes",
            )

    return find


def not_along(key: str) -> Callable[[Placed | Vector, Placed | Vector], Iterator[Complaint]]:
    """A check that the direction under `key` is not along the joint's axis."""

    def by_body(given: Placed | Vector) -> Mapping[str, Vector]:
        if isinstance(given, Mapping):
            return given
        return {"": given.first if isinstance(given, Pair) else given}

    def find(axis: Placed | Vector, other: Placed | Vector) -> Iterator[Complaint]:
        first, second = by_body(axis), by_body(other)
        if any(math.hypot(*rotations.cross(first[name], x)) <= PARALLEL for name, x in second.items() if name in first):
            yield Complaint((key,), f"'{key}' is along the axis", "give a direction across it")

    return find
