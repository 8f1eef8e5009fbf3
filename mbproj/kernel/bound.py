"""Primitives of a set, in space or in a plane, as the flat arrays that the kernel takes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers, contiguous, distinct_rows, numbers
from mbproj.constraints import Primitive, name_of
from mbproj.kernel import core
from mbproj.model.planar import PlanarSet
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from mbproj.constraints.rope import Rope
    from mbproj.functions.curves.plane_curve import PlaneCurve
    from mbproj.functions.curves.space_curve import SpaceCurve


class Bound(NamedTuple):
    """k instances in the order of their rows: kinds (k,), slots (k, s) and parameters (k, p) with zeros behind those of
    smaller ones, offsets, weights and owners (k,). Whether one `joins` the row of the instance before, (k,), and the
    `line` that it follows, (k,), or None; the `other` of two curves that touch, the `wire` of a curve in space, and the
    `path` of a rope, likewise. What the slots number: S attachments' bodies (S,), `is_point` (S,), local vectors
    (S, 3 or 2)."""

    kind: Integers
    slots: Integers
    parameters: Array
    offset: Array
    weight: Array
    joins: Integers
    line: npt.NDArray[np.object_]
    other: npt.NDArray[np.object_]
    wire: npt.NDArray[np.object_]
    path: npt.NDArray[np.object_]
    owner: Integers
    body: Integers
    is_point: Array
    local: Array

    def only(self, members: Integers) -> Bound:
        """Some of the instances, with the attachments that they use and no others."""
        own = {name: getattr(self, name)[members] for name in _OF_INSTANCES}
        used, place = np.unique(own["slots"], return_inverse=True)
        own["slots"] = place.reshape(own["slots"].shape)
        return self._replace(**own, **{name: getattr(self, name)[used] for name in ("body", "is_point", "local")})


#: What `Bound` has of each instance.
_OF_INSTANCES = ("kind", "slots", "parameters", "offset", "weight", "joins", "line", "other", "wire", "path", "owner")


class _Kernel(NamedTuple):
    """The kernel's primitives by name: number, count of slots, count of parameters. `slots` and `parameters` are the
    largest counts."""

    forms: Mapping[str, tuple[int, int, int]]
    slots: int
    parameters: int


@cache
def _kernel() -> _Kernel:
    """The primitives of the kernel. A coupling has none: it is the instances of its coordinates."""
    kernel = core()
    forms = [] if kernel is None else kernel.primitives()
    most = np.array([form[1:] for form in forms] or [(0, 0)]).max(axis=0, initial=1)
    return _Kernel({name: (at, *form) for at, (name, *form) in enumerate(forms)}, int(most[0]), int(most[1]))


def _number(kind: type[Primitive]) -> int:
    """The kernel's number of a primitive. Raises ValueError where the kernel takes other slots or parameters."""
    name = name_of(kind)
    number, slots, parameters = _kernel().forms[name]
    own = slots if kind.follows == "rope" else len(kind.slots)  # type: ignore[arg-type]  # a constant of the others
    if (own, len(kind.parameters)) != (slots, parameters):
        raise ValueError(f"the primitive '{name}' of the kernel takes {slots} slots and {parameters} parameters")
    return number


def without_form(system: System) -> str | None:
    """The class of a primitive that the kernel does not have; None where it has all of the system."""
    known = _kernel().forms
    sets = [system.joints, system.coordinates]
    sets += [each.coordinates for each in (system.forces.laws, system.stops, system.frictions) if each is not None]
    for primitive in {group.primitive for bound in sets for group in bound.groups}:
        for part, *_ in _terms(primitive):
            if name_of(type(part)) not in known:
                return type(part).__name__
    return None


def joined(parts: Sequence[Bound]) -> Bound:
    """Several sets as one. The numbers of slots and owners of each continue those of the set before."""
    slots, owners, attachments, owned = [], [], 0, 0
    for part in parts:
        slots.append(part.slots + attachments)
        owners.append(part.owner + owned)
        attachments += len(part.body)
        owned += int(part.owner.max(initial=-1)) + 1
    alike = [name for name in Bound._fields if name not in ("slots", "owner")]
    rest = {name: np.concatenate([getattr(part, name) for part in parts]) for name in alike}
    return Bound(slots=np.concatenate(slots), owner=np.concatenate(owners), **rest)


def bound_in_space(bound: PrimitiveSet) -> Bound:
    members = bound.layout.members
    first = np.array([member.rows[0] for member in members], dtype=np.intp)
    own = _instances([member.primitive for member in members], [member.slots[0] for member in members])
    return Bound(
        **own.columns,
        offset=np.where(own.columns["joins"], 0.0, bound.offset[first[own.member]]),
        owner=bound.owner[first[own.member]],
        body=bound.body,
        is_point=bound.is_point,
        local=bound.local,
    )


def bound_in_plane(bound: PlanarSet) -> Bound:
    own = _instances(bound.primitives, bound.first_slot.tolist())
    return Bound(
        **own.columns,
        offset=np.where(own.columns["joins"], 0.0, bound.offset[bound.row[own.member]]),
        owner=bound.owner[own.member],
        body=bound.body,
        is_point=bound.is_point,
        local=bound.local,
    )


class _Instances(NamedTuple):
    """The primitive of each instance, (k,), and the columns of `Bound` that come from the primitive."""

    member: Integers
    columns: dict[str, Any]


