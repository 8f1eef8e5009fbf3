"""Ropes: the tension of each portion, length and wraps. A wheel that turns with the rope has a portion on each side."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from mbproj.arrays import Flags, Numbers
from mbproj.constraints.rope import Rope
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.dynamics.observe.places import place
from mbproj.dynamics.observe.samples import Samples
from mbproj.model.system import System


class Portion(NamedTuple):
    """The force that is a rope portion's tension: the number of a row of the joints, a motion, or a stop; -1 for the
    others."""

    row: int = -1
    motion: int = -1
    stop: int = -1


@lru_cache(maxsize=64)
def portions(system: System) -> tuple[Portion, ...]:
    """Return the portions of all ropes, in the order of `names.tensions`."""
    found, names = list[Portion](), system.names
    for name in names.tensions:
        rope, _, number = name.rpartition(".tension_")
        rows = np.flatnonzero(system.joints.owner == names.joints.index(rope))
        length = names.coordinates.index(f"{rope}.length")
        driven = np.flatnonzero(system.motions.joint_coordinate == length)
        if len(rows):
            found.append(Portion(row=int(rows[int(number) - 1])))
        elif len(driven):
            found.append(Portion(motion=int(driven[0])))
        else:
            assert system.stops is not None
            found.append(Portion(stop=int(np.flatnonzero(_ends(system, length))[0])))
    return tuple(found)


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
    for row, motion, stop in portions(system):
        if stop >= 0:
            side = -1.0 if system.stops is None else float(system.stops.side[stop])
            columns.append(-side * pushes()[..., stop])
        else:
            columns.append(multipliers[..., row if row >= 0 else first + motion])
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
