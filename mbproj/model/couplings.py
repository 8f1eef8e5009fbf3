"""What has switches of its own: rows that couple, known but for whole teeth or threads, and what follows curves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import IntEnum
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

from mbproj.arrays import Array, Integers, Numbers
from mbproj.constraints.coupling import Coupling
from mbproj.constraints.curves.face import Face
from mbproj.constraints.curves.in_space import BesideCurve, BesideFirst, BesideSecond, SpaceCurve
from mbproj.constraints.curves.profile import FREE, Lap, PlaneCurve, Profile
from mbproj.constraints.curves.two_curves import Gap
from mbproj.constraints.primitive import Primitive
from mbproj.dataclass import dataclass
from mbproj.functions.curve import Curve
from mbproj.functions.program import Program
from mbproj.functions.program_set import OF_ROWS, ProgramSet, flatten
from mbproj.functions.series import constant_series, run
from mbproj.model.primitive_set import Binding, PrimitiveSet, bind, bindings

#: The primitives that are held on pieces of their curves.
DISTANCES = (Profile, Face, Gap, BesideFirst)


class Toothed(NamedTuple):
    """A gear whose teeth load bearings: its joint, those of its two wheels, the numbers of their angles, the numbers of
    teeth, and the pressure angle in rad."""

    joint: int
    joints: tuple[int, int]
    coordinates: tuple[int, int]
    teeth: tuple[float, float]
    pressure_angle: float


@dataclass(frozen=True, eq=False)
class Couplings:
    """k rows of the joints, each a sum of coordinates. Subtracted are a function of the first of them, where it has
    one, and a multiple of a period.

    `row` (k,) of the joints' rows; `period` (k,) one tooth in rad, or one thread in m; 0 for none. `first` (k,): where
    the entries of each begin, which are `coordinate` (e,), numbers of the system's coordinates, and `weight` (e,).
    `program` (k,): the number of the function in `programs`, -1 for none; `growth` (k,): what a turn adds to it.
    `rolls` (k,): whether it is a roller on a curve, whose lap, the period, and turn have no common measure. `teeth`:
    the gears whose teeth load bearings.
    """

    row: Integers
    period: Array
    first: Integers
    coordinate: Integers
    weight: Array
    program: Integers
    growth: Array
    programs: ProgramSet
    rolls: npt.NDArray[np.bool_]
    teeth: tuple[Toothed, ...] = ()

    @property
    def size(self) -> int:
        """k."""
        return len(self.row)

    @property
    def curved(self) -> list[tuple[int, int]]:
        """The row and the coordinate of each function, in the order of the programs."""
        own = self.program >= 0
        return list(zip(self.row[own].tolist(), self.coordinate[self.first[own]].tolist(), strict=True))

    def sums(self, coordinate: Numbers) -> Numbers:
        """Of the system's coordinates (..., nc), (..., k)."""
        found = np.asarray(np.add.reduceat(self.weight * coordinate[..., self.coordinate], self.first, axis=-1))
        for k in np.flatnonzero(self.program >= 0).tolist():
            s = coordinate[..., self.coordinate[self.first[k]]]
            turns = np.round(s / (2.0 * np.pi)) if self.growth[k] else 0.0 * s
            variables = [constant_series(0.0 * s), constant_series(s - 2.0 * np.pi * turns)]
            found[..., k] -= run(self.programs, int(self.program[k]), variables)[0] + self.growth[k] * turns
        return found

    def whole(self, rows: Numbers) -> Numbers:
        """The multiples of the periods that are nearest to (..., k)."""
        period = np.where(self.period > 0.0, self.period, 1.0)
        return np.asarray(np.where(self.period > 0.0, period * np.round(rows / period), 0.0))

    def rolled(self, raw: Numbers, expected: Array, apart: Numbers) -> npt.NDArray[np.longdouble]:
        """The laps and turns of rollers on curves, (..., k), in metres. `raw` are coordinates (..., nc) as the pose has
        them; `apart` (..., k): by how much the sums with those `expected` are more than the rows."""
        second = np.where(self.rolls, self.first + 1, self.first)
        roller, weight = self.coordinate[second], self.weight[second]
        turns = np.round((expected[..., roller] - raw[..., roller].real) / (2.0 * np.pi))
        turned = np.longdouble(2.0 * np.pi) * weight * turns
        period = np.where(self.period > 0.0, self.period, 1.0)
        laps = np.where(self.period > 0.0, np.round((apart.real - turned.astype(float)) / period), 0.0)
        return np.where(self.rolls, turned + np.longdouble(1.0) * period * laps, np.longdouble(0.0))


@dataclass(frozen=True, eq=False)
class Followers:
    """k distances from curves: `of`, their places among the rows of the joints, the coordinates of laws and those of
    stops; `programs`, of the parameter of the foot, whose switches are the knots of the curves."""

    of: tuple[Followed, ...]
    programs: ProgramSet

    @property
    def size(self) -> int:
        """k."""
        return len(self.of)


class Of(IntEnum):
    """Where a distance from a curve is: among the rows of the joints, the laws, or the stops. A stop follows its curve
    while it touches: the kernel's loop knows that itself, for all others it is a row or a law then."""

    ROW = 0
    LAW = 1
    STOP = 2


class Followed(NamedTuple):
    """A curve that is followed: by which distance, where that is and its number there; of two curves that touch, the
    first (0) or the `second` (1)."""

    kind: Of
    number: int
    second: int = 0


#: Rows of some programs: the number of each, and on which of two curves it has its foot.
Rows: TypeAlias = "Mapping[int, tuple[int, int]]"

NO_FOLLOWERS = Followers((), flatten([]))


