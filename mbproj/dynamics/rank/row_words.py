"""Words for a row of C: its owner, and the direction along or about which it acts on body 2."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from mbproj.arrays import Array, cross
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.kinematics import Pose, attached, slots_of
from mbproj.model.primitive_set import PrimitiveSet
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


@dataclass(frozen=True)
class NamedRow:
    """A row of a joint or of a motion: its owner's name, and the direction it holds, as "along x" or "about [0.6, 0,
    0.8]"."""

    kind: str
    name: str
    holds: str


def name_rows(system: System, pose: Pose) -> list[NamedRow]:
    """Return a name for every row of C but the norm rows, in their order; directions are global, at this pose."""
    joints = [
        NamedRow("joint", system.names.joints[owner], holds)
        for owner, holds in zip(system.joints.owner, _directions(system.joints, pose), strict=True)
    ]
    return [*joints, *(NamedRow("motion", name, "") for name in system.names.motions)]


def rows_in_words(rows: Iterable[NamedRow], most: int | None = None) -> str:
    """Return rows in words, gathered by owner: "joint 'A' (along y, about x), motion 'm'"; at most `most` owners."""
    gathered: dict[tuple[str, str], list[str]] = {}
    for row in rows:
        gathered.setdefault((row.kind, row.name), []).append(row.holds)
    parts = [
        f"{kind} '{name}'" + (f" ({', '.join(held)})" if any(held) else "") for (kind, name), held in gathered.items()
    ]
    left = 0 if most is None else len(parts) - most
    return ", ".join(parts) if left <= 0 else ", ".join([*parts[:most], f"and {left} more"])


def direction(vector: Array) -> str:
    """Return a direction in words: x, y or z where it is one of these, else its components, regardless of sign."""
    unit = vector / np.linalg.norm(vector)
    for axis, name in enumerate("xyz"):
        if abs(unit[axis]) > 1.0 - THRESHOLDS.same_written:
            return name
    unit = unit * np.sign(unit[np.flatnonzero(np.abs(unit) > THRESHOLDS.rounded)[0]])
    return "[" + ", ".join(f"{round(part, 3) + 0.0:g}" for part in unit.tolist()) + "]"


def _directions(bound: PrimitiveSet, pose: Pose) -> list[str]:
    """Return, for each row, the direction along which body 2 would shift, or about which it would turn, to change
    it."""
    x = attached(pose, *slots_of(bound))
    gradient = bound.gradient_entries(x)
    on_body_2 = (bound.side[bound.entry_slot] == 2)[:, None]
    is_point = bound.is_point[bound.entry_slot, None]
    shift, turn = np.zeros((bound.size, 3)), np.zeros((bound.size, 3))
    np.add.at(shift, bound.entry_row, on_body_2 * is_point * gradient)
    np.add.at(turn, bound.entry_row, on_body_2 * (1.0 - is_point) * cross(x[bound.entry_slot], gradient))
    return [_direction_words(along, about) for along, about in zip(shift, turn, strict=True)]


def _direction_words(along: Array, about: Array) -> str:
    shifts, turns = (np.linalg.norm(vector) > THRESHOLDS.dependent for vector in (along, about))
    if shifts and turns:
        return f"along and about {direction(along)}"
    return f"along {direction(along)}" if shifts else f"about {direction(about)}" if turns else ""
