"""Given forces and torques over a run: they depend on time alone, and are computed from the scene again."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mbproj.animate.data.passages import carried
from mbproj.animate.data.series import XYZ, Group
from mbproj.animate.look.forces import LoadLook
from mbproj.animate.look.motion import Motion
from mbproj.arrays import Array
from mbproj.dynamics.equations.forces import given_vectors
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.model.system import System


def load_groups(system: System, looks: Sequence[LoadLook], motion: Motion) -> Iterator[tuple[Group, Array]]:
    """The group of all forces and that of all torques, with global components (T, 3w)."""
    if system.forces is None or not looks:
        return
    poses = [pose_of(q) for q in carried(system, motion)]
    vectors = np.array([given_vectors(system.forces, pose, t) for t, pose in zip(motion.time, poses, strict=True)])
    for torque, name, unit in ((False, "given force", "N"), (True, "given torque", "N m")):
        chosen = [at for at, look in enumerate(looks) if look.torque == torque]
        owners = tuple(looks[at].name for at in chosen)
        if owners:
            group = Group(name, "forces", owners, XYZ, (unit,) * len(owners), "")
            yield group, vectors[:, chosen].reshape(len(vectors), -1)
