"""Whether two curves that touch overlap elsewhere, where no row of C prevents it."""

from __future__ import annotations

from typing import cast

import numpy as np

from mbproj.arrays import Array
from mbproj.constraints.curves.two_curves import ANGLE, Gap
from mbproj.dynamics.equations.kinematics import Pose
from mbproj.functions.curves.plane_curve import PlaneCurve
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


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
