"""The points at which joints touch the curves that they follow."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Numbers, dot
from mbproj.constraints.curves.face import OnFace
from mbproj.constraints.curves.in_space import InSpace
from mbproj.constraints.curves.profile import OnCurve
from mbproj.constraints.curves.two_curves import TwoCurves
from mbproj.constraints.primitive import Primitive


def place(primitive: Primitive, x: Numbers, offset: float) -> Numbers:
    """Return the point at which a coordinate with these points and vectors (..., s, 3) touches its curve, (..., 3). For
    a plane curve the point is as deep as the point of the second body."""
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
