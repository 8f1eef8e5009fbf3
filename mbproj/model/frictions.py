"""Dry friction of joints and stops as arrays."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from functools import cached_property

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.errors import Place
from mbproj.functions.program import RATE, Code, Op, Program, apply, number, variable
from mbproj.functions.program_set import ProgramSet, flatten
from mbproj.model.primitive_set import PrimitiveSet


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
