"""Checks whether ropes lie on their sheaves in the order of their paths."""

from __future__ import annotations

from typing import NamedTuple, cast

import numpy as np

from mbproj.base.arrays import Array, Numbers
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.kinematics import Pose, attached_velocity, pose_of, slots_of, twist_of
from mbproj.functions.plane_curve import PlaneCurve
from mbproj.joints.primitives.plane_curves import ANGLE, Gap
from mbproj.joints.primitives.rope import Rope, Span
from mbproj.model.system import System

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


# --- Whether two curves that touch overlap elsewhere, where no row of C prevents it -----------------------------------


def overlapping(system: System, pose: Pose) -> str | None:
    """The first joint at one pose whose two curves overlap; None where there is none."""
    names = [system.names.joints[owner] for owner in system.joints.owner.tolist()]
    lifting = [name.rpartition(".")[0] for name in system.names.coordinates]
    for bound, owners in ((system.joints, names), (system.coordinates, lifting)):
        for member in bound.layout.members:
            if isinstance(member.primitive, Gap) and _overlap(member.primitive, pose.places(bound)[list(member.slots)]):
                return owners[member.rows[0]]
    return None


def _overlap(gap: Gap, x: Array) -> bool:
    """Whether some point of the second curve is on the wrong side of the first. Two closed convex curves outside each
    other touch at one point only, and never overlap."""
    first, second = (cast(PlaneCurve, curve) for curve in (gap.curve, gap.other))
    sides = ((gap.side, first), (gap.other_side, second))
    outside = all((side > 0.0) != curve.turns_left for side, curve in sides)
    if not (first.closed and second.closed) or (outside and len(first.runs) == len(second.runs) == 1):
        return False
    line, θ = x[4] - x[3], float(ANGLE.value(x[:3])[0])
    cosine, sine = np.cos(θ), np.sin(θ)
    points = second.places.point @ np.array([[cosine, sine], [-sine, cosine]]) + [x[0] @ line, x[1] @ line]
    s, piece = first.foot(points)
    c, c1, *_ = first.derivatives(s, piece)
    across = (c1[0] * (points[:, 1] - c[1]) - c1[1] * (points[:, 0] - c[0])) / np.hypot(*c1)
    return bool(np.any(gap.side * across - gap.reach < -THRESHOLDS.overlap * first.length))
