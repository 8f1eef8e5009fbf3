"""Primitives of a set, in space or in a plane, as the kernel takes them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from mbproj.arrays import Array, Integers, numbers
from mbproj.constraints import Primitive, name_of
from mbproj.kernel import core
from mbproj.model.planar import PlanarSet
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

if TYPE_CHECKING:
    from mbproj.functions.curves.plane_curve import PlaneCurve
    from mbproj.functions.curves.space_curve import SpaceCurve


def by_name(record: Any, **projected: Any) -> dict[str, Any]:
    """The fields of a frozen record by name, some of them replaced by their projections."""
    return {name: getattr(record, name) for name in record.__dataclass_fields__} | projected


class Bound(NamedTuple):
    """k instances in the order of their rows: kinds (k,), parameters (k, p) with zeros behind those of smaller ones,
    offsets, weights and owners (k,). Whether one `joins` the row of the instance before, (k,). What each `follows`: a
    curve, two of them, a rope, or None.

    The slots of an instance are consecutive from its `first_slot` (k,). They number S attachments: bodies (S,),
    `is_point` (S,), local vectors (S, 3 or 2)."""

    kind: Integers
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
_OF_INSTANCES = ("kind", "first_slot", "parameters", "offset", "weight", "joins", "owner")


@cache
def _forms() -> Mapping[str, tuple[int, int, int]]:
    """The kernel's primitives by name: number, count of slots, count of parameters. A coupling has none: it is the
    instances of its coordinates."""
    kernel = core()
    forms = [] if kernel is None else kernel.primitives()
    return {name: (at, *form) for at, (name, *form) in enumerate(forms)}


@cache
def _number(kind: type[Primitive]) -> int:
    """The kernel's number of a primitive. Raises ValueError where the kernel takes other slots or parameters."""
    name = name_of(kind)
    number, slots, parameters = _forms()[name]
    own = slots if kind.follows == "rope" else len(kind.slots)  # type: ignore[arg-type]  # a constant of the others
    if (own, len(kind.parameters)) != (slots, parameters):
        raise ValueError(f"the primitive '{name}' of the kernel takes {slots} slots and {parameters} parameters")
    return number


def without_form(system: System) -> str | None:
    """The class of a primitive that the kernel does not have; None where it has all of the system."""
    known = _forms()
    sets = [system.joints, system.coordinates]
    sets += [each.coordinates for each in (system.forces.laws, system.stops, system.frictions) if each is not None]
    for primitive in {group.primitive for bound in sets for group in bound.groups}:
        for part, *_ in _terms(primitive):
            if name_of(type(part)) not in known:
                return type(part).__name__
    return None


def joined(parts: Sequence[Bound]) -> Bound:
    """Several sets as one. The numbers of slots of each continue those of the set before."""
    before = np.cumsum([0, *(len(part.body) for part in parts)])
    shifted = [part.first_slot + first for part, first in zip(parts, before.tolist(), strict=False)]
    alike = [name for name in Bound._fields if name not in ("first_slot", "follows")]
    rest = {name: np.concatenate([getattr(part, name) for part in parts]) for name in alike}
    return Bound(first_slot=np.concatenate(shifted), follows=[each for part in parts for each in part.follows], **rest)


def bound(own: PrimitiveSet | PlanarSet) -> Bound:
    """A set as the kernel takes it: an instance for each primitive, and for a coupling one for each coordinate."""
    primitives: Sequence[Primitive]
    if isinstance(own, PlanarSet):
        primitives, first, row, owner = own.primitives, own.first_slot.tolist(), own.row, own.owner
    else:
        members = own.layout.members
        primitives, first = [member.primitive for member in members], [member.slots[0] for member in members]
        row = np.array([member.rows[0] for member in members], dtype=np.intp)
        owner = own.owner[row]
    width = max(parameters for *_, parameters in _forms().values())
    kind, slot, parameters, weight, joins, follows, member = [], [], [], [], [], [], []
    for number, (primitive, start) in enumerate(zip(primitives, first, strict=True)):
        for part, (each, factor, taken) in enumerate(_terms(primitive)):
            names = each.parameters
            kind.append(_number(each.__class__))
            slot.append(start + taken)
            parameters.append([*(getattr(each, name) for name in names), *[0.0] * (width - len(names))])
            weight.append(factor)
            joins.append(part > 0)
            follows.append(_followed(each) if each.follows else None)
            member.append(number)
    of, are_joined = np.array(member, dtype=np.intp), np.array(joins, dtype=bool)
    return Bound(
        kind=np.array(kind, dtype=np.intp),
        first_slot=np.array(slot, dtype=np.intp),
        parameters=numbers(parameters).reshape(-1, width),
        offset=np.where(are_joined, 0.0, own.offset[row[of]]),
        weight=numbers(weight),
        joins=are_joined,
        follows=follows,
        owner=owner[of],
        body=own.body,
        is_point=own.is_point,
        local=own.local,
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
