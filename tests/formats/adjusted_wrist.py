"""A spherical parallel wrist, three legs of three revolutes whose axes meet in one point, with rounded numbers."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from mbproj.formats.geometry import turn

CENTRE = np.array([0.1, 0.2, 0.3])
X, Y, Z = np.eye(3)


def wrist(digits: int, adjust: str = "") -> str:
    """The scene with all places and axes rounded to so many digits."""

    def written(vector):
        return "[" + ", ".join(f"{float(part):.{digits}f}" for part in vector) + "]"

    bodies = [("plate", CENTRE + 0.05 * Z)]
    joints = []
    for leg in range(3):
        R = turn(Z, 2 * np.pi * leg / 3)
        axes = (
            -R @ turn(Y, 0.5) @ Z,
            R @ turn(X, 0.3) @ turn(Y, 1.2) @ Z,
            R @ turn(Y, 0.9) @ Z,
        )
        chain = ("ground", f"p{leg}", f"d{leg}", "plate")
        for name, axis, arm, ends in zip("UWV", axes, (0.12, 0.1, 0.08), pairwise(chain), strict=True):
            place = written(CENTRE + arm * axis)
            joints.append(
                f"  {name}{leg}: {{type: revolute, bodies: [{', '.join(ends)}], location: {place}, "
                f"axis: {written(axis)}}}"
            )
        bodies += [(f"{word}{leg}", CENTRE + 0.05 * (axes[1] + axes[at])) for word, at in (("p", 0), ("d", 2))]
    rows = [f"  {name}: {{mass: 1, inertia: [0.01, 0.01, 0.01], position: {written(at)}}}" for name, at in bodies]
    asked = f", adjust_joints: {adjust}" if adjust else ""
    head = f"mbproj: 1\ngravity: [0, 0, -9.81]\nsimulation: {{duration: 0.2 s, step: 1 ms{asked}}}\n"
    return "\n".join([head + "bodies:", *rows, "joints:", *joints]) + "\n"
