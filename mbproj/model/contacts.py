"""A mechanism while some of its stops touch: rigid ones hold rows of C, compliant ones are laws."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.functions.program import COORDINATE, RATE, Code, Instruction, Op, Program, apply, number, variable
from mbproj.functions.program_set import ProgramSet, flatten
from mbproj.model.bushings import Bushings
from mbproj.model.forces import BodyForces, Forces, Laws
from mbproj.model.primitive_set import Binding, PrimitiveSet, bind
from mbproj.model.stops import Stops
from mbproj.model.system import System

#: Added to δ² under the root of its power, so that its derivatives are finite at δ = 0.
TINY = 1e-60


@dataclass(frozen=True)
class Contacts:
    """The stops that touch: rigid ones that are `held`, in their order; compliant ones that push, with the damping c
    of each in s/m or s/rad."""

    held: tuple[int, ...] = ()
    pushing: Mapping[int, float] = field(default_factory=dict)

    @property
    def any(self) -> bool:
        """Whether there are some."""
        return bool(self.held or self.pushing)


def in_contact(system: System, contacts: Contacts) -> System:
    """The mechanism with these contacts: after the joints' rows one for each stop that is held, as joints of their
    own; after the laws one for each that pushes. The same system where nothing touches."""
    assert system.stops is not None
    found = system
    if contacts.held:
        found = _holding(found, system.stops, contacts.held)
    if contacts.pushing:
        found = replace(found, forces=_pushed(found.forces, system.stops, contacts.pushing))
    return found


def standing_on_stops(system: System) -> System:
    """The mechanism for equilibria and small motions: compliant stops are laws k max(0, δ)ᵖ, with the damping that is
    given. The same system without any. Rigid ones are left to the caller."""
    stops = system.stops
    if stops is None or stops.is_rigid.all():
        return system
    soft = {int(k): 0.0 if np.isnan(c) else float(c) for k, c in enumerate(stops.damping) if not stops.is_rigid[k]}
    laws = 0 if system.forces is None else system.forces.laws.size
    names, units = system.names.forces, system.names.force_units
    return replace(
        system,
        forces=_pushed(system.forces, stops, soft, one_sided=True),
        names=replace(
            system.names,
            forces=(*names[:laws], *(system.names.stops[k] for k in soft), *names[laws:]),
            force_units=(*units[:laws], *(system.names.stop_units[k] for k in soft), *units[laws:]),
        ),
    )


def _holding(system: System, stops: Stops, held: Sequence[int]) -> System:
    joints = len(system.names.joints)
    rows = [_row(stops, k, joints + at) for at, k in enumerate(held)]
    names = tuple(f"stop of {stops.owners[k]}" for k in held)
    seats = [next(slot for slot in row.slots if slot[1] == 2) for row in rows]
    return replace(
        system,
        names=replace(system.names, joints=(*system.names.joints, *names)),
        joints=bind([*bindings(system.joints), *rows]),
        reaction_body=np.append(system.reaction_body, [body for body, _, _ in seats]),
        reaction_local=np.vstack([system.reaction_local.reshape(-1, 3), *(local for _, _, local in seats)]),
        joint_places=(*system.joint_places, *(stops.places[k] for k in held)),
    )


def _row(stops: Stops, k: int, owner: int) -> Binding:
    """s - bound = 0. An angle counts from the bound, so that it is 0 there and knows no turns."""
    (found,) = bindings(stops.coordinates, [k])
    bound = float(stops.bound[k])
    if stops.coordinates.is_length[k]:
        return replace(found, owner=owner, offset=found.offset + bound)
    (body, side, x), (_, _, y), last = found.slots
    cosine, sine = np.cos(bound), np.sin(bound)
    turned = (body, side, cosine * x + sine * y), (body, side, cosine * y - sine * x)
    return replace(found, owner=owner, slots=(*turned, last))


def bindings(bound: PrimitiveSet, rows: Sequence[int] | None = None) -> list[Binding]:
    """A set's primitives again as they were bound, in the order of their rows; of all, or of those with these first
    rows."""
    found = dict(_bindings(bound))
    return [found[row] for row in (sorted(found) if rows is None else rows)]


def _bindings(bound: PrimitiveSet) -> Iterator[tuple[int, Binding]]:
    for group in bound.groups:
        for slots, rows in zip(group.slots, group.rows, strict=True):
            taken = tuple((int(bound.body[s]), int(bound.side[s]), bound.local[s]) for s in slots)
            first = int(rows[0])
            yield first, Binding(group.primitive, int(bound.owner[first]), taken, float(bound.offset[first]))


def _pushed(forces: Forces | None, stops: Stops, pushing: Mapping[int, float], *, one_sided: bool = False) -> Forces:
    """The forces with a law for each stop that pushes; a law that is one-sided knows itself where it does."""
    before = forces or _nothing()
    laws, k = before.laws, list(pushing)
    programs = flatten([Program(_push(stops, stop, damping, one_sided)) for stop, damping in pushing.items()])
    added = np.zeros(len(k))
    own = [replace(each, owner=laws.size + at, offset=0.0) for at, each in enumerate(bindings(stops.coordinates, k))]
    return replace(
        before,
        laws=Laws(
            coordinates=bind([*bindings(laws.coordinates), *own]),
            joint_coordinate=np.append(laws.joint_coordinate, stops.joint_coordinate[k]),
            stiffness=np.append(laws.stiffness, added),
            damping=np.append(laws.damping, added),
            free=np.append(laws.free, added),
            program=np.append(laws.program, len(before.programs.start) - 1 + np.arange(len(k))),
            loses=np.append(laws.loses, np.ones(len(k), dtype=bool)),
        ),
        programs=_joined(before.programs, programs),
        law_owners=(*before.law_owners, *(_named(stops.owners[stop]) for stop in k)),
        program_owners=(*before.program_owners, *(_named(stops.owners[stop]) for stop in k)),
    )


def _named(owner: str) -> str:
    """The name in "force 'bumper'"."""
    return owner.split("'")[1]


def _push(stops: Stops, k: int, damping: float, one_sided: bool) -> Code:
    """The force along s: side k δᵖ max(0, 1 + c δ'); one-sided, with max(0, δ)."""
    side, bound = float(stops.side[k]), float(stops.bound[k])
    depth = apply(Op.MULTIPLY, number(-side), apply(Op.SUBTRACT, variable(COORDINATE), number(bound)))
    depth = apply(Op.MAX, number(0.0), depth) if one_sided else depth
    push = apply(Op.MULTIPLY, number(side * float(stops.stiffness[k])), _power(depth, float(stops.exponent[k])))
    if damping == 0.0:
        return push
    rate = apply(Op.MULTIPLY, number(-side * damping), variable(RATE))
    return apply(Op.MULTIPLY, push, apply(Op.MAX, number(0.0), apply(Op.ADD, number(1.0), rate)))


def _power(depth: Code, exponent: float) -> Code:
    """δᵖ, with finite derivatives where δ is 0 or, by round-off, below."""
    if exponent == 1.0:
        return depth
    square = apply(Op.ADD, apply(Op.MULTIPLY, depth, depth), number(TINY))
    return (*square, Instruction(Op.POWER, 0.5 * exponent))


def _joined(first: ProgramSet, second: ProgramSet) -> ProgramSet:
    """Two sets one after another; the second has no tables."""
    return replace(
        first,
        start=np.append(first.start, first.start[-1] + second.start[1:]),
        op=np.append(first.op, second.op),
        operand=np.append(first.operand, second.operand),
        texts=(*first.texts, *second.texts),
    )


def _nothing() -> Forces:
    none: Array = np.zeros(0)
    empty = np.zeros(0, dtype=np.intp)
    return Forces(
        laws=Laws(bind([]), empty, none, none, none, empty, np.zeros(0, dtype=bool)),
        bushings=Bushings.none(),
        on_bodies=BodyForces(
            empty,
            np.zeros((0, 3)),
            np.zeros(0, dtype=bool),
            np.zeros(0, dtype=bool),
            np.zeros((0, 3, 3)),
            np.zeros((0, 3), dtype=np.intp),
        ),
        programs=flatten([]),
        law_owners=(),
        program_owners=(),
        bushing_names=(),
    )
