"""Motions as arrays: joint coordinates that are functions of time, one row of C each."""

from __future__ import annotations

from mbproj.arrays import Array, Integers
from mbproj.dataclass import dataclass
from mbproj.errors import Place
from mbproj.functions.program_set import ProgramSet
from mbproj.model.primitive_set import PrimitiveSet


@dataclass(frozen=True, eq=False)
class Motions:
    """k rheonomic rows s(q) - start - f(t) = 0 (Haug 1989, sect. 9.5).

    `rows`: the coordinates s as primitives, k rows; `joint_coordinate` (k,): which of the system's coordinates each is;
    `start` (k,): what the functions count from; `programs`: the f. `places`: where each stands in the scene file.
    """

    rows: PrimitiveSet
    joint_coordinate: Integers
    start: Array
    programs: ProgramSet
    places: tuple[Place | None, ...]
