"""Rules on single values, which convert them for the records or raise Unfit; rules on several values of an item."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping

from mbproj.cases import per_case
from mbproj.errors import did_you_mean
from mbproj.scene.fields import inertia, rotations
from mbproj.scene.fields.containers import Complaint
from mbproj.scene.fields.reading import Unfit
from mbproj.scene.records import Matrix, Pair, Quaternion, Vector

#: A point or direction as read: global for both bodies, or one by body in that body's axes.
Placed = Pair | Mapping[str, Vector]

#: The sine below which two axes count as parallel.
PARALLEL = 1e-9


def direction(vector: Vector) -> Vector:
    """The unit vector along `vector`."""
    unit_vector = rotations.unit(vector)
    if unit_vector is None:
        raise Unfit("is a zero vector", "a direction needs a length")
    x, y, z = unit_vector
    return (x, y, z)


def unit_quaternion(quaternion: Quaternion) -> Quaternion:
    """The quaternion divided by its norm. Raises Unfit where that is 0."""
    normalised = rotations.unit(quaternion)
    if normalised is None:
        raise Unfit("is zero", "write [1, 0, 0, 0] for no rotation")
    w, x, y, z = normalised
    return (w, x, y, z)


def orientation_of(matrix: Matrix) -> Quaternion:
    """The quaternion of a rotation matrix. Raises Unfit for another matrix."""
    error = rotations.orthonormality_error(matrix)
    if not error <= rotations.ORTHONORMAL:
        raise Unfit(f"is not orthonormal (off by {error:.2g})", "give 7 digits, or expressions like cos(30 deg)")
    if rotations.determinant(matrix) < 0:
        raise Unfit("is a reflection: its determinant is -1", "its columns are the body's axes, right-handed")
    return rotations.from_matrix(matrix)


def inertia_of(matrix: Matrix) -> Matrix:
    """The inertia tensor, made exactly symmetric. Raises Unfit where no body can have it."""
    symmetric = inertia.symmetric(matrix)
    if symmetric is None:
        raise Unfit("is not symmetric", "Ixy stands in row 1, column 2 and in row 2, column 1")
    reason = inertia.impossible(symmetric)
    if reason is not None:
        raise Unfit(reason, "it is about the centre of mass, in kg m^2")
    return symmetric


def different(names: tuple[str, ...]) -> tuple[str, ...]:
    """The names. Raises Unfit where one is repeated."""
    for at, name in enumerate(names):
        if name in names[:at]:
            count = {2: "two", 3: "three"}[len(names)]
            raise Unfit(f"names '{name}' twice", f"give {count} different ones")
    return names


def nonzero(number: float) -> float:
    """The number. Raises Unfit where it is zero."""
    if number == 0.0:
        raise Unfit("is zero")
    return number


def tooth_count(number: float) -> float:
    """The number of teeth, whose sign says which way the wheel turns. Raises Unfit where it is not whole, or zero."""
    if number == 0.0 or not number.is_integer():
        raise Unfit(
            f"has {number:g} for a number of teeth", "give a whole number; a negative one is an internal gear or a belt"
        )
    return number


def slot_count(number: float) -> float:
    """The number of slots. Raises Unfit where it is not whole, or leaves no room for a pin between them."""
    if number < 3.0 or not number.is_integer():
        raise Unfit(f"has {number:g} for a number of slots", "give a whole number, 3 or more")
    return number


def two_points(points: tuple[Vector, Vector]) -> Pair:
    """The pair of global points, the first on the first body. Raises Unfit where they are the same."""
    if points[0] == points[1]:
        raise Unfit("are one point", "give two points, or use a spherical joint")
    return Pair(*points)


@per_case
def _sine(first: Vector, second: Vector) -> float:
    """The sine of the angle between two unit vectors."""
    return math.hypot(*rotations.cross(first, second))


def two_axes(axes: tuple[Vector, Vector]) -> Pair:
    """The pair of global axes. Raises Unfit where they are parallel."""
    if _sine(*axes) <= PARALLEL:
        raise Unfit("are parallel", "the two axes must span a plane")
    return Pair(*axes)


def global_pair(vector: Vector) -> Pair:
    """The pair of one global vector for both bodies."""
    return Pair(vector, vector)


def pair_of(placed: Placed, bodies: tuple[str, str]) -> Pair:
    """The pair in the order of `bodies`; where only the first body has a vector, it stands for both."""
    if isinstance(placed, Pair):
        return placed
    return Pair(placed[bodies[0]], placed.get(bodies[1], placed[bodies[0]]), local=True)


def of_these_bodies(
    key: str, alone: bool = False
) -> Callable[[tuple[str, str] | str, Placed | Vector], Iterator[Complaint]]:
    """A check that a mapping by body under `key` has exactly the item's bodies, one or two. With `alone` it may have
    the first of two only."""

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
        if any(_sine(first[name], x) <= PARALLEL for name, x in second.items() if name in first):
            yield Complaint((key,), f"'{key}' is along the axis", "give a direction across it")

    return find
