"""Friction that depends on a reaction which is not unique: redundant rows can share the load in any proportion."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from mbproj.arrays import Array, Flags
from mbproj.dynamics.assembly.assemble import State
from mbproj.dynamics.equations.kinematics import Pose, pose_of
from mbproj.dynamics.observe.bearings import load, supports
from mbproj.dynamics.observe.reactions import reactions
from mbproj.dynamics.rank.nearby import nearby
from mbproj.dynamics.rank.row_space import self_stresses
from mbproj.errors import InputError, Problem
from mbproj.model.bearings import Bearings
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


def refuse_shared_loads(system: System, state: State) -> None:
    """Raises InputError that names each friction whose bearing shares its load with others, and with which."""
    if system.bearings is not None:
        problems = _problems(system, system.bearings, state.q.tobytes())
        if problems:
            raise InputError(list(problems))


@lru_cache(maxsize=64)
def _problems(system: System, bearings: Bearings, q: bytes) -> tuple[Problem, ...]:
    """The problems at a pose q and at poses nearby. The result is cached: studies run a mechanism many times from one
    start."""
    start = np.frombuffer(q)
    near = nearby(system, start).poses if system.bodies <= THRESHOLDS.few_bodies else ()
    sharing = np.zeros((bearings.size, len(system.names.joints)), dtype=bool)
    for pose in (pose_of(start), *near):
        sharing |= _sharing(system, bearings, pose)
    return tuple(_described(system, bearings, sharing))


def _sharing(system: System, bearings: Bearings, pose: Pose) -> Flags:
    """Which joints each bearing shares its load with, (B, nj)."""
    stresses = self_stresses(system, pose)
    force, torque = reactions(system, pose, stresses)
    size: Array = np.linalg.norm(force, axis=-1) * system.length + np.linalg.norm(torque, axis=-1)
    size = size / np.maximum(size.max(axis=-1, keepdims=True, initial=0.0), np.finfo(float).tiny)
    arbitrary = load(bearings, supports(system, bearings, pose, stresses)) - bearings.preload
    arms = np.maximum(bearings.radial, bearings.axial)
    shared = arbitrary * system.length > THRESHOLDS.no_part * arms
    return np.array(
        [(size[shared[:, b]] > THRESHOLDS.no_part).any(axis=0) for b in range(bearings.size)], dtype=bool
    ).reshape(bearings.size, -1)


def _described(system: System, bearings: Bearings, sharing: Flags) -> Iterator[Problem]:
    """A problem for each bearing that shares its load."""
    frictions, forces = system.frictions, system.forces
    for b in np.flatnonzero(sharing.any(axis=1)):
        place = None
        if frictions is not None and b in frictions.bearing:
            k = int(np.flatnonzero(frictions.bearing == b)[0])
            owner, place = frictions.owners[k], frictions.places[k]
        else:
            owner = f"force '{forces.law_owners[int(np.flatnonzero(forces.laws.bearing == b)[0])]}'"
        joint = int(bearings.joint[b])
        others = ", ".join(f"'{name}'" for j, name in enumerate(system.names.joints) if sharing[b, j] and j != joint)
        message = (
            f"{owner} depends on the load of joint '{system.names.joints[joint]}', which is not unique: "
            f"redundant constraints can share it in any proportion with {others}"
        )
        hint = "free a direction in one of these joints that the others hold, as a spherical or cylindrical joint does"
        yield Problem(message, place, hint)