@dataclass(frozen=True, eq=False)
class Touching:
    """Joints that follow curves: the number of a coordinate of each that has the foot, and how far the profile is to
    the left of the curve, in m."""

    coordinate: tuple[int, ...]
    offset: tuple[float, ...]


def compile_followers(joints: PrimitiveSet, laws: PrimitiveSet, stops: PrimitiveSet | None) -> Followers:
    """Those among the joints' rows, the laws and the stops."""
    places, knots = list[Followed](), list[Program]()
    for kind, bound in ((Of.ROW, joints), (Of.LAW, laws), (Of.STOP, stops)):
        if bound is None or not any(isinstance(group.primitive, DISTANCES) for group in bound.groups):
            continue
        for member in bound.layout.members:
            if isinstance(member.primitive, DISTANCES):
                for second, curve in enumerate(_curves(member.primitive)):
                    places.append(Followed(kind, member.rows[0], second))
                    knots.append(curve.knots)  # type: ignore[arg-type]  # what curves of scenes have
    return Followers(tuple(places), flatten(knots)) if places else NO_FOLLOWERS


def _curves(distance: Profile | Face | Gap | BesideFirst) -> tuple[PlaneCurve | SpaceCurve, ...]:
    return (distance.curve, distance.other) if isinstance(distance, Gap) else (distance.curve,)


def rows_on_branches(rows: PrimitiveSet, programs: ProgramSet, of: Rows, held: Array) -> PrimitiveSet:
    """Rows with the switches of some on the branches held, one for each instruction of the programs; `of`: the row of
    each program."""
    own = bindings(rows)
    for program, (row, second) in of.items():
        at, branches = rows.layout.member[row], programs.branches(program, held)
        own[at] = replace(own[at], primitive=_on_branch(own[at].primitive, branches, second))
        if not isinstance(own[at].primitive, Coupling):
            for number, each in enumerate(own):
                if each.owner == own[at].owner and isinstance(each.primitive, Coupling | BesideSecond):
                    own[number] = replace(each, primitive=_on_branch(each.primitive, branches))
    return bind(own)


def feet(rows: PrimitiveSet, programs: ProgramSet, of: Rows, held: Array, places: Numbers) -> dict[int, float]:
    """The parameter of the foot of each row that follows a curve, by its program `of` rows, on the branches held;
    `places` are those of the rows' slots, (S, 3)."""
    found, on_pieces = {}, dict[int, Primitive]()
    for program, (row, second) in of.items():
        own = on_pieces.get(row, rows.layout.members[rows.layout.member[row]].primitive)
        on_pieces[row] = _on_branch(own, programs.branches(program, held), second)
    for program, (row, second) in of.items():
        distance = on_pieces[row]
        assert isinstance(distance, DISTANCES)
        foot = distance.foot(places[None, list(rows.layout.members[rows.layout.member[row]].slots)])
        found[program] = float(foot[0, second] if isinstance(distance, Gap) else foot[0])
    return found


def _on_branch(primitive: Primitive, branches: tuple[float, ...], second: int = 0) -> Primitive:
    """A row with its switches on these branches, one for each instruction of its function."""
    piece = FREE if np.isnan(branches[-1]) else int(branches[-1])
    if isinstance(primitive, Coupling):
        along = primitive.other
        if isinstance(along, Lap):
            return replace(primitive, other=along.on_piece(piece))
        return primitive.on_branches(branches)
    assert isinstance(primitive, (*DISTANCES, BesideCurve))
    return primitive.on_pieces(second, piece) if isinstance(primitive, Gap) else primitive.on_piece(piece)


def compile_couplings(rows: Sequence[Binding], coordinates: Sequence[Binding]) -> Couplings:
    """Those among the joints' rows, which share their slots with the coordinates that they couple."""
    first = np.cumsum([0, *(binding.primitive.rows for binding in rows)])
    row, period, growth, length, coordinate, rolls = [], [], [], [], [], []
    functions: list[Curve | None] = []
    weight: list[float] = []
    for at, binding in zip(first.tolist(), rows, strict=False):
        if not isinstance(binding.primitive, Coupling):
            continue
        row.append(at)
        period.append(binding.primitive.period)
        growth.append(binding.primitive.growth)
        rolls.append(binding.primitive.rolls)
        functions.append(binding.primitive.function)  # type: ignore[arg-type]  # what `Element` rows have
        length.append(len(binding.primitive.weights))
        weight += binding.primitive.weights
        coordinate += [
            _coordinate(part, binding.slots[slots], coordinates) for part, _, slots in binding.primitive.parts()
        ]
    curved = np.array([each is not None for each in functions], dtype=bool)
    return Couplings(
        row=np.array(row, dtype=np.intp),
        period=np.array(period, dtype=float),
        first=np.cumsum([0, *length], dtype=np.intp)[:-1],
        coordinate=np.array(coordinate, dtype=np.intp),
        weight=np.array(weight),
        program=np.where(curved, np.cumsum(curved) - 1, -1),
        growth=np.array(growth, dtype=float),
        programs=flatten([each.program for each in functions if each is not None], OF_ROWS),
        rolls=np.array(rolls, dtype=bool),
    )


def _coordinate(part: Primitive, slots: Sequence[tuple[int, int, Array]], coordinates: Sequence[Binding]) -> int:
    """The number of the joint coordinate that is this part of a row, on these points and vectors."""
    for number, binding in enumerate(coordinates):
        pairs = list(zip(slots, binding.slots, strict=False))
        same = type(binding.primitive) is type(part) and len(slots) == len(binding.slots)
        if same and all(one[0] == other[0] and np.array_equal(one[2], other[2]) for one, other in pairs):
            return number
    raise AssertionError("a row couples what is no joint coordinate")
