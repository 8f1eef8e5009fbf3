"""Given forces and torques over a run. They depend on time only, and are computed again from the scene."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import coordinate_values
from mbproj.dynamics.equations.forces import given_vectors
from mbproj.dynamics.equations.instant import Instant
from mbproj.dynamics.equations.kinematics import pose_of, twist_of
from mbproj.model.system import System
from mbproj.pages.appearance.forces import LoadLook
from mbproj.pages.appearance.motion import PoseHistory
from mbproj.pages.data.passages import carried
from mbproj.pages.data.series import XYZ, SeriesGroup


def load_groups(system: System, looks: Sequence[LoadLook], motion: PoseHistory) -> Iterator[tuple[SeriesGroup, Array]]:
    """The group of all given forces, and that of all given torques, each with its global components (T, 3w)."""
    if not looks:
        return
    if any(system.forces.programs.names_channels(index) for index in system.forces.on_bodies.program.ravel().tolist()):
        return
    instants = (_instant(system, float(t), q) for t, q in zip(motion.time, carried(system, motion), strict=True))
    vectors = np.array([given_vectors(instant) for instant in instants])
    for torque, name, unit in ((False, "given force", "N"), (True, "given torque", "N m")):
        chosen = [at for at, look in enumerate(looks) if look.torque == torque]
        owners = tuple(looks[at].name for at in chosen)
        if owners:
            group = SeriesGroup(name, "forces", owners, XYZ, (unit,) * len(owners), "")
            yield group, vectors[:, chosen].reshape(len(vectors), -1)


def _instant(system: System, t: float, q: Array) -> Instant:
    """The instant at which functions of time are evaluated."""
    pose = pose_of(q)
    return Instant(system, pose, twist_of(pose, np.zeros_like(q)), t, coordinate_values(system, pose))
