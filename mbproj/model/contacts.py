"""The mechanism for one combination of contacts. Rigid stops that touch and frictions that stick hold rows of C;
compliant stops that push and frictions that slide are laws."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field, fields, replace

import numpy as np

from mbproj.dataclass import dataclass
from mbproj.errors import Place
from mbproj.functions.program import COORDINATE, RATE, Code, Instruction, Op, Program, apply, number, variable
from mbproj.functions.program_set import flatten, joined
from mbproj.model.added_laws import AddedLaw, with_laws
from mbproj.model.bearings import Bearings
from mbproj.model.frictions import Frictions, changing
from mbproj.model.primitive_set import Binding, PrimitiveSet, bind, bindings
from mbproj.model.stops import Stops
from mbproj.model.system import System

#: Added to δ² under the root of its power, so that its derivatives are finite at δ = 0.
TINY = 1e-60
#: The prefix of the name of a contact's row, before the name of its owner.
CONTACT_OF = "contact of "


@dataclass(frozen=True)
class Contacts:
    """The stops that touch and the dry frictions that stick or slide, by their numbers.

    Rigid stops that touch are `held`. Compliant stops are `pushing`, with the damping c of each in s/m or s/rad; for a
    stop with a restitution the number is κ 2k / ((p + 1) m), m the mass that it meets.

    Frictions that are `sliding` have the sign of s', or the component of the direction of sliding along their tangent.
    Frictions that are `stuck` hold this value of s. Frictions that are `bearing` rest without a row of C, because other
    rows hold them. They exert this part, -1 to 1, of their static force. Frictions in a plane that are `starting` to
    slide, or go `straight` to rest, are slow and keep their direction.

    Where rows of touching stops depend on each other, only some are held. `shares` gives pairs (held stop, part) for
    each such stop. Its push is Σ part × push, with the pushes that the held stops would have alone. Stops that are
    `idle` touch and do not push."""

    held: tuple[int, ...] = ()
    pushing: Mapping[int, float] = field(default_factory=dict)
    sliding: Mapping[int, float] = field(default_factory=dict)
    stuck: Mapping[int, float] = field(default_factory=dict)
    bearing: Mapping[int, float] = field(default_factory=dict)
    straight: frozenset[int] = frozenset()
    starting: frozenset[int] = frozenset()
    shares: Mapping[int, tuple[tuple[int, float], ...]] = field(default_factory=dict)
    idle: frozenset[int] = frozenset()

    @property
    def touching(self) -> list[int]:
        """The rigid stops that push."""
        return sorted({*self.held, *self.shares} - self.idle)

    @property
    def slow(self) -> frozenset[int]:
        """The frictions that slide in a plane and keep their direction."""
        return self.straight | self.starting


def at_walls(system: System, contacts: Contacts, closed: Iterable[int]) -> Contacts:
    """Return the contacts with the stops in `closed` held, where exactly one friction along a stop's coordinate sticks.
    The stop's row then replaces that of the friction."""
    stops, frictions = system.stops, system.frictions
    if stops is None or frictions is None or contacts.shares:
        return contacts
    along = stops.joint_coordinate
    rub = {k: [j for j in range(frictions.size) if 0 <= along[k] == frictions.joint_coordinate[j]] for k in closed}
    walls = {k: own[0] for k, own in rub.items() if len(own) == 1 and own[0] not in contacts.sliding}
    stuck = {j: at for j, at in contacts.stuck.items() if j not in walls.values()}
    bearing = {**contacts.bearing, **dict.fromkeys(walls.values(), 0.0)}
    return replace(contacts, held=tuple(sorted({*contacts.held, *walls})), stuck=stuck, bearing=bearing)


def in_contact(system: System, contacts: Contacts) -> System:
    """Return the mechanism with these contacts; the same system where nothing touches.

    Rows follow those of the joints: one for each held stop, then one for each stuck friction, each as a separate joint.
    Laws follow those of the scene: one for each pushing stop, then one for each friction that slides or bears a force.
    Each of these laws of frictions has an integral of the energy it loses."""
    stops, frictions, changed = system.stops, system.frictions, system
    rows, laws = list[_HeldRow](), list[AddedLaw]()
    if stops is not None:
        held = ((k, float(stops.bound[k])) for k in contacts.held)
        rows += [_HeldRow(stops.coordinates, k, at, stops.owners[k], stops.places[k]) for k, at in held]
        laws += _pushes(stops, contacts.pushing)
    if frictions is not None:
        stuck = contacts.stuck.items()
        rows += [_HeldRow(frictions.coordinates, k, at, frictions.owners[k], frictions.places[k]) for k, at in stuck]
        numbers = bearing_numbers(changed, frictions, contacts)
        laws += _frictions(frictions, numbers, contacts, len(laws))
    if stops is not None:
        changed = replace(changed, bearings=_with_pushes(changed, stops, contacts))
    if rows:
        changed = _holding(changed, rows)
    changed = replace(changed, forces=with_laws(changed.forces, laws)) if laws else changed
    return changed if frictions is None or not frictions.varies else _with_bounds(changed, frictions)


