"""The kernel's models of a System, in space or in a plane.

The kernel reads the fields of the system's own records by their names (`src/bind/models.cpp`). A model in a plane
has projections of some of them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache, lru_cache
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mbproj.base.arrays import Array, Integers, numbers
from mbproj.base.thresholds import THRESHOLDS, Thresholds, of_the_kernel
from mbproj.functions.program import CHANNELS
from mbproj.functions.program_set import ProgramSet
from mbproj.joints.primitives.basic import Primitive
from mbproj.joints.primitives.table import name_of
from mbproj.kernel import core
from mbproj.model.couplings import FollowedKind
from mbproj.model.euler_parameters import rotation_matrix
from mbproj.model.layout import Layout
from mbproj.model.planar.plane import PlanarSet, Plane
from mbproj.model.planar.reduction import bushings_in_plane, coordinates_in_plane, locals_in_plane
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import System

if TYPE_CHECKING:
    from mbproj.functions.plane_curve import PlaneCurve
    from mbproj.functions.space_curve import SpaceCurve
    from mbproj.model.contacts import Bearings


# --- Primitives of a set, in space or in a plane, as the kernel takes them --------------------------------------------


def by_name(record: Any, **projected: Any) -> dict[str, Any]:
    """The fields of a frozen record by name, some of them replaced by their projections."""
    return {name: getattr(record, name) for name in record.__dataclass_fields__} | projected


class Bound(NamedTuple):
    """k instances in the order of their rows: kinds and counts of slots (k,), parameters (k, p) with zeros behind those
    of smaller ones, offsets, weights and owners (k,). Whether one `joins` the row of the instance before, (k,). What
    each `follows`: a curve, two of them, a rope, or None.

    The slots of an instance are consecutive from its `first_slot` (k,). They number S attachments: bodies (S,),
    `is_point` (S,), local vectors (S, 3 or 2)."""

    kind: Integers
    slot_count: Integers
    first_slot: Integers
    parameters: Array
    offset: Array
    weight: Array
    joins: Integers
    follows: list[Any]
    owner: Integers
    body: Integers
    is_point: Array
    local: Array

    def only(self, members: Integers) -> Bound:
        """Some of the instances, with the attachments of all."""
        chosen = {name: getattr(self, name)[members] for name in _OF_INSTANCES}
        return self._replace(**chosen, follows=[self.follows[member] for member in members.tolist()])


#: The arrays of `Bound` with an entry for each instance.
_OF_INSTANCES = ("kind", "slot_count", "first_slot", "parameters", "offset", "weight", "joins", "owner")


@cache
def _forms() -> Mapping[str, tuple[int, int, int]]:
    """The kernel's primitives by name: number, count of slots, count of parameters. A coupling has none: it is the
    instances of its coordinates."""
    kernel = core()
    forms = [] if kernel is None else kernel.primitives()
    return {name: (at, *form) for at, (name, *form) in enumerate(forms)}


@cache
def _number(kind: type[Primitive]) -> int:
    """The kernel's number of a primitive. Raises ValueError where the kernel takes other parameters."""
    number, _, parameters = _forms()[_name(kind)]
    if len(kind.parameters) != parameters:
        raise ValueError(f"the primitive '{_name(kind)}' of the kernel takes {parameters} parameters")
    return number


def _name(kind: type[Primitive]) -> str:
    """The kernel's name of a primitive."""
    return kind.in_kernel or name_of(kind)


def without_form(system: System) -> str | None:
    """The class of a primitive that the kernel does not have; None where it has all of the system."""
    known = _forms()
    sets = [system.joints, system.coordinates]
    sets += [each.coordinates for each in (system.forces.laws, system.stops, system.frictions) if each is not None]
    for primitive in {group.primitive for bound in sets for group in bound.groups}:
        for part, *_ in _terms(primitive):
            if _name(type(part)) not in known:
                return type(part).__name__
    return None


def joined(parts: Sequence[Bound]) -> Bound:
    """Several sets as one. The numbers of slots of each continue those of the set before."""
    before = np.cumsum([0, *(len(part.body) for part in parts)])
    shifted = [part.first_slot + first for part, first in zip(parts, before.tolist(), strict=False)]
    alike = [name for name in Bound._fields if name not in ("first_slot", "follows")]
    rest = {name: np.concatenate([getattr(part, name) for part in parts]) for name in alike}
    return Bound(first_slot=np.concatenate(shifted), follows=[each for part in parts for each in part.follows], **rest)


