"""Explains why a run has stopped where it cannot go on.

Lock-up: its motions drive the mechanism to where it cannot go. Examples are a rod too short for the turn of its crank,
or a slider pulled further than its links reach. Only a motion leads there: a free mechanism turns back before.

Lost mass: its motion loses all inertia, as for a massless crank and rod at their dead centre, where the slider stands.
Its speed then grows beyond all bounds.
"""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import nearest
from mbproj.dynamics.assembly.gauss_newton import moved
from mbproj.dynamics.equations.kinematics import pose_of
from mbproj.dynamics.equations.motions import Drive, drive_at
from mbproj.dynamics.rank.massless import least_inertia
from mbproj.errors import SimulationError
from mbproj.integrate.reporting.failures import locked
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

#: Changes of motions in rad and parts of the mechanism's length, by which it is moved beyond the point where the run
#: stopped.
FURTHER = (1e-3, 1e-2, 1e-1)


def explained(
    error: SimulationError, system: System, start: Array, reached: Callable[[], tuple[float, Array]]
) -> SimulationError:
    """Return an error that names the motion which has led to the `error` of a run; the error itself where none has.

    The mechanism has lost mass where a motion has inertia at the `start` (7n,), and hardly any near the last sample.
    `reached` returns that sample's time and q (7n,)."""
    if system.bodies > THRESHOLDS.large:
        return error
    error_explained = _lock_up(system, *reached(), error.time) if system.driven else None
    massless = not np.all(np.linalg.det(system.inertia) * system.mass)
    if error_explained is not None or not massless or isinstance(error.__cause__, SimulationError):
        return error_explained or error
    lost = _lost(system, start, *reached())
    if lost is None:
        return error
    cause = f"near here a motion moves no mass, so that its speed grows beyond all bounds: {lost}"
    hint = "give the bodies that move mass and inertia"
    return SimulationError(error.time, cause, where=error.where, hint=hint)


def _lock_up(system: System, t: float, q: Array, stop: float) -> SimulationError | None:
    """Return the error where the poses that meet the motions end on the way from q at time t to beyond `stop`; None
    where they do not."""
    from mbproj.dynamics.rank.lasting import NO_CONDITIONS

    try:
        at, drive = drive_at(system, t), drive_at(system, stop)
        for time in _way(system, t, stop, drive):
            before, at = at, drive_at(system, time)
            if np.abs((at.value - before.value) / _units(system)).max() > 4.0 * THRESHOLDS.short_way:
                return None
            q, residual = nearest(system, q, NO_CONDITIONS, at, THRESHOLDS.rounding)
            if np.abs(residual).max(initial=0.0) > THRESHOLDS.same_pose:
                return _locked(system, stop, drive, residual[system.joints.size :])
            drive = at if time > stop else drive
    except (SimulationError, np.linalg.LinAlgError):  # a motion may have no value there
        pass
    return None


def _way(system: System, t: float, stop: float, drive: Drive) -> list[float]:
    """Return times from t to `stop` and beyond; none where it is too far, or the motions stand still."""
    fastest = float(np.abs(drive.rate / _units(system)).max())
    steps = np.ceil(fastest * (stop - t) / THRESHOLDS.short_way)
    if not fastest > 0.0 or not steps <= THRESHOLDS.most_passes:
        return []
    return [*np.linspace(t, stop, int(steps) + 1).tolist(), *(stop + part / fastest for part in FURTHER)]


def _units(system: System) -> Array:
    """Return 1 rad, or the mechanism's length, for each motion, (k,)."""
    return system.row_scale[-system.driven :]


def _locked(system: System, t: float, drive: Drive, missed: Array) -> SimulationError:
    """Return the error of the motion whose own row has the largest violation in `missed` (k,)."""
    worst = int(np.argmax(np.abs(missed)))
    coordinate = int(system.motions.joint_coordinate[worst])
    name, unit = system.names.coordinates[coordinate], system.names.coordinate_units[coordinate]
    return locked(t, system.names.motions[worst], f"{name} = {drive.value[worst]:.3g} {unit}")


def _lost(system: System, start: Array, t: float, q: Array) -> str | None:
    """Return in words the motion of least inertia, followed both ways from q to where it has next to none; None without
    one."""
    drive, own = drive_at(system, t), least_inertia(system, pose_of(start))
    if own is None:
        return None
    ways = (_followed(system, drive, q, way, THRESHOLDS.rounded * own.inertia) for way in (1.0, -1.0))
    return next((name for name in ways if name is not None), None)


def _followed(system: System, drive: Drive, q: Array, way: float, enough: float) -> str | None:
    """Return in words the motion followed one way, in steps of half of the rest: the root of the inertia falls linearly
    towards a dead centre."""
    from mbproj.dynamics.rank.lasting import NO_CONDITIONS

    shortest, longest = THRESHOLDS.short_way / 5.0, 10.0 * THRESHOLDS.short_way
    before, last, step = None, 0.0, shortest
    for _ in range(THRESHOLDS.most_passes):
        lightest = least_inertia(system, pose_of(q))
        if lightest is None or lightest.inertia < enough:
            return None if lightest is None else str(lightest)
        size = sqrt(lightest.inertia)
        if size < last:
            step = min(max(0.5 * step * size / (last - size), shortest), longest)
        motion = lightest.motion if before is None or lightest.motion @ before > 0.0 else -lightest.motion
        before, last = motion, size
        q, left = nearest(system, moved(system, q, way * step * motion), NO_CONDITIONS, drive, THRESHOLDS.rounding)
        if np.abs(left).max(initial=0.0) > THRESHOLDS.same_pose:
            return None
    return None