def _with_bounds(system: System, frictions: Frictions) -> System:
    """Return the system with the static bounds of changing frictions as the last programs of its forces."""
    forces, own = system.forces, frictions.varies
    names = tuple(_quoted_name(frictions.owners[k]) for k in own)
    bounds = flatten([static for _, static in own.values()])
    programs, owners = joined([forces.programs, bounds]), (*forces.program_owners, *names)
    return replace(system, forces=replace(forces, programs=programs, program_owners=owners))


def standing_on_stops(system: System, pushing: Mapping[int, float]) -> System:
    """Return the mechanism for equilibria and small motions, the same system without compliant stops. The compliant
    stops in `pushing` are laws of max(0, δ). The caller treats rigid stops."""
    stops = system.stops
    if stops is None or stops.is_rigid.all():
        return system
    laws, names, units = system.forces.laws.size, system.names.forces, system.names.force_units
    return replace(
        system,
        forces=with_laws(system.forces, list(_pushes(stops, pushing, one_sided=True))),
        names=replace(
            system.names,
            forces=(*names[:laws], *(system.names.stops[k] for k in pushing), *names[laws:]),
            force_units=(*units[:laws], *(system.names.stop_units[k] for k in pushing), *units[laws:]),
        ),
    )


@dataclass(frozen=True, eq=False)
class _HeldRow:
    """Row k of some coordinates, to be held at the value `at`."""

    coordinates: PrimitiveSet
    k: int
    at: float
    owner: str
    place: Place | None

    def binding(self, owner: int) -> Binding:
        """Return the constraint s - at = 0 as a binding. An angle is measured from `at`, so that it is 0 there and
        needs no count of turns."""
        (binding,) = bindings(self.coordinates, [self.k])
        if self.coordinates.is_length[self.k]:
            return replace(binding, owner=owner, offset=binding.offset + self.at)
        (body, side, x), (_, _, y), last = binding.slots
        cosine, sine = np.cos(self.at), np.sin(self.at)
        turned = (body, side, cosine * x + sine * y), (body, side, cosine * y - sine * x)
        return replace(binding, owner=owner, slots=(*turned, last))


def _holding(system: System, held: list[_HeldRow]) -> System:
    joints = len(system.names.joints)
    rows = [row.binding(joints + at) for at, row in enumerate(held)]
    seats = [next(slot for slot in row.slots if slot[1] == 2) for row in rows]
    return replace(
        system,
        names=replace(system.names, joints=(*system.names.joints, *(f"{CONTACT_OF}{row.owner}" for row in held))),
        joints=bind([*bindings(system.joints), *rows]),
        reaction_body=np.append(system.reaction_body, [body for body, _, _ in seats]),
        reaction_local=np.vstack([system.reaction_local.reshape(-1, 3), *(local for _, _, local in seats)]),
        joint_places=(*system.joint_places, *(row.place for row in held)),
    )


def _pushes(stops: Stops, pushing: Mapping[int, float], *, one_sided: bool = False) -> Iterator[AddedLaw]:
    """The laws of stops that push; a one-sided law is zero by itself while its stop is open."""
    for k, by in pushing.items():
        (along,) = bindings(stops.coordinates, [k])
        push = _push(stops, k, by, one_sided)
        yield AddedLaw(along, int(stops.joint_coordinate[k]), Program(push), _quoted_name(stops.owners[k]))


def bearing_numbers(system: System, frictions: Frictions, contacts: Contacts) -> list[int]:
    """Return the number of the bearing on which each friction depends, in the mechanism with these contacts. For a
    friction at a held stop it is the push of the stop; -1 for none."""
    numbers: list[int] = frictions.bearing.tolist()
    pushes = push_numbers(system, contacts)
    return [pushes.get(stop, numbers[k]) for k, stop in enumerate(frictions.stop.tolist())]


def push_numbers(system: System, contacts: Contacts) -> dict[int, int]:
    """Return the number, among the bearings, of the push of each stop that rubs or shares its push."""
    first, frictions = 0 if system.bearings is None else system.bearings.size, system.frictions
    rubbed = {stop for stop in contacts.held if frictions is not None and stop in frictions.stop}
    return {stop: first + at for at, stop in enumerate(sorted({*rubbed, *contacts.shares}))}


def _with_pushes(system: System, stops: Stops, contacts: Contacts) -> Bearings | None:
    """Return the bearings of joints, followed by the pushes of stops, which consist of their `parts` alone."""
    pushes, own, joints = push_numbers(system, contacts), system.bearings, len(system.names.joints)
    if not pushes:
        return own
    held = {stop: joints + at for at, stop in enumerate(contacts.held)}
    shares = (contacts.shares.get(stop, ((stop, 1.0),)) for stop in pushes)
    parts = tuple(tuple((held[at], 0, -float(stops.side[at]) * part) for at, part in each) for each in shares)
    none = np.zeros(len(pushes))
    first = np.full(len(pushes), joints, dtype=np.intp)
    pushing = Bearings(first, np.zeros((len(pushes), 3)), none, none, np.full(len(pushes), np.inf), none, parts)
    if own is None:
        return pushing
    arrays = [each.name for each in fields(Bearings) if each.name != "parts"]
    joined = {name: np.concatenate([getattr(own, name), getattr(pushing, name)]) for name in arrays}
    return Bearings(**joined, parts=own.parts + parts)


