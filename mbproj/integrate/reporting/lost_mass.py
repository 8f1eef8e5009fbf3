"""Finds whether a run has stopped because its motion loses all its mass: a crank and a rod without mass at their dead
centre, where their slider stands. Its speed then grows beyond all bounds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from math import sqrt

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import nearest
from mbproj.dynamics.assembly.gauss_newton import moved
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.equations.motions import Drive, drive_at
from mbproj.dynamics.rank.massless import least_inertia
from mbproj.errors import SimulationError
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS


@contextmanager
def naming_lost_mass(system: System, start: Array, reached: Callable[[], tuple[float, Array]]) -> Iterator[None]:
    """Replace the error of a run in this block by one that names the motion without mass.

    Such a motion moves mass at the `start` (7n,), and hardly any near the last sample; `reached` returns that sample's
    time and q (7n,)."""
    try:
        yield
    except SimulationError as error:
        is_named = isinstance(error.__cause__, SimulationError)
        massless = not np.all(np.linalg.det(system.inertia) * system.mass)
        tells = massless and not is_named and system.bodies <= THRESHOLDS.large
        found = _lost(system, start, *reached()) if tells else None
        if found is None:
            raise
        cause = f"near here a motion moves no mass, so that its speed grows beyond all bounds: {found}"
        hint = "give the bodies that move mass and inertia"
        raise SimulationError(error.time, cause, where=error.where, hint=hint) from error


def _lost(system: System, start: Array, t: float, q: Array) -> str | None:
    """Return in words the motion of least inertia, followed both ways from q to where it has next to none; None without
    one."""
    drive, own = drive_at(system, t), least_inertia(system, pose_of(start))
    if own is None:
        return None
    ways = (_followed(system, drive, q, way, THRESHOLDS.rounded * own.inertia) for way in (1.0, -1.0))
    return next((found for found in ways if found is not None), None)


def _followed(system: System, drive: Drive, q: Array, way: float, enough: float) -> str | None:
    """Return in words the motion followed one way, in steps of half of the rest: the root of the inertia falls linearly
    towards a dead centre."""
    from mbproj.dynamics.rank.nearby import NO_CONDITIONS

    shortest, longest = THRESHOLDS.short_way / 5.0, 10.0 * THRESHOLDS.short_way
    before, last, step = None, 0.0, shortest
    for _ in range(THRESHOLDS.most_passes):
        found = least_inertia(system, pose_of(q))
        if found is None or found.inertia < enough:
            return None if found is None else str(found)
        size = sqrt(found.inertia)
        if size < last:
            step = min(max(0.5 * step * size / (last - size), shortest), longest)
        motion = found.motion if before is None or found.motion @ before > 0.0 else -found.motion
        before, last = motion, size
        q, left = nearest(system, moved(system, q, way * step * motion), NO_CONDITIONS, drive, THRESHOLDS.rounding)
        if np.abs(left).max(initial=0.0) > THRESHOLDS.same_pose:
            return None
    return None
