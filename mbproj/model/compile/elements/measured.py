"""Coordinates other than those of joints that elements name: coordinates of markers, distances, lengths of forces."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.constraints import PRIMITIVES
from mbproj.elements.element import Element, End, Place
from mbproj.errors import InputError, Problem, choose_from
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.primitive_set import Binding, bind, bindings
from mbproj.model.system import System

#: The coordinates of a marker: its distance from the ground's origin along each axis of the ground.
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
#: The owner of a coordinate that belongs to no joint.
NO_JOINT = -1
Slot = tuple[int, int, Array]


def with_measured(system: System, elements: Sequence[Element], read: Iterable[str] = ()) -> System:
    """Return the system with the coordinates added that elements or `read` name.

    These are "tip.x" of a marker, "rope.left" of an element's `lengths`, and "spring.length" of a force between two
    points. Raises InputError where a length names a marker that does not exist, or two points of one body."""
    able, known = measurable(system, elements), system.names.coordinates
    by_expressions = {name.replace("-", "_"): name for name in able}
    written = (*(name for element in elements for name in _coordinate_names(element)), *_measured(read))
    asked = (by_expressions.get(name, name) for name in written)
    added = {name: able[name] for name in dict.fromkeys(asked) if name in able and name not in known}
    if not added:
        return system
    names = replace(
        system.names,
        coordinates=(*known, *added),
        coordinate_units=(*system.names.coordinate_units, *("m" for _ in added)),
    )
    return replace(system, names=names, coordinates=bind([*bindings(system.coordinates), *added.values()]))


def _coordinate_names(element: Element) -> Iterator[str]:
    """The names of all coordinates that an element names, and the coordinate of each force that it reads."""
    yield from _measured(element.reads)
    yield from (force.along for force in element.forces)
    yield from (name for row in element.rows for name in row.of)
    yield from element.inertias


def _measured(read: Iterable[str]) -> Iterator[str]:
    """The names of the coordinates on which the names `read` may depend."""
    for name in read:
        yield name.removesuffix("_dot")
        yield f"{name.removesuffix('.force')}.length"


def measurable(system: System, elements: Sequence[Element]) -> dict[str, Binding]:
    """Return all coordinates that can be added, by name. Raises InputError as `with_measured` does."""
    ground, laws, able = system.bodies, system.forces.laws, dict[str, Binding]()
    for marker in system.names.markers:
        for axis, direction in AXES.items():
            slots = (ground, 1, np.array(direction)), (ground, 1, np.zeros(3)), _end(system, marker, 2)
            able[f"{marker}.{axis}"] = Binding(PRIMITIVES["along"](), NO_JOINT, slots)
    for name, index, bound in zip(system.names.forces, laws.joint_coordinate, bindings(laws.coordinates), strict=False):
        if index < 0:
            able[f"{name}.length"] = replace(bound, owner=NO_JOINT)
    for element in elements:
        for name, ends in element.lengths.items():
            able[f"{element.name}.{name}"] = _length(system, f"{element.name}.{name}", ends)
    return able


def _length(system: System, name: str, ends: tuple[End, End]) -> Binding:
    for end in ends:
        if isinstance(end, str) and end not in system.names.markers:
            what = f"the length '{name}' ends at the marker '{end}', which does not exist"
            raise InputError(Problem(what, hint=choose_from(end, system.names.markers)))
    first, second = (_end(system, end, side) for side, end in enumerate(ends, 1))
    if first[0] == second[0]:
        raise InputError(Problem(f"the length '{name}' has both ends on one rigid body", hint="name another marker"))
    return Binding(PRIMITIVES["distance"](), NO_JOINT, (first, second))


def _end(system: System, end: End, side: int) -> Slot:
    if isinstance(end, Place):
        body = system.names.bodies.index(end.body)
        own = system.body_offset[body] + rotation_matrix(system.body_turn[body]) @ np.array(end.location)
        return int(system.body_carrier[body]), side, own
    if not isinstance(end, str):
        return system.bodies, side, np.array(end)
    marker = system.names.markers.index(end)
    return int(system.marker_body[marker]), side, system.marker_local[marker]


def coordinate_of(system: System, element: Element, name: str) -> int:
    """Return the number of a coordinate. Raises InputError where it does not exist."""
    able = system.names.coordinates
    if name not in able:
        what = f"element '{element.name}' acts on '{name}', which does not exist"
        raise InputError(Problem(what, hint=choose_from(name, [*able, *measurable(system, [element])])))
    return able.index(name)