def friction_laws(contacts: Contacts) -> list[int]:
    """Return the frictions that are laws, in the order of these laws."""
    return sorted((*contacts.sliding, *contacts.bearing))


def _frictions(frictions: Frictions, bearings: list[int], contacts: Contacts, first: int) -> Iterator[AddedLaw]:
    """The laws of frictions that slide or bear a force; `first` is the number of added laws before them."""
    order = friction_laws(contacts)
    for k in order:
        (along,) = bindings(frictions.coordinates, [k])
        static, sliding, partner = float(frictions.static[k]), float(frictions.sliding[k]), int(frictions.partner[k])
        varies = frictions.varies.get(k)
        other, direction = -1, (0.0, 0.0)
        if varies is not None:
            push = changing(*varies, float(frictions.stribeck[k]), contacts.sliding.get(k), contacts.bearing.get(k))
        elif k not in contacts.sliding:
            push = number(contacts.bearing[k] * static)
        elif k in contacts.slow:
            at_rest = static if frictions.stribeck[k] > 0.0 else sliding
            push = number(-contacts.sliding[k] * at_rest)
        elif partner in contacts.sliding:
            other, direction = first + order.index(partner), (contacts.sliding[k], contacts.sliding[partner])
            push = _falling(-sliding, -static, float(frictions.stribeck[k]))
        else:
            part = -contacts.sliding[k]
            push = _falling(part * sliding, part * static, float(frictions.stribeck[k]))
        coordinate, name = int(frictions.joint_coordinate[k]), _quoted_name(frictions.owners[k])
        yield AddedLaw(along, coordinate, Program(push), name, bearings[k], True, other, direction)


def _falling(sliding: float, static: float, stribeck: float) -> Code:
    """Return the code of sliding + (static - sliding) exp(-(s'/stribeck)²); of `sliding` without a Stribeck speed."""
    if stribeck == 0.0 or static == sliding:
        return number(sliding)
    part = apply(Op.DIVIDE, variable(RATE), number(stribeck))
    falls = apply(Op.EXP, apply(Op.NEGATE, apply(Op.MULTIPLY, part, part)))
    return apply(Op.ADD, number(sliding), apply(Op.MULTIPLY, number(static - sliding), falls))


def _quoted_name(owner: str) -> str:
    """Return the quoted name, as 'bumper' in "force 'bumper'"."""
    return owner.split("'")[1]


def _push(stops: Stops, k: int, by: float, one_sided: bool) -> Code:
    """Return the code of a stop's force along s: side k δᵖ max(0, 1 + c δ'), or with a restitution side k δᵖ (1 + d δ'
    / √(δ'² + r δᵖ⁺¹)). `by` is c or r. A one-sided law has max(0, δ) in place of δ."""
    side, bound, exponent = float(stops.side[k]), float(stops.bound[k]), float(stops.exponent[k])
    c, d = (by, 0.0) if np.isnan(stops.restitution[k]) else (0.0, float(stops.resistance[k]))
    depth = apply(Op.MULTIPLY, number(-side), apply(Op.SUBTRACT, variable(COORDINATE), number(bound)))
    depth = apply(Op.MAX, number(0.0), depth) if one_sided else depth
    push = apply(Op.MULTIPLY, number(side * float(stops.stiffness[k])), _power(depth, exponent))
    if c == d == 0.0:
        return push
    part = apply(Op.MULTIPLY, number(-side * (c or d)), variable(RATE))
    if c:
        return apply(Op.MULTIPLY, push, apply(Op.MAX, number(0.0), apply(Op.ADD, number(1.0), part)))
    elastic = apply(Op.MULTIPLY, number(by), _size(depth, exponent + 1.0))
    kinetic = apply(Op.ADD, apply(Op.MULTIPLY, variable(RATE), variable(RATE)), number(TINY))
    part = apply(Op.DIVIDE, part, apply(Op.SQRT, apply(Op.ADD, kinetic, elastic)))
    return apply(Op.MULTIPLY, push, apply(Op.ADD, number(1.0), part))


def _power(depth: Code, exponent: float) -> Code:
    """Return the code of δᵖ as δ (δ²)^((p - 1) / 2). Its derivatives stay finite where δ is 0 or, by round-off,
    below."""
    return depth if exponent == 1.0 else apply(Op.MULTIPLY, depth, _size(depth, exponent - 1.0))


def _size(depth: Code, exponent: float) -> Code:
    """Return the code of |δ|ᵖ."""
    square = apply(Op.ADD, apply(Op.MULTIPLY, depth, depth), number(TINY))
    return (*square, Instruction(Op.POWER, 0.5 * exponent))
