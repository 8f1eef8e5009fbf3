"""Checks whether ropes lie on their sheaves in the order of their paths."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mbproj.arrays import Array, Numbers
from mbproj.constraints.rope import Rope, Span
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
    """Return the span of a rope that has almost vanished at q, v (7n,), where a run cannot go on; None where no span
    has. Such a span is very short, or would vanish within h s at its present rate."""
    bound = system.coordinates
    if not any(isinstance(group.primitive, Rope) for group in bound.groups):
        return None
    pose = pose_of(q)
    places = pose.places(bound)
    rates = attached_velocity(twist_of(pose, v), *slots_of(bound))
    for group in bound.groups:
        rope = group.primitive
        if not (isinstance(rope, Rope) and any(rope.by_length)):
            continue
        x = places[group.slots] + 1j * TINY * rates[group.slots]
        for row, moving in zip(group.rows[:, 0].tolist(), x, strict=True):
            for span in _running(rope, moving):
                least = THRESHOLDS.drawn_in * (abs(rope.radii[span.first]) + abs(rope.radii[span.last]))
                if not span.λ.real > max(least, -2.0 * h * span.λ.imag / TINY):
                    return OffPath(row, -1, span.first)
    return None


def off_path(system: System, pose: Pose) -> OffPath | None:
    """Return the first failure of a rope's path at one pose; None where all ropes lie on their paths."""
    bound = system.coordinates
    for group in bound.groups:
        rope = group.primitive
        if not (isinstance(rope, Rope) and any(rope.by_length)):
            continue
        x = pose.places(bound)[group.slots]
        for row, places in zip(group.rows[:, 0].tolist(), x, strict=True):
            before = 0.0
            for span in _running(rope, places):
                k, radius = span.first, rope.radii[span.first]
                radii = abs(radius) + abs(rope.radii[span.last])
                if radii and not (radii**2 < span.D2 and abs(span.turn) <= THRESHOLDS.most_turned):
                    return OffPath(row, -1, k)
                θ = float(span.direction)
                if k and radius and not np.sign(radius) * (θ - before) >= -THRESHOLDS.same_written:
                    return OffPath(row, k, -1)
                before = θ
    return None


def _running(rope: Rope, places: Numbers) -> list[Span]:
    """The straight parts that a rope has at one pose."""
    return [span for span in rope.spans(places) if span.runs is None or bool(span.runs)]
