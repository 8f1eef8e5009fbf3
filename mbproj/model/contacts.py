"""The mechanism for one combination of contacts. Rigid stops that touch and frictions that stick hold rows of C;
compliant stops that push and frictions that slide are laws.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import field, fields, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Flags, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import Place
from mbproj.base.registry import USUAL_IMPACT_LAW
from mbproj.functions.program import COORDINATE, RATE, Code, Instruction, Op, Program, apply, number, variable
from mbproj.functions.program_set import ProgramSet, flatten, joined
from mbproj.model.forces import Forces, Laws
from mbproj.model.primitive_set import Binding, PrimitiveSet, bind, bindings
from mbproj.model.system import System

# --- Laws of contacts -------------------------------------------------------------------------------------------------
# Laws of force that are added to those of the scene while stops touch and dry frictions slide.


@dataclass(frozen=True, eq=False)
class AddedLaw:
    """A force along a coordinate s: the value of the program `push`, times the load of the bearing number `bearing`
    (-1: 1).

    `joint_coordinate`, `loses`, `partner` and `sliding` mean the same as in `Laws`; `partner` counts from the first law
    added. `owner` is the name of the force, for messages. `apart`: whether a separate integral counts the energy it
    loses."""

    along: Binding
    joint_coordinate: int
    push: Program
    owner: str
    bearing: int = -1
    apart: bool = False
    partner: int = -1
    sliding: tuple[float, float] = (0.0, 0.0)
    loses: bool = True


def with_laws(before: Forces, added: Sequence[AddedLaw]) -> Forces:
    """Return the forces with the laws `added` after the laws that they have."""
    laws = before.laws
    along = [replace(law.along, owner=laws.size + at, offset=0.0) for at, law in enumerate(added)]
    none, owners = np.zeros(len(added)), tuple(law.owner for law in added)
    return replace(
        before,
        laws=Laws(
            coordinates=bind([*bindings(laws.coordinates), *along]),
            joint_coordinate=np.append(laws.joint_coordinate, [law.joint_coordinate for law in added]).astype(np.intp),
            stiffness=np.append(laws.stiffness, none),
            damping=np.append(laws.damping, none),
            free=np.append(laws.free, none),
            program=np.append(laws.program, len(before.programs.start) - 1 + np.arange(len(added))),
            loses=np.append(laws.loses, [law.loses for law in added]),
            bearing=np.append(laws.bearing, [law.bearing for law in added]).astype(np.intp),
            apart=np.append(laws.apart, [law.apart for law in added]),
            partner=np.append(laws.partner, [_behind(laws.size, law.partner) for law in added]).astype(np.intp),
            sliding=np.concatenate([laws.sliding, [law.sliding for law in added]]),
        ),
        programs=joined([before.programs, flatten([law.push for law in added])]),
        law_owners=(*before.law_owners, *owners),
        program_owners=(*before.program_owners, *owners),
    )


def _behind(count: int, number: int) -> int:
    """Return the number of an added law among all laws, of which `count` come before; -1 stays -1."""
    return count + number if number >= 0 else -1


# --- Bearings as arrays -----------------------------------------------------------------------------------------------
# The loads of joints, in proportion to which dry friction acts.


#: Terms of a sum of multipliers: the number of the joint, the number of its row from 0, and the factor of the
#: multiplier.
Parts: TypeAlias = "tuple[tuple[int, int, float], ...]"


@dataclass(frozen=True, eq=False)
class Bearings:
    """B loads on which dry frictions depend. A joint exerts the force F and the torque T on its body 2, at its point
    there. With z the joint's axis, a bearing with two supports at a distance ℓ carries

        load = preload + radial (|f₁| + |f₂|) + axial |F·z|,    f₁, f₂ = ½ (F - (F·z) z) ± (T × z)/ℓ.

    `joint` (B,): the number of the joint. `axis` (B, 3): z in the axes of body 2. `radial` and `axial` (B,): arms in m
    where the friction is a torque, factors (1 or 0) where it is a force. `length` ℓ (B,) in m, infinite where moments
    do not count. `preload` (B,) in N m or N.

    The push of a stop is a load of another kind: Σ part λ over its `parts` (B,), which are empty for bearings of
    joints. With `axial` 1 the load is |Σ part λ|, as for the pull of a rope.
    """

    joint: Integers
    axis: Array
    radial: Array
    axial: Array
    length: Array
    preload: Array
    parts: tuple[Parts, ...]

    @property
    def size(self) -> int:
        """B."""
        return len(self.joint)

    @property
    def is_of_rows(self) -> Flags:
        """Whether each load is a sum of multipliers, (B,)."""
        return np.array([len(each) > 0 for each in self.parts], dtype=bool)

    @property
    def is_push(self) -> Flags:
        """Whether each load is the push of a stop, (B,)."""
        return np.asarray(self.is_of_rows & (self.axial == 0.0))


# --- Dry friction of joints and stops as arrays -----------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Frictions:
    """K dry frictions on scalar coordinates s, which stick as long as a force within their bounds holds them:

        sliding:  F = -sign(s') (sliding + (static - sliding) exp(-(s'/stribeck)²)) load
        sticking: s' = 0 with |F| <= static load

    `coordinates`: the s as primitives, K rows. `joint_coordinate` (K,): the number of s among the system's coordinates,
    -1 for none of them. `sliding` and `static` (K,): in N or N m, or coefficients of the load of `bearing` (K,), a
    number of `System.bearings`; where that is -1 the load is 1. `stribeck` (K,) in m/s or rad/s: 0 where friction falls
    to `sliding` as soon as it slides. `owners`: "force 'brake'", for messages; `places`: the place of each in the
    scene.

    Where a friction changes in a run, its `sliding` and `static` are NaN. `varies` has functions of time and channels
    for both instead.

    At a stop there are two frictions, along two tangents of its plane: `stop` (K,) is the number of the stop, whose
    push is the load, and `partner` (K,) the friction along the other tangent; both are -1 for joints. Together they act
    against the velocity in the plane.
    """

    coordinates: PrimitiveSet
    joint_coordinate: Integers
    sliding: Array
    static: Array
    stribeck: Array
    bearing: Integers
    stop: Integers
    partner: Integers
    owners: tuple[str, ...]
    places: tuple[Place | None, ...]
    varies: Mapping[int, tuple[Program, Program]] = field(default_factory=dict)

    @cached_property
    def programs(self) -> ProgramSet:
        """The functions of the frictions that change: sliding and then static of each."""
        return flatten([program for pair in self.varies.values() for program in pair])

    def bound_of(self, k: int, programs: int) -> int:
        """Return the number of the program of a friction's static bound; -1 where the bound is a constant. The bounds
        are the last of the `programs` programs of the forces."""
        return programs - len(self.varies) + list(self.varies).index(k) if k in self.varies else -1

    @property
    def size(self) -> int:
        """K."""
        return len(self.sliding)

    def first(self, k: int) -> bool:
        """Whether a friction belongs to a joint, or acts along the first of two tangents."""
        return bool(self.partner[k] < 0 or self.partner[k] > k)


def changing(sliding: Program, static: Program, stribeck: float, way: float | None, part: float | None) -> Code:
    """Return the force of a friction that changes in a run: sliding with the sign `way`, or bearing the `part` at
    rest."""
    if way is None:
        return apply(Op.MULTIPLY, number(part or 0.0), static.code)
    if stribeck == 0.0 or static is sliding:
        return apply(Op.MULTIPLY, number(-way), sliding.code)
    falls = apply(Op.DIVIDE, variable(RATE), number(stribeck))
    falls = apply(Op.EXP, apply(Op.NEGATE, apply(Op.MULTIPLY, falls, falls)))
    more = apply(Op.MULTIPLY, apply(Op.SUBTRACT, static.code, sliding.code), falls)
    return apply(Op.MULTIPLY, number(-way), apply(Op.ADD, sliding.code, more))


# --- Stops as arrays --------------------------------------------------------------------------------------------------
# One-sided limits of coordinates.


@dataclass(frozen=True, eq=False)
class Stops:
    """S one-sided limits on scalar coordinates s: the gap g = side (s - bound) is never negative at a rigid stop. A
    compliant stop pushes while its penetration δ = -g is positive, with k δᵖ (1 + c δ') (Hunt & Crossley 1975). With a
    restitution it pushes with k δᵖ (1 + d δ' / √(δ'² + κ 2V/m)), where V is its energy and m the mass that it meets.

    `coordinates`: the s as primitives, S rows. `joint_coordinate` (S,): the number of s among the system's coordinates,
    so that an angle counts its turns; -1 for the distance of two points, or of a point from a plane. `side` (S,): 1 for
    a lower bound of s, -1 for an upper one; `bound` (S,) in m or rad. `stiffness` k (S,), in N or N m per m or rad to
    the power `exponent` p (S,): infinite for a rigid stop. `restitution` (S,): the ratio of the speeds after and before
    a free impact, NaN where the damping is given. `damping` c (S,) in s/m or s/rad, NaN where the restitution is given.
    `resistance` d, `softening` κ (S,) follow from the restitution.

    `owners`: "joint 'hinge'" or "force 'bumper'", for messages; `places`: the place of each in the scene. `impact_law`:
    the law of all rigid stops, by its name in `registry.IMPACT_LAWS`.
    """

    coordinates: PrimitiveSet
    joint_coordinate: Integers
    side: Array
    bound: Array
    stiffness: Array
    exponent: Array
    restitution: Array
    damping: Array
    resistance: Array
    softening: Array
    owners: tuple[str, ...]
    places: tuple[Place | None, ...]
    impact_law: str = USUAL_IMPACT_LAW

    @property
    def size(self) -> int:
        """S."""
        return len(self.side)

    def pushes_by(self, k: int, row: Array) -> float:
        """Return the coefficient of damping of stop k while it touches: c, or κ 2k / ((p + 1) m) for a stop with a
        restitution. 1/m is |N|² of its `row` N (f,) in coordinates in which the kinetic energy is ½|x|²."""
        if np.isnan(self.restitution[k]):
            return float(self.damping[k])
        return float(self.gives_by[k] * (row @ row))

    @property
    def gives_by(self) -> Array:
        """κ 2k / (p + 1) of compliant stops with a restitution, (S,); divided by the mass it is the coefficient of
        damping."""
        return 2.0 * self.softening * self.stiffness / (self.exponent + 1.0)

    @property
    def is_rigid(self) -> npt.NDArray[np.bool_]:
        """Whether each stop is rigid, (S,)."""
        return np.isinf(self.stiffness)


# --- The mechanism for one combination of contacts --------------------------------------------------------------------


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
    walls = {k: rubbing[0] for k, rubbing in rub.items() if len(rubbing) == 1 and rubbing[0] not in contacts.sliding}
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
    forces, varying = system.forces, frictions.varies
    names = tuple(_quoted_name(frictions.owners[k]) for k in varying)
    bounds = flatten([static for _, static in varying.values()])
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
    pushes, bearings, joints = push_numbers(system, contacts), system.bearings, len(system.names.joints)
    if not pushes:
        return bearings
    held = {stop: joints + at for at, stop in enumerate(contacts.held)}
    shares = (contacts.shares.get(stop, ((stop, 1.0),)) for stop in pushes)
    parts = tuple(tuple((held[at], 0, -float(stops.side[at]) * part) for at, part in each) for each in shares)
    none = np.zeros(len(pushes))
    first = np.full(len(pushes), joints, dtype=np.intp)
    pushing = Bearings(first, np.zeros((len(pushes), 3)), none, none, np.full(len(pushes), np.inf), none, parts)
    if bearings is None:
        return pushing
    arrays = [each.name for each in fields(Bearings) if each.name != "parts"]
    joined = {name: np.concatenate([getattr(bearings, name), getattr(pushing, name)]) for name in arrays}
    return Bearings(**joined, parts=bearings.parts + parts)


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
