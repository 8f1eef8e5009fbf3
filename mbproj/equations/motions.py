"""Values that motions prescribe: f, f' and f'' of their rows s(q) - start - f(t) = 0, and the teeth in mesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from mbproj.base.arrays import Numbers, like_of
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import SimulationError
from mbproj.model.system import System

if TYPE_CHECKING:
    from mbproj.equations.turning import Teeth


@dataclass(frozen=True, eq=False)
class Drive:
    """The values of the coordinates that the k motions drive, in m and rad, their rates and accelerations, (..., k).

    C_t is -`rate` and C_tt is -`acceleration` in the motions' rows, and 0 in the others. `teeth`: those in mesh, where
    turns are counted; without them, gears and screws close to the nearest teeth."""

    value: Numbers
    rate: Numbers
    acceleration: Numbers
    teeth: Teeth | None = None


#: The drive of a system without motions, where no turns are counted.
NO_DRIVE = Drive(np.zeros(0), np.zeros(0), np.zeros(0))


def drive_at(system: System, t: Numbers | float, teeth: Teeth | None = None) -> Drive:
    """Return the values that motions prescribe at the times t (...).

    Raises SimulationError that names the motion and the expression without a finite value or derivative there.
    """
    if not system.driven:
        none = np.zeros((*np.shape(t), 0))
        return Drive(none, none, none, teeth)
    from mbproj.functions.series import run, time_series

    time, programs = time_series(np.asarray(t)), system.motions.programs
    series = [run(programs, index, [time]) for index in range(system.driven)]
    drive = np.empty((3, *np.shape(t), system.driven), like=like_of(*(each for terms in series for each in terms)))
    for index, terms in enumerate(series):
        for order, each in enumerate(terms):
            drive[order, ..., index] = each
    if not np.isfinite(drive).all():
        raise _not_finite(system, np.asarray(t), np.all(np.isfinite(drive), axis=0))
    value, rate, acceleration = drive
    return Drive(system.motions.start + value, rate, acceleration, teeth)


def _not_finite(system: System, t: Numbers, finite: Numbers) -> SimulationError:
    from mbproj.functions.series import failure, time_series

    *where, index = (int(axis[0]) for axis in np.nonzero(~finite))
    time = float(t[tuple(where)])
    programs = system.motions.programs
    cause = f"'{programs.texts[index]}' fails: {failure(programs, index, [time_series(np.asarray(time))])}"
    hint = "correct the expression, or end the run before that time"
    return SimulationError(time, cause, where=f"motion '{system.names.motions[index]}'", hint=hint)
