"""Whether a run has stopped because its motions drive the mechanism to where it cannot go: a rod that is too short for
the turn of its crank, a slider pulled further than its links reach. Nothing but a motion leads there: what moves freely
turns back before."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.assembly.assemble import nearest
from mbproj.dynamics.equations.motions import Drive, drive_at
from mbproj.errors import SimulationError
from mbproj.integrate.outcome.failures import locked
from mbproj.model.system import System
from mbproj.thresholds import THRESHOLDS

#: From where the run stopped the mechanism is led on by what moves the motions by these, rad and parts of its length.
FURTHER = (1e-3, 1e-2, 1e-1)


@contextmanager
def naming_lock_up(system: System, reached: Callable[[], tuple[float, Array]]) -> Iterator[None]:
    """A run that stops within raises an error that names the motion, where no pose near by meets what the motions
    prescribe then; `reached` gives the last sample's time and q (7n,)."""
    try:
        yield
    except SimulationError as error:
        tells = system.driven > 0 and system.bodies <= THRESHOLDS.dense_bodies
        found = _lock_up(system, *reached(), error.time) if tells else None
        if found is None:
            raise
        raise found from error


def _lock_up(system: System, t: float, q: Array, stop: float) -> SimulationError | None:
    """What is wrong where the poses that the motions prescribe come to an end from q at the time t to beyond `stop`."""
    from mbproj.dynamics.rank.nearby import NO_CONDITIONS

    try:
        at, drive = drive_at(system, t), drive_at(system, stop)
        for time in _way(system, t, stop, drive):
            before, at = at, drive_at(system, time)
            if np.abs((at.value - before.value) / _units(system)).max() > 4.0 * THRESHOLDS.short_way:
                return None
            q, residual = nearest(system, q, NO_CONDITIONS, at, THRESHOLDS.rounding)
            if np.abs(residual).max(initial=0.0) > THRESHOLDS.locked_open:
                return _locked(system, stop, drive, residual[system.joints.size :])
            drive = at if time > stop else drive
    except (SimulationError, np.linalg.LinAlgError):  # a motion without a value there, say
        pass
    return None


def _way(system: System, t: float, stop: float, drive: Drive) -> list[float]:
    """Times from t to `stop` and on; none where it is too far, or the motions stand."""
    fastest = float(np.abs(drive.rate / _units(system)).max())
    steps = np.ceil(fastest * (stop - t) / THRESHOLDS.short_way)
    if not fastest > 0.0 or not steps <= THRESHOLDS.locked_steps:
        return []
    return [*np.linspace(t, stop, int(steps) + 1).tolist(), *(stop + part / fastest for part in FURTHER)]


def _units(system: System) -> Array:
    """1 rad, or the mechanism's length, of each motion, (k,)."""
    return system.row_scale[-system.driven :]


def _locked(system: System, t: float, drive: Drive, missed: Array) -> SimulationError:
    """Of the motions, the one whose own row is missed by most, (k,)."""
    worst = int(np.argmax(np.abs(missed)))
    coordinate = int(system.motions.joint_coordinate[worst])
    name, unit = system.names.coordinates[coordinate], system.names.coordinate_units[coordinate]
    return locked(t, system.names.motions[worst], f"{name} = {drive.value[worst]:.3g} {unit}")
