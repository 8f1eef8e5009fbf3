"""Finds whether a run has stopped because its motions drive the mechanism to where it cannot go. Examples are a rod too
short for the turn of its crank, or a slider pulled further than its links reach. Only a motion leads there: a free
mechanism turns back before."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import nearest
from mbproj.dynamics.equations.motions import Drive, drive_at
from mbproj.errors import SimulationError
from mbproj.integrate.reporting.failures import locked
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

#: The mechanism is led beyond the point where the run stopped, while motions change by these amounts in rad and parts
#: of its length.
FURTHER = (1e-3, 1e-2, 1e-1)


@contextmanager
def naming_lock_up(system: System, reached: Callable[[], tuple[float, Array]]) -> Iterator[None]:
    """Replace the error of a run in this block by one that names the motion, where no near pose meets the motions'
    values. `reached` returns the last sample's time and q (7n,)."""
    try:
        yield
    except SimulationError as error:
        tells = system.driven > 0 and system.bodies <= THRESHOLDS.large
        found = _lock_up(system, *reached(), error.time) if tells else None
        if found is None:
            raise
        raise found from error


def _lock_up(system: System, t: float, q: Array, stop: float) -> SimulationError | None:
    """Return the error where the poses that meet the motions end on the way from q at time t to beyond `stop`; None
    where they do not."""
    from mbproj.dynamics.rank.nearby import NO_CONDITIONS

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
