"""Checks of a pose that no row of C makes: whether ropes lie on their sheaves in the order of their paths, and whether
two curves that touch at one point overlap at another. A run ends where a check fails.
"""

from __future__ import annotations

from typing import NamedTuple, cast

import numpy as np

from mbproj.base.arrays import Array, Integers, Numbers
from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.kinematics import Pose, attached_velocity, pose_of, slots_of, twist_of
from mbproj.functions.plane_curve import PlaneCurve
from mbproj.joints.primitives.plane_curves import ANGLE, Gap
from mbproj.joints.primitives.rope import Rope, Span
from mbproj.model.system import System

# --- Ropes ------------------------------------------------------------------------------------------------------------

#: The size of a complex step along the velocities: derivatives without round-off.
TINY = 1e-30


class OffPath(NamedTuple):
    """A failure of the path of a rope, given by its `coordinate`: it has left a `circle`, or else a `span` between
    circles has vanished. Both count from 0; the other one is -1."""

    coordinate: int
    circle: int
    span: int


def off_path(system: System, pose: Pose) -> OffPath | None:
    """Return the first failure of a rope's path at one pose; None where all ropes lie on their paths."""
    for rope, coordinates, slots in _ropes_of(system):
        for coordinate, x in zip(coordinates, pose.places(system.coordinates)[slots], strict=True):
            if (failure := _failure(rope, coordinate, x)) is not None:
                return failure
    return None


def _failure(rope: Rope, coordinate: int, x: Array) -> OffPath | None:
    """The first failure of one rope, with its points and vectors x (s, 3). A span fails where its circles overlap, or
    where it has turned so far that its angle may jump; a circle where the rope would have to wrap round it backwards.
    """
    direction_before = 0.0
    for span in _present(rope, x):
        radius = rope.radii[span.first]
        radii = abs(radius) + abs(rope.radii[span.last])
        if radii and not (radii**2 < span.D2 and abs(span.turn) <= THRESHOLDS.most_turned):
            return OffPath(coordinate, -1, span.first)
        direction = float(span.direction)
        wrap = np.sign(radius) * (direction - direction_before)
        if span.first and radius and not wrap >= -THRESHOLDS.same_written:
            return OffPath(coordinate, span.first, -1)
        direction_before = direction
    return None


def drawn_in(system: System, q: Array, v: Array, h: float) -> OffPath | None:
    """Return the span of a rope that has almost vanished at q, v (7n,), where a run cannot go on; None where no span
    has. Such a span is very short, or would vanish within 2 h s at its present rate."""
    ropes, bound = _ropes_of(system), system.coordinates
    if not ropes:
        return None
    pose = pose_of(q)
    places = pose.places(bound)
    rates = attached_velocity(twist_of(pose, v), *slots_of(bound))
    for rope, coordinates, slots in ropes:
        moving = places[slots] + 1j * TINY * rates[slots]
        for coordinate, x in zip(coordinates, moving, strict=True):
            for span in _present(rope, x):
                least = THRESHOLDS.drawn_in * (abs(rope.radii[span.first]) + abs(rope.radii[span.last]))
                if not span.λ.real > max(least, -2.0 * h * span.λ.imag / TINY):
                    return OffPath(coordinate, -1, span.first)
    return None


def _ropes_of(system: System) -> list[tuple[Rope, list[int], Integers]]:
    """The ropes whose length is a coordinate of the system. Equal ones are one entry, with the numbers of their k
    coordinates and the slots (k, s) of their points and vectors."""
    return [
        (group.primitive, group.rows[:, 0].tolist(), group.slots)
        for group in system.coordinates.groups
        if isinstance(group.primitive, Rope) and any(group.primitive.by_length)
    ]


def _present(rope: Rope, x: Numbers) -> list[Span]:
    """The straight parts that a rope has at one pose, in their order."""
    return [span for span in rope.spans(x) if span.runs is None or bool(span.runs)]


# --- Two curves that touch --------------------------------------------------------------------------------------------


def overlapping(system: System, pose: Pose) -> str | None:
    """The first joint at one pose whose two curves overlap; None where there is none."""
    joints = [system.names.joints[owner] for owner in system.joints.owner.tolist()]
    # Where the curves may lift off, the gap is no row but a coordinate, "joint.name".
    lifting = [name.rpartition(".")[0] for name in system.names.coordinates]
    for bound, names in ((system.joints, joints), (system.coordinates, lifting)):
        for member in bound.layout.members:
            if isinstance(member.primitive, Gap) and _overlap(member.primitive, pose.places(bound)[list(member.slots)]):
                return names[member.rows[0]]
    return None


def _overlap(gap: Gap, x: Array) -> bool:
    """Whether some point of the second curve is on the wrong side of the first. x (5, 3) are the axes u and w of the
    first curve, the axis of the second, and both origins. Two closed convex curves outside each other touch at one
    point only, and never overlap. Open curves are not checked."""
    first, second = (cast(PlaneCurve, curve) for curve in (gap.curve, gap.other))
    sides = ((gap.side, first), (gap.other_side, second))
    outside = all((side > 0.0) != curve.turns_left for side, curve in sides)
    if not (first.closed and second.closed) or (outside and len(first.runs) == len(second.runs) == 1):
        return False
    u, w = x[0], x[1]
    to_second, θ = x[4] - x[3], float(ANGLE.value(x[:3])[0])
    cosine, sine = np.cos(θ), np.sin(θ)
    # The points of the second curve in the axes of the first, (k, 2), and the distance of each to the left of it, (k,).
    points = second.places.point @ np.array([[cosine, sine], [-sine, cosine]]) + [u @ to_second, w @ to_second]
    s, piece = first.foot(points)
    c, tangent, *_ = first.derivatives(s, piece)
    across = tangent[0] * (points[:, 1] - c[1]) - tangent[1] * (points[:, 0] - c[0])
    distance = across / np.hypot(*tangent)
    return bool(np.any(gap.side * distance - gap.reach < -THRESHOLDS.overlap * first.length))