def _instances(primitives: Sequence[Primitive], first_slots: Sequence[int]) -> _Instances:
    """The instances of primitives: one each, and for a coupling one for each coordinate. Slots are consecutive."""
    code, slots, parameters, weight, joins, line, other, wire, path, member = [], [], [], [], [], [], [], [], [], []
    kernel = _kernel()
    for number, (primitive, first) in enumerate(zip(primitives, first_slots, strict=True)):
        for part, (own, factor, taken) in enumerate(_terms(primitive)):
            code.append(_number(type(own)))
            slots.append(_filled([*range(first + taken.start, first + taken.stop)], kernel.slots))
            parameters.append(_filled([getattr(own, name) for name in own.parameters], kernel.parameters))
            weight.append(factor)
            joins.append(part > 0)
            line.append(own.curve if own.follows in ("curve", "two curves") else None)
            other.append(own.other if own.follows == "two curves" else None)
            wire.append(own.curve if own.follows == "space curve" else None)
            path.append(own if own.follows == "rope" else None)
            member.append(number)
    columns = {
        "kind": np.array(code, dtype=np.int64),
        "slots": np.array(slots, dtype=np.int64).reshape(-1, kernel.slots),
        "parameters": numbers(parameters).reshape(-1, kernel.parameters),
        "weight": numbers(weight),
        "joins": np.array(joins, dtype=np.int64),
        "line": np.array([*line, None], dtype=object)[:-1],
        "other": np.array([*other, None], dtype=object)[:-1],
        "wire": np.array([*wire, None], dtype=object)[:-1],
        "path": np.array([*path, None], dtype=object)[:-1],
    }
    return _Instances(np.array(member, dtype=np.intp), columns)


def _filled(own: list[Any], length: int) -> list[Any]:
    """A list, filled with zeros up to this length."""
    return [*own, *[0] * (length - len(own))]


def _terms(primitive: Any) -> Iterable[tuple[Any, float, slice]]:
    """Each coordinate of a coupling, with its weight and its slots; another primitive as it is."""
    coupled: Iterable[tuple[Any, float, slice]] = [(primitive, 1.0, slice(0, len(primitive.slots)))]
    return primitive.terms() if primitive.follows == "coordinates" else coupled


def primitives(kind: Any, bodies: int, bound: Bound) -> Any:
    """The kernel's set of primitives. Points and vectors that several primitives use are stored once."""
    unique, place = distinct_rows(np.column_stack([bound.body, bound.is_point, bound.local]))
    slots = place[bound.slots] if len(place) else bound.slots
    return kind(
        bodies=bodies,
        body=unique[:, 0].astype(np.int64),
        is_point=unique[:, 1].astype(np.int64),
        local=contiguous(unique[:, 2:], dtype=float),
        kind=bound.kind.astype(np.int64),
        slots=np.ascontiguousarray(slots, dtype=np.int64),
        parameters=contiguous(bound.parameters, dtype=float),
        offset=contiguous(bound.offset, dtype=float),
        weight=contiguous(bound.weight, dtype=float),
        joins=bound.joins.astype(np.int64),
        **_lines(bound),
        **_paths(bound),
    )


def _lines(bound: Bound) -> dict[str, Any]:
    """The curves that instances follow, each once, and the number of each instance's, -1 for none."""
    number: dict[Any, int] = {}
    own = {
        name: np.array(
            [-1 if line is None else number.setdefault(line, len(number)) for line in column.tolist()], dtype=np.int64
        )
        for name, column in (("line", bound.line), ("other", bound.other))
    }
    wires: dict[Any, int] = {}
    wire = [-1 if each is None else wires.setdefault(each, len(wires)) for each in bound.wire.tolist()]
    own["wire"] = np.array(wire, dtype=np.int64)
    return {**own, "lines": [_line(each) for each in number], "wires": [_wire(each) for each in wires]}


def _path(rope: Rope) -> list[float]:
    """The path of a rope as numbers: radii, directions, weights of spans, lifts, and the length to subtract."""
    lifts = [float(k in rope.lifts) for k in range(len(rope.radii))]
    return [*rope.radii, *rope.directions, *rope.by_length, *rope.by_angle, *lifts, rope.wound]


def _paths(bound: Bound) -> dict[str, Any]:
    """The paths of ropes, and the number of each instance's, -1 for none."""
    own = [None if rope is None else _path(rope) for rope in bound.path.tolist()]
    number = np.where([each is not None for each in own], np.cumsum([each is not None for each in own]) - 1, -1)
    return {"path": np.asarray(number, dtype=np.int64), "paths": [each for each in own if each is not None]}


@lru_cache(maxsize=64)
def _wire(curve: SpaceCurve) -> Any:
    """The kernel's copy of a curve in space."""
    places, kernel = curve.places, core()
    assert kernel is not None
    rows = curve.coefficients.reshape(len(curve.pieces), -1)
    return kernel.SpaceCurve(
        pieces=np.column_stack([curve.starts, curve.origins, rows, curve.axes]),
        places=np.column_stack([places.s, places.piece, places.point, places.length]),
        end=curve.end,
        closed=curve.closed,
        passes=THRESHOLDS.most_passes,
        settled=curve.settled,
        reach=curve.reach,
    )


@lru_cache(maxsize=64)
def _line(curve: PlaneCurve) -> Any:
    """The kernel's copy of a curve."""
    arrays, places = curve.arrays, curve.places
    kernel = core()
    assert kernel is not None
    return kernel.PlaneCurve(
        pieces=np.column_stack(
            [arrays.start, arrays.origin, arrays.form, arrays.numbers.reshape(len(arrays.start), -1)]
        ),
        places=np.column_stack([places.s, places.piece, places.point, places.length, places.angle]),
        end=curve.end,
        closed=curve.closed,
        passes=THRESHOLDS.most_passes,
        settled=curve.settled,
        straight=THRESHOLDS.rounding,
        beyond=THRESHOLDS.place_turn,
        reach=curve.reach,
    )