def bound(primitive_set: PrimitiveSet | PlanarSet) -> Bound:
    """A set as the kernel takes it: an instance for each primitive, and for a coupling one for each coordinate."""
    primitives: Sequence[Primitive]
    if isinstance(primitive_set, PlanarSet):
        primitives, first = primitive_set.primitives, primitive_set.first_slot.tolist()
        row, owner = primitive_set.row, primitive_set.owner
    else:
        members = primitive_set.layout.members
        primitives, first = [member.primitive for member in members], [member.slots[0] for member in members]
        row = np.array([member.rows[0] for member in members], dtype=np.intp)
        owner = primitive_set.owner[row]
    width = max(parameters for *_, parameters in _forms().values())
    kind, slots, slot, parameters, weight, joins, follows, member = [], [], [], [], [], [], [], []
    for number, (primitive, start) in enumerate(zip(primitives, first, strict=True)):
        for part, (each, factor, taken) in enumerate(_terms(primitive)):
            names = each.parameters
            kind.append(_number(each.__class__))
            slots.append(len(each.slots))
            slot.append(start + taken)
            parameters.append([*(getattr(each, name) for name in names), *[0.0] * (width - len(names))])
            weight.append(factor)
            joins.append(part > 0)
            follows.append(_followed(each) if each.follows else None)
            member.append(number)
    of, are_joined = np.array(member, dtype=np.intp), np.array(joins, dtype=bool)
    return Bound(
        kind=np.array(kind, dtype=np.intp),
        slot_count=np.array(slots, dtype=np.intp),
        first_slot=np.array(slot, dtype=np.intp),
        parameters=numbers(parameters).reshape(-1, width),
        offset=np.where(are_joined, 0.0, primitive_set.offset[row[of]]),
        weight=numbers(weight),
        joins=are_joined,
        follows=follows,
        owner=owner[of],
        body=primitive_set.body,
        is_point=primitive_set.is_point,
        local=primitive_set.local,
    )


def _terms(primitive: Any) -> Iterable[tuple[Any, float, int]]:
    """Each coordinate of a coupling, with its weight and its first slot; another primitive as it is."""
    if primitive.follows != "coordinates":
        return ((primitive, 1.0, 0),)
    return [(each, weight, slots.start) for each, weight, slots in primitive.terms()]


def _followed(primitive: Any) -> Any:
    """What a primitive follows, as the kernel takes it."""
    if primitive.follows == "rope":
        return by_name(primitive)
    if primitive.follows == "two curves":
        return _line(primitive.curve), _line(primitive.other)
    return (_line if primitive.follows == "curve" else _wire)(primitive.curve)


@lru_cache(maxsize=64)
def _wire(curve: SpaceCurve) -> Any:
    """The kernel's copy of a curve in space."""
    kernel = core()
    assert kernel is not None
    return kernel.SpaceCurve(curve=curve, thresholds=THRESHOLDS)


@lru_cache(maxsize=64)
def _line(curve: PlaneCurve) -> Any:
    """The kernel's copy of a curve in a plane."""
    kernel = core()
    assert kernel is not None
    return kernel.PlaneCurve(curve=curve, thresholds=THRESHOLDS)


# --- The kernel's models of a System, in space or in a plane ----------------------------------------------------------


@cache
def _thresholds(core: ModuleType, thresholds: Thresholds) -> Any:
    """The thresholds of the kernel, as its class."""
    return core.Thresholds(**of_the_kernel(thresholds))


def programs(functions: ProgramSet, variables: int = CHANNELS) -> dict[str, Any]:
    """A set of functions of so many variables."""
    return by_name(functions, kinked=functions.kinked, variables=variables)


