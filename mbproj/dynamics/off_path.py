"""Checks whether ropes lie on their sheaves in the order of their paths."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array
from mbproj.constraints.rope import Rope
from mbproj.dynamics.equations.kinematics import Pose, attached_velocity, pose_of, slots_of, twist_of
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

#: A complex step along the velocities.
TINY = 1e-30


class OffPath(NamedTuple):
    """A failure of the path of a rope, given by its `coordinate`: it has left a `circle`, or else a `span` between
    circles has vanished. Both count from 0; the other one is -1."""

    coordinate: int
    circle: int
    span: int


def drawn_in(system: System, q: Array, v: Array, h: float) -> OffPath | None:
    """Return the span that has almost vanished where a run cannot go on, at q, v (7n,); None without one. It is very
    short, or shortens so fast that it would not last for another h s."""
    bound = system.coordinates
    if not any(isinstance(group.primitive, Rope) for group in bound.groups):
        return None
    pose = pose_of(q)
    places = pose.places(bound)
    rates = attached_velocity(twist_of(pose, v), *slots_of(bound))
    for group in bound.groups:
        rope = group.primitive
        if not isinstance(rope, Rope):
            continue
        x = places[group.slots] + 1j * TINY * rates[group.slots]
        for row, moving in zip(group.rows[:, 0].tolist(), x, strict=True):
            for k in range(len(rope.directions)):
                left = rope.span(moving, k).λ
                least = THRESHOLDS.drawn_in * (abs(rope.radii[k]) + abs(rope.radii[k + 1]))
                if not left.real > max(least, -2.0 * h * left.imag / TINY):
                    return OffPath(row, -1, k)
    return None


def off_path(system: System, pose: Pose) -> OffPath | None:
    """Return the first failure of a rope's path at one pose; None where all ropes lie on their paths."""
    bound = system.coordinates
    for group in bound.groups:
        rope = group.primitive
        if not isinstance(rope, Rope):
            continue
        x = pose.places(bound)[group.slots]
        for row, places in zip(group.rows[:, 0].tolist(), x, strict=True):
            before = 0.0
            for k in range(len(rope.directions)):
                span = rope.span(places, k)
                curved = rope.radii[k] != 0.0 or rope.radii[k + 1] != 0.0
                if curved and not (span.h > 0.0 and abs(rope.turned(span, k)) <= THRESHOLDS.rope_turned):
                    return OffPath(row, -1, k)
                θ, radius = float(rope.direction(span, k)), rope.radii[k]
                if k and radius and not np.sign(radius) * (θ - before) >= -THRESHOLDS.off_sheave:
                    return OffPath(row, k, -1)
                before = θ
    return None
