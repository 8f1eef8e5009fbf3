"""Ropes: the tension of each portion, length and wraps. What turns or rubs has one on each side."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from mbproj.arrays import Flags, Integers, Numbers
from mbproj.constraints.rope import Rope
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.dynamics.observe.places import place
from mbproj.dynamics.observe.samples import Samples
from mbproj.model.system import System


class Portion(NamedTuple):
    """The forces that make a rope portion's tension: the numbers of a row of the joints, of a motion of the whole, or
    of a stop; -1 for the others. A `part` of the friction on a sheave comes to that of a row."""

    row: int = -1
    motion: int = -1
    stop: int = -1
    friction: int = -1
    part: float = 0.0


@lru_cache(maxsize=64)
def portions(system: System) -> tuple[Portion, ...]:
    """Return the portions of all ropes, in the order of `names.tensions`."""
    found, names = list[Portion](), system.names
    for name in names.tensions:
        rope, _, number = name.rpartition(".tension_")
        rows = np.flatnonzero(system.joints.owner == names.joints.index(rope))
        length = names.coordinates.index(f"{rope}.length")
        driven = np.flatnonzero(system.motions.joint_coordinate == length)
        if len(driven):  # the row of the whole, beside those of all portions but the last
            row = int(rows[int(number) - 1]) if int(number) <= len(rows) else -1
            found.append(Portion(row=row, motion=int(driven[0])))
        elif len(rows):
            found.append(_held(system, rope, rows, int(number)))
        else:
            assert system.stops is not None
            found.append(Portion(stop=int(np.flatnonzero(_ends(system, length))[0])))
    return tuple(found)


def _held(system: System, rope: str, rows: Integers, number: int) -> Portion:
    """One of the portions of a rope that is taut, counted from 1. Each row has one, or two where it rubs on a sheave:
    half of the friction is on either side of that."""
    rubs = {b: k for k, b in enumerate([] if system.frictions is None else system.frictions.bearing.tolist()) if b >= 0}
    parts = [] if system.bearings is None else system.bearings.parts
    owner = system.names.joints.index(rope)
    by_row = {row: rubs[b] for b, each in enumerate(parts) for joint, row, _ in each if joint == owner}
    listed = [
        Portion(row=row, friction=by_row.get(at, -1), part=part)
        for at, row in enumerate(rows.tolist())
        for part in ((-0.5, 0.5) if at in by_row else (0.0,))
    ]
    return listed[number - 1]


def _ends(system: System, length: int) -> Flags:
    """Whether each stop keeps a length from growing; where none does, whether it keeps it from shrinking."""
    stops = system.stops
    assert stops is not None
    own = stops.joint_coordinate == length
    return own & (stops.side < 0.0) if np.any(own & (stops.side < 0.0)) else own


def on_paths(system: System, pose: Pose, samples: Samples, pushes: Callable[[], Numbers]) -> dict[str, Numbers]:
    """Return the tensions of ropes and the points of contact on curves, by dataset, where there are some."""
    found = {"ropes/tension": tensions(system, samples, pushes)} if system.names.tensions else {}
    own = system.touching
    if own is not None:
        members = system.coordinates.layout.members
        x, columns = pose.places(system.coordinates), []
        for number, offset in zip(own.coordinate, own.offset, strict=True):
            member = members[system.coordinates.layout.member[number]]
            columns.append(place(member.primitive, x[..., list(member.slots), :], offset))
        found["curves/contact"] = np.stack(columns, axis=-2)
    return found


def tensions(system: System, samples: Samples, pushes: Callable[[], Numbers]) -> Numbers:
    """Return the tensions of all portions, (T, k), in N, positive where they pull. `pushes` returns those of stops, (T,
    S)."""
    multipliers = samples.multipliers
    first = multipliers.shape[-1] - system.driven
    columns = []
    rub = samples.rub()[0] if samples.rub is not None else np.zeros((len(multipliers), 0))
    for row, motion, stop, friction, part in portions(system):
        if stop >= 0:
            side = -1.0 if system.stops is None else float(system.stops.side[stop])
            columns.append(-side * pushes()[..., stop])
        else:
            held = [at for at, there in ((row, row), (first + motion, motion)) if there >= 0]
            own = multipliers[..., held].sum(axis=-1)
            columns.append(own + part * rub[..., friction] if friction >= 0 else own)
    return np.stack(columns, axis=-1)


def length_and_wraps(system: System, pose: Pose, name: str) -> tuple[float, list[float]]:
    """Return the length of a rope in m, without rope wound on drums at its ends, and its wrap in rad on each circle
    between."""
    bound = system.coordinates
    member = bound.layout.members[bound.layout.member[system.names.coordinates.index(f"{name}.length")]]
    rope = member.primitive
    assert isinstance(rope, Rope)
    x = pose.places(bound)[list(member.slots)]
    return float(rope.value(x)[0]), np.asarray(rope.wraps(x)).tolist()
