"""Dry friction as arrays: what joints and stops resist sliding with."""

from __future__ import annotations

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.errors import Place
from mbproj.model.primitive_set import PrimitiveSet


@dataclass(frozen=True, eq=False)
class Frictions:
    """K dry frictions on scalar coordinates s, that stick as long as a force within their bounds holds them:

        sliding:  F = -sign(s') (sliding + (static - sliding) exp(-(s'/stribeck)²)) load
        sticking: s' = 0 with |F| <= static load

    `coordinates`: the s as primitives, K rows. `joint_coordinate` (K,): which of the system's coordinates s is, -1 for
    none of them. `sliding` and `static` (K,): in N or N m, or coefficients of the load of the bearing `bearing` (K,),
    a number of `System.bearings`; -1 where the friction has no bearing: the load is 1. `stribeck` (K,) in m/s or rad/s:
    0 where friction falls to the sliding one as soon as it slides. `owners`: "force 'brake'", for messages; `places`:
    where each stands in the scene.

    At a stop there are two, along two tangents of its plane: `stop` (K,) is the number of the stop, whose push is the
    load, and `partner` (K,) the other tangent; -1 for joints. Together they act against the velocity in the plane.
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

    @property
    def size(self) -> int:
        """K."""
        return len(self.sliding)

    def first(self, k: int) -> bool:
        """Whether a friction is that of a joint, or along the first of two tangents."""
        return bool(self.partner[k] < 0 or self.partner[k] > k)
