"""Ropes: the tension of each portion, the length, and the wraps. A wheel that turns, or a sheave with friction, divides
a rope into portions."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from mbproj.base.arrays import Flags, Integers, Numbers, dot
from mbproj.equations.kinematics import Pose
from mbproj.equations.samples import Samples
from mbproj.joints.primitives.basic import Primitive
from mbproj.joints.primitives.plane_curves import OnCurve, OnFace, TwoCurves
from mbproj.joints.primitives.rope import Rope
from mbproj.joints.primitives.space_curves import InSpace
from mbproj.model.system import System


class Portion(NamedTuple):
    """The forces whose sum is the tension of a portion: the numbers of a `row` of the joints, of the `motion` of the
    whole rope, or of a `stop`; -1 for none. This `part` of the force of a `friction` on a sheave is added to the
    multiplier of the row."""

    row: int = -1
    motion: int = -1
    stop: int = -1
    friction: int = -1
    part: float = 0.0


@lru_cache(maxsize=64)
def portions(system: System) -> tuple[Portion, ...]:
    """Return the portions of all ropes, in the order of `names.tensions`."""
    listed, names = list[Portion](), system.names
    for name in names.tensions:
        rope, _, number = name.rpartition(".tension_")
        rows = np.flatnonzero(system.joints.owner == names.joints.index(rope))
        length = names.coordinates.index(f"{rope}.length")
        driven = np.flatnonzero(system.motions.joint_coordinate == length)
        if len(driven):  # the motion acts on the whole rope, and each portion but the last also has a row
            row = int(rows[int(number) - 1]) if int(number) <= len(rows) else -1
            listed.append(Portion(row=row, motion=int(driven[0])))
        elif len(rows):
            listed.append(_taut_portion(system, rope, rows, int(number)))
        else:
            assert system.stops is not None
            listed.append(Portion(stop=int(np.flatnonzero(_ends(system, length))[0])))
    return tuple(listed)


def _taut_portion(system: System, rope: str, rows: Integers, number: int) -> Portion:
    """Return portion `number`, from 1, of a taut rope. A row has one portion, or two where the rope rubs on a sheave,
    with half of the friction on either side."""
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
    """Whether each stop is an upper limit of this length; for a length without upper limits, whether it is a lower
    limit."""
    stops = system.stops
    assert stops is not None
    limits = stops.joint_coordinate == length
    return limits & (stops.side < 0.0) if np.any(limits & (stops.side < 0.0)) else limits


def on_paths(system: System, pose: Pose, samples: Samples, pushes: Callable[[], Numbers]) -> dict[str, Numbers]:
    """Return the tensions of ropes and the points of contact on curves, by dataset, where there are some."""
    datasets = {"ropes/tension": tensions(system, samples, pushes)} if system.names.tensions else {}
    touching = system.touching
    if touching is not None:
        members = system.coordinates.layout.members
        x, columns = pose.places(system.coordinates), []
        for number, offset in zip(touching.coordinate, touching.offset, strict=True):
            member = members[system.coordinates.layout.member[number]]
            columns.append(contact_point(member.primitive, x[..., list(member.slots), :], offset))
        datasets["curves/contact"] = np.stack(columns, axis=-2)
    return datasets


def contact_point(primitive: Primitive, x: Numbers, offset: float) -> Numbers:
    """Return the point at which a coordinate with these points and vectors (..., s, 3) touches its curve, (..., 3).
    Along the normal of a plane curve its position is that of the second body's point."""
    if isinstance(primitive, InSpace):
        line = primitive.contact(x).line
        return np.asarray(x[..., 4, :] - (line[..., None] * x[..., :3, :]).sum(axis=-2))
    if isinstance(primitive, TwoCurves):
        feet = primitive.feet(x)
        curve = primitive.curve.derivatives(feet.s[..., 0], feet.piece[..., 0])[0]
        (u, w), t = curve, feet.t
    else:
        assert isinstance(primitive, OnCurve)
        at = primitive.contact(x)
        (u, w), t = at.c, at.t
    u, w = u - offset * t[1], w + offset * t[0]
    first = x[..., 3 if isinstance(primitive, OnFace | TwoCurves) else 2, :]
    normal = np.cross(x[..., 0, :], x[..., 1, :])
    depth = dot(normal, x[..., -1, :] - first)
    return np.asarray(first + u[..., None] * x[..., 0, :] + w[..., None] * x[..., 1, :] + depth[..., None] * normal)


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
            pulling = [at for at, number in ((row, row), (first + motion, motion)) if number >= 0]
            tension = multipliers[..., pulling].sum(axis=-1)
            columns.append(tension + part * rub[..., friction] if friction >= 0 else tension)
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
