"""Which components of the joints' reactions C determines: those that no forces in balance with themselves add to."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from mbproj.dynamics.kinematics import Pose
from mbproj.dynamics.observe import reactions
from mbproj.dynamics.self_stress import self_stresses
from mbproj.model.system import System

#: A component below this part of the largest is none.
NO_PART = 1e-8
Marks = npt.NDArray[np.bool_]


def indeterminate(system: System, pose: Pose) -> tuple[Marks, Marks]:
    """Components of each joint's reaction force and torque, (nj, 3) each, global axes, that are not unique at this
    pose: multipliers λ with Gᵀλ = 0 change them. None is where no row is redundant.

    A mechanism of blocks of more than `LARGE` bodies is taken to have no redundant rows there.
    """
    stresses = self_stresses(system, pose)
    force, torque = reactions(system, pose, stresses)
    largest = max(np.abs(force).max(initial=0.0) * system.length, np.abs(torque).max(initial=0.0))
    return (
        np.any(np.abs(force) * system.length > NO_PART * largest, axis=0),
        np.any(np.abs(torque) > NO_PART * largest, axis=0),
    )


def open_components(system: System, force: Marks, torque: Marks) -> dict[str, str]:
    """Marks of forces and torques (nj, 3) in words, by joint, as "Fy Tx Tz"; joints without any are left out."""
    words = {}
    for name, *marks in zip(system.names.joints, force, torque, strict=True):
        found = [kind + "xyz"[axis] for kind, part in zip("FT", marks, strict=True) for axis in np.flatnonzero(part)]
        if found:
            words[name] = " ".join(found)
    return words
