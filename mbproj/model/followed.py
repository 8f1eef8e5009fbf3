"""Distances from curves: their feet, and the pieces of the curves on which they hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, TypeAlias

import numpy as np

from mbproj.base.arrays import Array, Numbers
from mbproj.functions.program import COORDINATE, Op, Program, apply, variable
from mbproj.functions.program_set import ProgramSet, flatten
from mbproj.joints.primitives.basic import Primitive
from mbproj.joints.primitives.coupling import Coupling
from mbproj.joints.primitives.plane_curves import FREE, Gap, Lap
from mbproj.joints.primitives.rope import Rope
from mbproj.joints.primitives.space_curves import BesideSecond
from mbproj.model.couplings import NO_FOLLOWERS, FollowedCurve, FollowedKind, Followers
from mbproj.model.primitive_set import PrimitiveSet, bind, bindings

#: The row that belongs to each program, and whether the foot is on the first (0) or the second (1) of two curves.
Rows: TypeAlias = "Mapping[int, tuple[int, int]]"


def compile_followers(
    joints: PrimitiveSet, laws: PrimitiveSet, stops: PrimitiveSet | None, coordinates: PrimitiveSet
) -> Followers:
    """Return the distances from curves among the joints' rows, the laws and the stops, and the coordinates whose sign
    is a switch."""
    places, knots = list[FollowedCurve](), list[Program]()
    for kind, bound in ((FollowedKind.ROW, joints), (FollowedKind.LAW, laws), (FollowedKind.STOP, stops)):
        if bound is None or not any(group.primitive.is_held for group in bound.groups):
            continue
        for member in bound.layout.members:
            if member.primitive.is_held:
                for second, curve in enumerate(_curves(member.primitive)):
                    places.append(FollowedCurve(kind, member.rows[0], second))
                    knots.append(curve.knots)
    for member in coordinates.layout.members:
        if isinstance(member.primitive, Rope) and member.primitive.watched:
            places.append(FollowedCurve(FollowedKind.COORDINATE, member.rows[0]))
            knots.append(Program(apply(Op.ABS, variable(COORDINATE))))
    return Followers(tuple(places), flatten(knots)) if places else NO_FOLLOWERS


def _curves(distance: Any) -> tuple[Any, ...]:
    return (distance.curve, distance.other) if isinstance(distance, Gap) else (distance.curve,)


def rows_on_branches(rows: PrimitiveSet, programs: ProgramSet, of: Rows, held: Array) -> PrimitiveSet:
    """Return the rows with the branches `held` of their switches, one for each instruction of the programs; `of` gives
    the row of each program."""
    members = bindings(rows)
    for program, (row, second) in of.items():
        at, branches = rows.layout.member[row], programs.branches(program, held)
        members[at] = replace(members[at], primitive=_on_branch(members[at].primitive, branches, second))
        if not isinstance(members[at].primitive, Coupling):
            for number, each in enumerate(members):
                if each.owner == members[at].owner and isinstance(each.primitive, Coupling | BesideSecond):
                    members[number] = replace(each, primitive=_on_branch(each.primitive, branches))
    return bind(members)


def feet(rows: PrimitiveSet, programs: ProgramSet, of: Rows, held: Array, places: Numbers) -> dict[int, float]:
    """Return the parameter of the foot, by program, of each row that follows a curve, on the branches `held`. `of`
    gives the row of each program; `places` (S, 3) are the points and vectors of the rows' slots."""
    by_program, on_pieces = {}, dict[int, Primitive]()
    for program, (row, second) in of.items():
        primitive = on_pieces.get(row, rows.layout.members[rows.layout.member[row]].primitive)
        on_pieces[row] = _on_branch(primitive, programs.branches(program, held), second)
    for program, (row, second) in of.items():
        distance: Any = on_pieces[row]
        foot = distance.foot(places[None, list(rows.layout.members[rows.layout.member[row]].slots)])
        by_program[program] = float(foot[0, second] if isinstance(distance, Gap) else foot[0])
    return by_program


def _on_branch(primitive: Any, branches: tuple[float, ...], second: int = 0) -> Primitive:
    """Return the primitive with its switches on these branches, one for each instruction of its function."""
    piece = FREE if np.isnan(branches[-1]) else int(branches[-1])
    if isinstance(primitive, Coupling):
        along = primitive.other
        if isinstance(along, Lap):
            return replace(primitive, other=along.on_piece(piece))
        return primitive.on_branches(branches)
    held: Primitive = primitive.on_pieces(second, piece) if isinstance(primitive, Gap) else primitive.on_piece(piece)
    return held