class _InSpace:
    """The quantities of a model in space, which are the system's own."""

    def __init__(self, system: System) -> None:
        self.system = system
        self.mass, self.inertia, self.gravity = system.mass, system.inertia, system.gravity
        self.constraints, self.coordinates = bound(system.rows), bound(system.coordinates)
        self.row_scale = system.row_scale[system.bodies :]

    def number(self, coordinate: Integers) -> Integers:
        """The numbers of joint coordinates; -1 for one that is constant, and for -1."""
        return coordinate

    def row(self, row: Integers) -> Integers:
        """The numbers of the joints' rows."""
        return row

    def along(self, coordinates: PrimitiveSet, joint_coordinate: Integers) -> Bound:
        """The `coordinates` along which forces or stops act, some of which are joint coordinates."""
        return bound(coordinates)

    def in_bodies(self, body: Integers, vectors: Array) -> Array:
        """Vectors in the axes of these bodies (k, 3) as the model has them."""
        return vectors

    def axes(self) -> Array:
        """The rotations (W, 3, 3) of the components of given forces."""
        on_bodies = self.system.forces.on_bodies
        return np.where(on_bodies.in_body[:, None, None], on_bodies.turn, np.eye(3))

    def bushings(self) -> dict[str, Array]:
        """What bushings have in place of the system's: rotations for Euler parameters."""
        return {"turn": rotation_matrix(self.system.forces.bushings.turn)}

    def bearings(self, bearings: Bearings) -> dict[str, Any]:
        """What bearings have beside or in place of the system's: body 2 and their points there."""
        joint = bearings.joint
        return {"body": self.system.reaction_body[joint], "point": self.system.reaction_local[joint]}


class _InPlane(_InSpace):
    """The projections of quantities in a plane."""

    def __init__(self, system: System, plane: Plane) -> None:
        self.system, self.plane = system, plane
        self.mass, self.inertia, self.gravity = plane.mass, plane.inertia, plane.gravity
        self.coordinates = bound(plane.coordinates)
        driven = self.coordinates.only(self.number(system.motions.joint_coordinate))
        last = len(system.names.joints)
        motions = driven._replace(owner=np.arange(last, last + system.driven))
        self.constraints = joined([bound(plane.joints), motions])
        self.row_scale = plane_row_scale(system, plane)

    def number(self, coordinate: Integers) -> Integers:
        return coordinates_in_plane(self.plane, coordinate)

    def row(self, row: Integers) -> Integers:
        rows = self.plane.rows.tolist()
        return np.array([rows.index(at) for at in row.tolist()], dtype=np.intp)

    def along(self, coordinates: PrimitiveSet, joint_coordinate: Integers) -> Bound:
        flat = bound(coordinates)._replace(local=locals_in_plane(self.plane, coordinates))
        number, count = self.number(joint_coordinate), len(self.coordinates.kind)
        return joined([self.coordinates, flat]).only(np.where(number >= 0, number, count + np.arange(coordinates.size)))

    def _reference(self, body: Integers) -> Array:
        """The rotations from the axes of bodies (k,) to those of the plane, at angle zero, (k, 3, 3)."""
        frames = np.concatenate([rotation_matrix(self.plane.reference), np.eye(3)[None]])
        turned: Array = self.plane.axes.T @ frames[body]
        return turned

    def in_bodies(self, body: Integers, vectors: Array) -> Array:
        return (self._reference(body) @ vectors[..., None])[:, :2, 0]

    def axes(self) -> Array:
        on_bodies = self.system.forces.on_bodies
        turn = self._reference(on_bodies.body) @ on_bodies.turn
        return np.where(on_bodies.in_body[:, None, None], turn, self.plane.axes.T)

    def bushings(self) -> dict[str, Array]:
        return bushings_in_plane(self.plane, self.system.forces.bushings)

    def bearings(self, bearings: Bearings) -> dict[str, Any]:
        """In the plane axial forces and moments are 0."""
        none = np.zeros((bearings.size, 2))
        axial, length = bearings.axial * bearings.is_of_rows, np.full(bearings.size, np.inf)
        return super().bearings(bearings) | {"point": none, "axis": none, "axial": axial, "length": length}


def space_record(core: ModuleType, system: System, layout: Layout) -> dict[str, Any]:
    """The record of the kernel's model of a system with six coordinates a body. The model has the joints with
    rows, in their order, and then each motion as a joint of one row."""
    return _record(core, _InSpace(system), layout)


def plane_record(core: ModuleType, system: System, plane: Plane, layout: Layout) -> dict[str, Any]:
    """The record of the kernel's model of a planar system, where `obstacle_in_plane` finds none. Its joints are
    those with rows in the plane, by `joints_with_rows`."""
    return _record(core, _InPlane(system, plane), layout)


