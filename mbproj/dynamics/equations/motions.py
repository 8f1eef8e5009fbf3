"""What is prescribed at a time: f, f' and f'' of the motions' rows s(q) - start - f(t) = 0, and the teeth in mesh."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Numbers
from mbproj.dataclass import dataclass
from mbproj.dynamics.equations.teeth import Teeth
from mbproj.errors import SimulationError
from mbproj.functions.series import failure, run, time_series
from mbproj.model.system import System


@dataclass(frozen=True, eq=False)
class Drive:
    """The coordinates that the k motions prescribe, in m and rad, their rates and accelerations, (..., k): C_t is
    -`rate` and C_tt is -`acceleration` in their rows, and 0 in the others. `teeth`: those in mesh, where turns are
    counted; gears and screws close to the nearest ones where they are not."""

    value: Numbers
    rate: Numbers
    acceleration: Numbers
    teeth: Teeth | None = None


def drive_at(system: System, t: Numbers | float, teeth: Teeth | None = None) -> Drive | None:
    """What is prescribed at the times t (...); None for a system without motions where no teeth are given.

    Raises SimulationError that names the motion and the expression which has no finite value or derivatives there.
    """
    motions = system.motions
    if motions is None:
        nothing = np.zeros((*np.shape(t), 0))
        return None if teeth is None else Drive(nothing, nothing, nothing, teeth)
    time = time_series(np.asarray(t))
    found = [run(motions.programs, index, [time]) for index in range(system.driven)]
    value, rate, acceleration = (np.stack([series[order] for series in found], axis=-1) for order in range(3))
    finite = np.isfinite(value) & np.isfinite(rate) & np.isfinite(acceleration)
    if not np.all(finite):
        raise _not_finite(system, np.asarray(t), finite)
    return Drive(motions.start + value, rate, acceleration, teeth)


def _not_finite(system: System, t: Numbers, finite: Numbers) -> SimulationError:
    assert system.motions is not None
    *where, index = (int(axis[0]) for axis in np.nonzero(~finite))
    time = float(t[tuple(where)])
    programs = system.motions.programs
    cause = f"'{programs.texts[index]}' fails: {failure(programs, index, [time_series(np.asarray(time))])}"
    hint = "correct the expression, or end the run before that time"
    return SimulationError(time, cause, where=f"motion '{system.names.motions[index]}'", hint=hint)
