"""Derivatives of a trial's results by the varied numbers: by dual numbers along its run, or by differences of runs. The
step of differences follows from the accuracy of a run. Runs with error control follow the steps of the original run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.errors import InputError
from mbproj.scene.read import Scene
from mbproj.scene.records import Settings
from mbproj.scene.settings import settings_to_run
from mbproj.studies.design.slopes.neighbours import FORMULAS, SIDES, VariedNumber
from mbproj.studies.design.trial import Trial, Wish, trial_of, tried, tried_by_arrays

#: The relative round-off of a run with fixed steps, or of a kinematic run, as a function of its numbers.
GRAIN = 1e-15
#: For a function with the relative error ε, the steps of central and of one-sided differences are ε to these powers.
CENTRAL, ONE_SIDED = 1.0 / 3.0, 0.5
#: The number of last trials whose data for slopes along their runs are kept.
RUNS = 2


def is_exact(settings: Settings) -> bool:
    """Whether a run is a smooth function of its numbers to round-off. Steps that error control chooses change with the
    numbers: such a run is smooth only to its tolerance, unless it follows the steps of another run."""
    return settings.tolerance is None or bool(settings.kinematic)


def grain_of(settings: Settings) -> float:
    """The relative error of a run as a function of its numbers."""
    return GRAIN if settings.tolerance is None or is_exact(settings) else max(settings.tolerance, GRAIN)


def step_of(settings: Settings, power: float) -> float:
    """The step of differences as a part of a number's range."""
    return float(grain_of(settings) ** power)


def derivative(
    value: Callable[[Array], Array],
    u: Array,
    at: Array,
    h: float,
    central: bool,
    columns: Iterable[int] | None = None,
) -> Array:
    """Return ∂value/∂u (k, d), or some of its columns, at u (d,) within the bounds 0 and 1; `at` (k,) is the value
    there. Values of a design that does not run are NaN: then the other side is taken. Where neither side runs, the
    column is NaN."""
    chosen = range(len(u)) if columns is None else columns
    return np.stack([_column(value, u, at, index, h, central=central) for index in chosen], axis=1)


def _sides(u: Array, index: int, h: float) -> list[Array]:
    """The designs at u ± h in one number that are within the bounds 0 and 1."""
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
    """Trials of a wish by their shares u: each is run once, and counted. `why`: the reason why the last slopes of all
    measures came from differences of runs; empty where dual numbers gave them."""

    def __init__(self, wish: Wish) -> None:
        self._wish, self._last, self._ahead = wish, dict[bytes, Trial](), dict[bytes, Trial]()
        self.count, self.why = 0, ""

    def __call__(self, u: Array) -> Trial:
        """The trial at u. The last trials are cached, and the last two of them with the data of their runs."""
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
        """Run the designs at these points together, for the calls that follow."""
        missing = [u for u in points if u.tobytes() not in self._last]
        trials = tried_by_arrays(self._wish, missing)
        self._ahead = {u.tobytes(): trial for u, trial in zip(missing, trials, strict=True)}

    def slopes(self, part: Callable[[Trial], Array], u: Array, *, central: bool) -> Array:
        """Return ∂part/∂u (k, d) of a `part` of a trial: by dual numbers along its run, and by differences of trials
        where these give no slope."""
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
        """One of the shares as a number that varies within the bounds 0 and 1."""

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
        """Return slopes by differences of trials that follow the steps of the trial at u. Where they cannot,
        differences are central, with a step according to the tolerance."""
        settings = settings_to_run(self._wish.scene(u), by_options=False)
        at, is_smooth = part(base), base.steps.are_recorded or is_exact(settings)
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
        if base.steps.are_recorded:
            slopes = derivative(beside, u, at, h, central, chosen)
            if not has_left:
                return slopes
            h, central = step_of(settings, CENTRAL), True
        self.ahead([v for index in chosen for v in _sides(u, index, h)[: 1 + central]])
        return derivative(lambda v: part(self(v)), u, at, h, central, chosen)
