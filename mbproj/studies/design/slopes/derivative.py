"""Derivatives of what a trial gives by what varies: by dual numbers along its run, or by differences of runs, whose
step follows from how exact a run is. Runs with error control follow the steps of the one that they are beside."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.errors import InputError
from mbproj.scene.records import Scene, Settings
from mbproj.scene.settings import settings_to_run
from mbproj.studies.design.slopes.neighbours import FORMULAS, SIDES, VariedNumber
from mbproj.studies.design.trial import Trial, Wish, trial_of, tried, tried_together

#: What a run with fixed steps, or a kinematic one, is exact to as a function of its numbers, in parts of its values.
GRAIN = 1e-15
#: Of a function that is exact to ε: the step of central differences, and of those to one side, ε to these powers.
CENTRAL, ONE_SIDED = 1.0 / 3.0, 0.5
#: So many of the last trials keep what slopes along their runs need.
RUNS = 2


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


def derivative(
    value: Callable[[Array], Array],
    u: Array,
    at: Array,
    h: float,
    central: bool,
    columns: Iterable[int] | None = None,
) -> Array:
    """∂value/∂u (k, d) at u (d,), within the bounds 0 and 1, or some of its columns; `at` (k,) is the value there. A
    design beside it that does not run has values that are NaN: the other side is taken; where neither runs, the column
    is NaN."""
    chosen = range(len(u)) if columns is None else columns
    return np.stack([_column(value, u, at, index, h, central=central) for index in chosen], axis=1)


def _sides(u: Array, index: int, h: float) -> list[Array]:
    """The designs beside u within the bounds 0 and 1."""
    step = h * np.eye(len(u))[index]
    return [beside for beside in (u + step, u - step) if 0.0 <= beside[index] <= 1.0]


def _column(value: Callable[[Array], Array], u: Array, at: Array, index: int, h: float, *, central: bool) -> Array:
    ends = []
    for beside in _sides(u, index, h):
        values = value(beside)
        if np.isfinite(values).all():
            ends.append((beside[index] - u[index], values))
        if ends and not central:
            break
    if len(ends) == 2:
        return np.asarray((ends[0][1] - ends[1][1]) / (ends[0][0] - ends[1][0]))
    return (ends[0][1] - at) / ends[0][0] if ends else np.full(len(at), np.nan)


class Counted:
    """Trials of a wish by their shares u: each is run once, and counted. `why` the last slopes came from differences
    of runs, for all measures; empty where dual numbers gave them."""

    def __init__(self, wish: Wish) -> None:
        self._wish, self._last, self._ahead = wish, dict[bytes, Trial](), dict[bytes, Trial]()
        self.count, self.why = 0, ""

    def __call__(self, u: Array) -> Trial:
        """The trial at u; the last ones are remembered, without their runs but for two."""
        key = u.tobytes()
        if key not in self._last:
            if len(self._last) > 4 * len(u) + 8:
                self._last.pop(next(iter(self._last)))
            for old in [*self._last][-RUNS:][:1]:
                self._last[old] = replace(self._last[old], followed=None)
            self._last[key] = self._ahead.pop(key) if key in self._ahead else tried(self._wish, u)
            self.count += 1
        return self._last[key]

    def ahead(self, points: Sequence[Array]) -> None:
        """Run designs together that are asked for next."""
        missing = [u for u in points if u.tobytes() not in self._last]
        trials = tried_together(self._wish, missing)
        self._ahead = {u.tobytes(): trial for u, trial in zip(missing, trials, strict=True)}

    def slopes(self, part: Callable[[Trial], Array], u: Array, *, central: bool) -> Array:
        """∂part/∂u (k, d) of what a trial has, within the bounds: by dual numbers along its run, and where these are
        not known by differences of trials."""
        base = self(u)
        if base.runs and base.followed is None:
            base = tried(self._wish, u)
        at, followed, slopes = part(base), base.followed, np.full((len(part(base)), len(u)), np.nan)
        self.why = "" if followed is None else followed.misses
        if followed is not None and not self.why and np.isfinite(at).all():
            missing, duration = followed.missing, followed.settings.duration
            by_column = followed.slopes(
                [self._number(u, index, central=central) for index in range(len(u))],
                lambda scene, samples: part(trial_of(self._wish, scene.parameters, samples, duration, missing)),
                FORMULAS if central else SIDES,
            )
            self.why = next((each.why for each in by_column if each.why), "")
            for index, each in enumerate(by_column):
                if not each.why:
                    slopes[:, index] = each.slopes
        left = ~np.isfinite(slopes)
        columns = np.flatnonzero(left.any(axis=0))
        if len(columns):
            others = self._by_differences(part, u, base, columns.tolist(), central=central)
            slopes[:, columns] = np.where(left[:, columns], others, slopes[:, columns])
        return slopes

    def _number(self, u: Array, index: int, *, central: bool) -> VariedNumber:
        """A share, within the bounds 0 and 1."""

        def scene(away: float) -> Scene:
            beside = u.copy()
            beside[index] += away
            if not 0.0 <= beside[index] <= 1.0:
                raise InputError("a neighbour is beyond a bound")
            return self._wish.scene(beside)

        return VariedNumber(self._wish.paths[index], scene, GRAIN ** (CENTRAL if central else ONE_SIDED))

    def _by_differences(
        self, part: Callable[[Trial], Array], u: Array, base: Trial, columns: Iterable[int], *, central: bool
    ) -> Array:
        """Trials beside the one at u follow its steps; where they cannot, differences are central ones, with a step
        that the tolerance allows."""
        settings = settings_to_run(self._wish.scene(u), by_options=False)
        at, is_smooth = part(base), base.steps.known or is_exact(settings)
        grain = GRAIN if is_smooth else grain_of(settings)
        has_left = False

        def beside(v: Array) -> Array:
            nonlocal has_left
            self.count += 1
            trial = tried(self._wish, v, base.steps)
            has_left = has_left or trial.steps.left
            return part(trial)

        central, chosen = central or not is_smooth, [*columns]
        h = grain ** (CENTRAL if central else ONE_SIDED)
        if base.steps.known:
            slopes = derivative(beside, u, at, h, central, chosen)
            if not has_left:
                return slopes
            h, central = step_of(settings, CENTRAL), True
        self.ahead([v for index in chosen for v in _sides(u, index, h)[: 1 + central]])
        return derivative(lambda v: part(self(v)), u, at, h, central, chosen)
