"""Rows that couple coordinates, determined up to whole teeth or threads, and the curves that distances follow."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from mbproj.base.arrays import Array, Integers, Numbers, numbers
from mbproj.base.dataclass import dataclass
from mbproj.functions.program_set import OF_ROWS, ProgramSet, flatten
from mbproj.joints.primitives.basic import Primitive
from mbproj.model.primitive_set import Binding

if TYPE_CHECKING:
    from mbproj.functions.standard import Curve


class Toothed(NamedTuple):
    """A gear whose teeth load bearings. `joint`, `joints`, `coordinates`: the numbers of its joint, of the two wheels'
    joints and of the wheels' angles. `pressure_angle` is in rad."""

    joint: int
    joints: tuple[int, int]
    coordinates: tuple[int, int]
    teeth: tuple[float, float]
    pressure_angle: float


@dataclass(frozen=True, eq=False)
class Couplings:
    """k rows of the joints, each a weighted sum of coordinates. Subtracted from it are a function of the first
    coordinate, where the row has one, and a multiple of a period.

    `row` (k,): the number among the joints' rows. `period` (k,): one tooth in rad or one thread in m; 0 for none.
    `first` (k,): the first of a row's entries in `coordinate` (e,), numbers of the system's coordinates, and `weight`
    (e,). `program` (k,): the number of the function in `programs`, -1 for none. `growth` (k,): its increase in one
    turn. `rolls` (k,): whether the row is that of a roller on a curve; its lap, the period, and its turn have no common
    measure. `teeth`: the gears whose teeth load bearings.
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
        is_curved = self.program >= 0
        return list(zip(self.row[is_curved].tolist(), self.coordinate[self.first[is_curved]].tolist(), strict=True))

    def sums(self, coordinate: Numbers) -> Numbers:
        """Return the sums of the rows, without multiples of periods, (..., k), of the system's coordinates (...,
        nc)."""
        totals: Numbers = np.add.reduceat(self.weight * coordinate[..., self.coordinate], self.first, axis=-1)
        for k in np.flatnonzero(self.program >= 0).tolist():
            from mbproj.functions.series import constant_series, run

            s = coordinate[..., self.coordinate[self.first[k]]]
            turns = np.round(s / (2.0 * np.pi)) if self.growth[k] else 0.0 * s
            variables = [constant_series(0.0 * s), constant_series(s - 2.0 * np.pi * turns)]
            totals[..., k] -= run(self.programs, int(self.program[k]), variables)[0] + self.growth[k] * turns
        return totals

    def whole(self, rows: Numbers) -> Numbers:
        """Return the multiples of the periods that are nearest to the rows (..., k)."""
        period = np.where(self.period > 0.0, self.period, 1.0)
        periods: Numbers = np.where(self.period > 0.0, period * np.round(rows / period), 0.0)
        return periods

    def rolled(self, raw: Numbers, expected: Array, apart: Numbers) -> npt.NDArray[np.longdouble]:
        """Return the whole laps and turns of rollers on curves, (..., k), in metres. `raw` are the coordinates (...,
        nc) computed from the pose, without turns. `apart` (..., k): the sums of the `expected` coordinates minus the
        rows."""
        second = np.where(self.rolls, self.first + 1, self.first)
        roller, weight = self.coordinate[second], self.weight[second]
        turns = np.round((expected[..., roller] - raw[..., roller].real) / (2.0 * np.pi))
        turned = np.longdouble(2.0 * np.pi) * weight * turns
        period = np.where(self.period > 0.0, self.period, 1.0)
        laps = np.where(self.period > 0.0, np.round((apart.real - turned.astype(float)) / period), 0.0)
        return np.where(self.rolls, turned + np.longdouble(1.0) * period * laps, np.longdouble(0.0))


@dataclass(frozen=True, eq=False)
class Followers:
    """k distances from curves. `of`: their places among the rows of the joints, the laws and the stops. `programs`:
    functions of the foot's parameter, whose switches are the knots of the curves."""

    of: tuple[FollowedCurve, ...]
    programs: ProgramSet


class FollowedKind(IntEnum):
    """The list in which a followed distance stands: the rows of the joints, the laws, the stops, or the joint
    coordinates. A stop follows its curve while it touches. The kernel's loop handles that itself; elsewhere such a stop
    is a row or a law. Of the coordinates, those are followed whose sign is a switch: the length of rope that lies on a
    circle, which the rope may leave."""

    ROW = 0
    LAW = 1
    STOP = 2
    COORDINATE = 3


class FollowedCurve(NamedTuple):
    """A curve that a distance follows: the list (`kind`) and the number of the distance; of two curves that touch, the
    first (0) or the `second` (1)."""

    kind: FollowedKind
    number: int
    second: int = 0


NO_FOLLOWERS = Followers((), flatten([]))


@dataclass(frozen=True, eq=False)
class Touching:
    """Joints that follow curves: the number of the coordinate with the foot, and the distance of the profile to the
    left of the curve, in m, of each."""

    coordinate: tuple[int, ...]
    offset: tuple[float, ...]


def compile_couplings(rows: Sequence[Binding], coordinates: Sequence[Binding]) -> Couplings:
    """Return the coupling rows among the joints' rows; they share slots with the coordinates that they couple."""
    first = np.cumsum([0, *(binding.primitive.rows for binding in rows)])
    row, period, growth, length, coordinate, rolls = [], [], [], [], [], []
    functions: list[Curve | None] = []
    weight: list[float] = []
    for at, binding in zip(first.tolist(), rows, strict=False):
        if binding.primitive.follows != "coordinates":
            continue
        coupling: Any = binding.primitive
        row.append(at)
        period.append(coupling.period)
        growth.append(coupling.growth)
        rolls.append(coupling.rolls)
        functions.append(coupling.function)
        length.append(len(coupling.weights))
        weight += coupling.weights
        coordinate += [_coordinate(part, binding.slots[slots], coordinates) for part, _, slots in coupling.terms()]
    curved = np.array([each is not None for each in functions], dtype=bool)
    return Couplings(
        row=np.array(row, dtype=np.intp),
        period=np.array(period, dtype=float),
        first=np.cumsum([0, *length], dtype=np.intp)[:-1],
        coordinate=np.array(coordinate, dtype=np.intp),
        weight=numbers(weight),
        program=np.where(curved, np.cumsum(curved) - 1, -1),
        growth=np.array(growth, dtype=float),
        programs=flatten([each.program for each in functions if each is not None], OF_ROWS),
        rolls=np.array(rolls, dtype=bool),
    )


def _coordinate(part: Primitive, slots: Sequence[tuple[int, int, Array]], coordinates: Sequence[Binding]) -> int:
    """Return the number of the joint coordinate with this primitive on these points and vectors."""
    for number, binding in enumerate(coordinates):
        pairs = list(zip(slots, binding.slots, strict=False))
        same = type(binding.primitive) is type(part) and len(slots) == len(binding.slots)
        if same and all(one[0] == other[0] and np.array_equal(one[2], other[2]) for one, other in pairs):
            return number
    raise AssertionError("a row couples what is no joint coordinate")