def _record(core: ModuleType, seen: _InSpace, layout: Layout) -> dict[str, Any]:
    """The record of a model, which the kernel reads."""
    system, number = seen.system, seen.number
    couplings, motions, bearings, actions = system.couplings, system.motions, system.bearings, system.actions
    channels, is_state, variables = system.channels, system.channels.is_state, CHANNELS + system.channels.size
    return {
        "thresholds": _thresholds(core, system.thresholds),
        "mass": seen.mass,
        "inertia": seen.inertia,
        "gravity": seen.gravity,
        "constraints": seen.constraints,
        "row_scale": seen.row_scale,
        "coordinates": seen.coordinates,
        "length": system.length,
        "layout": [by_name(block) for block in layout.blocks],
        "loads": None if system.forces.is_empty else _loads(seen),
        "programs": programs(system.programs, variables),
        "first_rate": system.first_rate,
        "channels": by_name(
            channels, index=np.where(is_state, channels.index, number(np.where(is_state, -1, channels.index)))
        ),
        "switches": _switches(system.programs),
        "motions": by_name(motions, joint_coordinate=number(motions.joint_coordinate)),
        "couplings": by_name(
            couplings,
            row=seen.row(couplings.row),
            coordinate=number(couplings.coordinate),
            program=np.where(couplings.program >= 0, system.first_coupled + couplings.program, -1),
        ),
        "followers": _followers(seen),
        "flywheels": _flywheels(seen) if system.reflected.size else None,
        "contacts": _contacts(seen),
        "bearings": bearings and by_name(bearings, **seen.bearings(bearings)),
        "actions": by_name(actions, programs=programs(actions.programs, variables)) if actions.size else None,
    }


def _loads(seen: _InSpace) -> dict[str, Any]:
    """All forces but gravity."""
    forces = seen.system.forces
    laws, on_bodies, joint_coordinate = forces.laws, forces.on_bodies, forces.laws.joint_coordinate
    along, number = seen.along(laws.coordinates, joint_coordinate), seen.number(joint_coordinate)
    return {
        "laws": by_name(laws, coordinates=along, joint_coordinate=number),
        "on_bodies": by_name(on_bodies, point=seen.in_bodies(on_bodies.body, on_bodies.point), axes=seen.axes()),
        "bushings": by_name(forces.bushings, turns_freely=forces.bushings.turns_freely, **seen.bushings()),
    }


def _flywheels(seen: _InSpace) -> dict[str, Any]:
    """The reflected inertias, as flywheels that coordinates turn. The rates of coordinates that are constant are 0."""
    reflected = seen.system.reflected
    turned = np.flatnonzero(seen.number(reflected.joint_coordinate) >= 0)
    coordinates = seen.along(reflected.rows, reflected.joint_coordinate)
    return {"coordinates": coordinates.only(turned), "inertia": reflected.inertia[turned]}


def _contacts(seen: _InSpace) -> dict[str, Any] | None:
    """The coordinates of stops, and then those of dry friction, in m or rad, and the joint coordinates whose turns they
    count; None without either."""
    stops, frictions = seen.system.stops, seen.system.frictions
    parts = [each for each in (stops, frictions) if each is not None]
    if not parts:
        return None
    bounds = [] if stops is None else [stops.bound]
    bounds += [] if frictions is None else [np.zeros(frictions.size)]
    return {
        "coordinates": joined([seen.along(each.coordinates, each.joint_coordinate) for each in parts]),
        "joint_coordinate": seen.number(np.concatenate([each.joint_coordinate for each in parts])),
        "bound": np.concatenate(bounds),
    }


def _followers(seen: _InSpace) -> Integers:
    """The followers of curves: kind, number in its list, 1 on the second of two curves, and program, (k, 4). A
    coordinate that is constant in the plane has no sign to change."""
    following = seen.system.following
    followers = np.array([(*each, program) for program, each in following.items()], dtype=np.intp).reshape(-1, 4)
    for kind, number_in in ((FollowedKind.ROW, seen.row), (FollowedKind.COORDINATE, seen.number)):
        here = followers[:, 0] == kind
        followers[here, 1] = number_in(followers[here, 1])
    return followers[followers[:, 1] >= 0]


def _switches(functions: ProgramSet) -> Integers:
    """The switches of functions: their programs and instructions, (k, 2)."""
    if not functions.size:  # most scenes, which need not load what follows
        return np.zeros((0, 2), dtype=np.intp)
    from mbproj.functions.program_set import all_switches

    return np.array(all_switches(functions), dtype=np.intp).reshape(-1, 2)


def joints_with_rows(owner: Integers) -> list[int]:
    """The numbers of the joints that own these rows, ascending: the joints of the kernel's model."""
    return sorted({*owner.tolist()})


def plane_row_scale(system: System, plane: Plane) -> Array:
    """The scale of each row in the plane, (m,): of joints, then of motions."""
    scale = system.row_scale[system.bodies :]
    return np.concatenate([scale[plane.rows], scale[system.joints.size :]])
