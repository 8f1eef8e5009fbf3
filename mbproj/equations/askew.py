"""Axes that are nearly parallel: one that is tilted a little locks a mechanism of parallel axes."""

from __future__ import annotations

import numpy as np

from mbproj.base.thresholds import THRESHOLDS
from mbproj.equations.kinematics import Pose
from mbproj.model.system import System

#: Axes that are farther apart are meant to be, rad; and the number of parallel axes that make another one odd.
MOST, LEAST_ALIKE = np.radians(10.0), 3
#: The most axes that are compared.
COMPARED = 2000


def askew(system: System, pose: Pose) -> str:
    """Words on the joint whose axis is a little off those of the most joints that are parallel; "" where there is
    none."""
    aligned = system.alignment
    joint, first = np.unique(aligned.owner, return_index=True)
    if not LEAST_ALIKE < len(joint) <= COMPARED:
        return ""
    slot = np.array([aligned.layout.members[k].slots[0] for k in first])
    axes = pose.places(aligned)[slot]
    off = np.arcsin(np.minimum(np.linalg.norm(np.cross(axes[:, None], axes[None]), axis=-1), 1.0))
    alike = (off <= THRESHOLDS.same_written).sum(axis=1)
    most = int(np.argmax(alike))
    tilted = np.flatnonzero((off[most] > THRESHOLDS.same_written) & (off[most] <= MOST))
    if alike[most] < LEAST_ALIKE or not 0 < len(tilted) < alike[most]:
        return ""
    worst = tilted[np.argmax(off[most][tilted])]
    name, angle = system.names.joints[joint[worst]], np.degrees(off[most][worst])
    return f"the axis of joint '{name}' is {angle:.3g} deg off those of {alike[most]} others, which are parallel"
