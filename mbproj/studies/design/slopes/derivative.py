"""Derivatives of what a trial gives by what varies: differences of runs, whose step follows from how exact a run is.
Runs with error control follow the steps of the one that they are beside."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbproj.arrays import Array
from mbproj.scene.records import Settings
from mbproj.scene.settings import settings_to_run
from mbproj.studies.design.trial import Trial, Wish

#: What a run with fixed steps, or a kinematic one, is exact to as a function of its numbers, in parts of its values.
GRAIN = 1e-15
#: Of a function that is exact to ε: the step of central differences, and of those to one side, ε to these powers.
CENTRAL, ONE_SIDED = 1.0 / 3.0, 0.5


def is_exact(settings: Settings) -> bool:
    """Whether a run is a smooth function of its numbers to round-off. Steps that error control chooses change with the
    numbers: such a run is smooth to its tolerance only, unless it follows the steps of another."""
    return settings.tolerance is None or bool(settings.kinematic)


def grain_of(settings: Settings) -> float:
    """What a run is exact to, as a function of its numbers, in parts of its values."""
    return GRAIN if settings.tolerance is None or is_exact(settings) else max(settings.tolerance, GRAIN)


def step_of(settings: Settings, power: float) -> float:
    """The step of differences in parts of a number's range."""
    return float(grain_of(settings) ** power)


def derivative(value: Callable[[Array], Array], u: Array, at: Array, h: float, central: bool) -> Array:
    """∂value/∂u (k, d) at u (d,), within the bounds 0 and 1; `at` (k,) is the value there. A design beside it that does
    not run has values that are NaN: the other side is taken; where neither runs, the column is NaN."""
    columns = [_column(value, u, at, index, h, central=central) for index in range(len(u))]
    return np.stack(columns, axis=1)


def _column(value: Callable[[Array], Array], u: Array, at: Array, index: int, h: float, *, central: bool) -> Array:
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
        return np.asarray((ends[0][1] - ends[1][1]) / (ends[0][0] - ends[1][0]))
    return (ends[0][1] - at) / ends[0][0] if ends else np.full(len(at), np.nan)


class Counted:
    """Trials of a wish by their shares u: each is run once, and counted."""

    def __init__(self, wish: Wish, run: Callable[..., Trial]) -> None:
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

    def slopes(self, part: Callable[[Trial], Array], u: Array, *, central: bool) -> Array:
        """∂part/∂u (k, d) of what a trial has, within the bounds. Trials beside the one at u follow its steps; where
        they cannot, differences are central ones, with a step that the tolerance allows."""
        settings, base = settings_to_run(self._wish.scene(u)), self(u)
        at, is_smooth = part(base), base.steps.known or is_exact(settings)
        grain = GRAIN if is_smooth else grain_of(settings)
        has_left = False

        def beside(v: Array) -> Array:
            nonlocal has_left
            if not base.steps.known:
                return part(self(v))
            self.count += 1
            trial = self._run(self._wish, v, base.steps)
            has_left = has_left or trial.steps.left
            return part(trial)

        central = central or not is_smooth
        found = derivative(beside, u, at, grain ** (CENTRAL if central else ONE_SIDED), central)
        if not has_left:
            return found
        return derivative(lambda v: part(self(v)), u, at, step_of(settings, CENTRAL), central=True)
