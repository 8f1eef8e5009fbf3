"""Derivatives of what a trial gives by what varies: differences of runs, whose step follows from how exact a run is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbproj.arrays import Array
from mbproj.scene.records import Settings
from mbproj.studies.design.trial import Trial, Wish

#: What a run with fixed steps, or a kinematic one, is exact to as a function of its numbers, in parts of its values.
GRAIN = 1e-15
#: Of a function that is exact to ε: the step of central differences, and of those to one side, ε to these powers.
CENTRAL, ONE_SIDED = 1.0 / 3.0, 0.5


def step_of(settings: Settings, power: float) -> float:
    """The step of differences in parts of a number's range. Steps that error control chooses change with the numbers:
    such a run is a smooth function to its tolerance only."""
    grain = GRAIN if settings.tolerance is None or settings.kinematic else max(settings.tolerance, GRAIN)
    return float(grain**power)


def derivative(value: Callable[[Array], Array], u: Array, at: Array, h: float, central: bool) -> Array:
    """∂value/∂u (k, d) at u (d,), within the bounds 0 and 1; `at` (k,) is the value there. A design beside it that does
    not run has values that are NaN: the other side is taken; where neither runs, the column is NaN."""
    columns = []
    for index in range(len(u)):
        ends = []
        for step in (h, -h):
            if 0.0 <= u[index] + step <= 1.0:
                beside = u.copy()
                beside[index] += step
                found = value(beside)
                if np.isfinite(found).all():
                    ends.append((beside[index] - u[index], found))
            if ends and not central:
                break
        if len(ends) == 2:
            columns.append((ends[0][1] - ends[1][1]) / (ends[0][0] - ends[1][0]))
        elif ends:
            columns.append((ends[0][1] - at) / ends[0][0])
        else:
            columns.append(np.full(len(at), np.nan))
    return np.stack(columns, axis=1)


class Counted:
    """Trials of a wish by their shares u: each is run once, and counted."""

    def __init__(self, wish: Wish, run: Callable[[Wish, Array], Trial]) -> None:
        self._wish, self._run, self._last = wish, run, dict[bytes, Trial]()
        self.count = 0

    def __call__(self, u: Array) -> Trial:
        """The trial at u; the last ones are remembered."""
        key = u.tobytes()
        if key not in self._last:
            if len(self._last) > 4 * len(u) + 8:
                self._last.pop(next(iter(self._last)))
            self._last[key] = self._run(self._wish, u)
            self.count += 1
        return self._last[key]
