"""Derivatives of a trial's results by the varied numbers: by dual numbers along its run, or by differences of runs. The
step of differences follows from the accuracy of a run. Runs with error control follow the steps of the original run.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import field, replace

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, SimulationError
from mbproj.base.settings import Settings
from mbproj.motion.kernel_run import FollowedSteps
from mbproj.scene.ranges import column_of
from mbproj.scene.records import Expectation
from mbproj.scene.scene import Scene
from mbproj.scene.settings import settings_to_run
from mbproj.studies.design.neighbours import FORMULAS, SIDES, VariedNumber
from mbproj.studies.design.trial import Trial, Wish, trial_of, tried, tried_by_arrays
from mbproj.studies.measure.solve import Mechanism, measured_run
from mbproj.studies.parallel.hand_out import Where, in_parallel

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


# --- Slopes of measures by differences of runs, each with its uncertainty ---------------------------------------------
# Runs with other numbers follow the steps of the scene's run, so that differences are exact to round-off. They are of
# fourth order where two runs are not enough.


#: The tolerance of runs with error control where others can follow their steps, and where they cannot: then the error
#: of a run is divided by the step of differences.
FOLLOWED, TOLERANCE = 1e-11, 1e-12
#: The shifts of a number in steps. The pair is enough where the relative uncertainty of its slope is at most CERTAIN.
#: Else two further runs give a formula of fourth order. Where one side does not run, both runs of the pair are on the
#: other side.
PAIR, CERTAIN, FARTHER = (-1.0, 1.0), 1e-7, (-2.0, 2.0)
#: The ratio of a fourth difference of noisy values to the noise.
FOURTH = 4.0
#: Relative noise above this does not widen the steps any more.
NOISIEST = 1e-9
LEAVE_OUT = "leave this number out"


@dataclass(frozen=True)
class DifferenceWork:
    """The common data of all runs: the scene, the numbers' `paths`, the measures, and the `steps` to follow."""

    scene: Scene
    settings: Settings
    paths: tuple[str, ...]
    measures: tuple[Expectation, ...]
    steps: FollowedSteps = field(default_factory=FollowedSteps)


@dataclass(frozen=True, eq=False)
class DifferenceSlopes:
    """Slopes of k measures by d numbers: `values` (k,), `slopes` (k, d), their `uncertainty` (k, d), and the number of
    `runs`. Slopes are NaN where runs could not follow the scene's run. `why` (k, d): the reason why a slope is not from
    dual numbers; empty where it is. `failed` (d,): the reason why runs fail on both sides of a number; empty where one
    side runs."""

    values: Array
    slopes: Array
    uncertainty: Array
    runs: int
    failed: tuple[str, ...]
    why: tuple[tuple[str, ...], ...] = ()


def differences(work: DifferenceWork, x: Array, scale: Array, where: Where) -> DifferenceSlopes:
    """Return the slopes at the numbers x (d,) of sizes `scale` (d,). Raises InputError where the scene's own run
    fails."""
    first = tight(work, FOLLOWED)
    steps = FollowedSteps()
    centre = _values(first, -1, _run(first, (-1, 0.0), steps)[0])
    if steps.are_recorded or is_exact(work.settings):
        slopes = _beside(replace(first, steps=steps), x, scale, centre, where)
        fails = np.array([bool(each) for each in slopes.failed], dtype=bool)
        left = np.flatnonzero(np.isnan(slopes.slopes).all(axis=0) & ~fails)
        if not len(left):
            return slopes
    else:
        left, nothing = np.arange(len(x)), np.full((len(centre), len(x)), np.nan)
        slopes = DifferenceSlopes(centre, nothing, nothing.copy(), 0, ("",) * len(x))
    paths = tuple(work.paths[j] for j in left)
    free = replace(tight(work, TOLERANCE), paths=paths)
    centre = _values(free, -1, _run(free, (-1, 0.0))[0])
    others = _beside(free, x[left], scale[left], centre, where)
    slopes.slopes[:, left], slopes.uncertainty[:, left] = others.slopes, others.uncertainty
    failed = np.array(slopes.failed, dtype=object)
    failed[left] = others.failed
    return DifferenceSlopes(centre, slopes.slopes, slopes.uncertainty, slopes.runs + others.runs, tuple(failed))


def tight(work: DifferenceWork, tolerance: float) -> DifferenceWork:
    """Return the work with this tolerance, where the scene's own tolerance is larger."""
    settings = work.settings
    if settings.tolerance is None:
        return work
    return replace(work, settings=replace(settings, tolerance=min(settings.tolerance, tolerance)))


def _beside(work: DifferenceWork, x: Array, scale: Array, centre: Array, where: Where) -> DifferenceSlopes:
    """Return the slopes by runs with changed numbers, which follow the steps of the scene's own run if these are
    known. The measures of that run are `centre` (k,)."""
    noise, noise_runs = _noise(work, x, scale, centre, where)
    part = float(np.max(noise / np.where(centre == 0.0, np.inf, np.abs(centre)), initial=_grain(work)))
    h = min(part, NOISIEST) ** CENTRAL * scale
    runs = _Runs(work, x, h, centre, where)
    runs.make([(j, shift) for j in range(len(x)) for shift in PAIR])
    failed = tuple(runs.failure(j) for j in range(len(x)))
    everything = [j for j in range(len(x)) if not failed[j]]
    runs.make([(j, 2.0 * side) for j in everything if (side := runs.side(j)) != 0.0])
    slopes, off = np.full((2, len(centre), len(x)), np.nan)
    for j in everything:
        if not runs.has_left(j):
            slopes[:, j], off[:, j] = runs.slope(j)
    off += noise[:, None] / h
    # For a measure that a number hardly changes, the slope cannot be more certain than round-off.
    enough = np.maximum(CERTAIN * np.abs(slopes), 2.0 * noise[:, None] / h)
    again = [j for j in everything if runs.side(j) == 0.0 and not runs.has_left(j) and np.any(off[:, j] > enough[:, j])]
    runs.make([(j, shift) for j in again for shift in FARTHER])
    for j in again:
        slopes[:, j], error = runs.better_slope(j)
        off[:, j] = error + np.maximum(noise, runs.noise(j)) / h[j]
    return DifferenceSlopes(centre, slopes, off, 1 + noise_runs + runs.count, failed)


def _noise(work: DifferenceWork, x: Array, scale: Array, centre: Array, where: Where) -> tuple[Array, int]:
    """Return the deviation of the measures (k,) from smooth functions, estimated by runs with one of the numbers, and
    the count of these runs. Runs with fixed steps are exact to round-off."""
    least = _grain(work) * np.abs(centre)
    if is_exact(work.settings):
        return least, 0
    runs = _Runs(work, x, _grain(work) ** CENTRAL * scale, centre, where)
    for j in range(len(x)):
        runs.make([(j, shift) for shift in (*PAIR, *FARTHER)])
        if not runs.failure(j):
            fails = runs.side(j) != 0.0 or runs.has_left(j)
            return (least if fails else np.maximum(least, runs.noise(j))), runs.count
    return least, runs.count


def _grain(work: DifferenceWork) -> float:
    """The relative error of runs as functions of their numbers."""
    return GRAIN if work.steps.are_recorded else grain_of(work.settings)


class _Runs:
    """Runs with one number shifted by multiples of its step in `h` (d,): each run is made once."""

    def __init__(self, work: DifferenceWork, x: Array, h: Array, centre: Array, where: Where) -> None:
        self._work, self._x, self._h, self._centre, self._where = work, x, h, centre, where
        self._ended: dict[tuple[int, float], tuple[tuple[float, ...] | str, bool]] = {}

    @property
    def count(self) -> int:
        """The number of runs."""
        return len(self._ended)

    def make(self, wanted: Sequence[tuple[int, float]]) -> None:
        """Make the wanted runs (number, shift) that are not made yet."""
        items = [each for each in dict.fromkeys(wanted) if each not in self._ended]
        moved = [(j, float(self._x[j] + shift * self._h[j])) for j, shift in items]
        for number, values in in_parallel(_run, self._work, moved, self._where):
            self._ended[items[number]] = values

    def failure(self, j: int) -> str:
        """The reason why neither side of number j runs; empty where one does."""
        first, second = (self._ended[j, shift][0] for shift in PAIR)
        return first if isinstance(first, str) and isinstance(second, str) else ""

    def has_left(self, j: int) -> bool:
        """Whether runs with another value of number j could not follow the steps."""
        return any(self._ended[j, shift][1] for shift in PAIR)

    def side(self, j: int) -> float:
        """The side ±1 of its own value on which number j runs; 0 for both sides."""
        fails = [isinstance(self._ended[j, shift][0], str) for shift in PAIR]
        return float(fails[0]) - float(fails[1])

    def at(self, j: int, shift: float) -> Array:
        """The measures (k,) of the run with number j shifted by this multiple of its step."""
        return self._centre if shift == 0.0 else _values(self._work, j, self._ended[j, shift][0])

    def slope(self, j: int) -> tuple[Array, Array]:
        """The slope of second order and its uncertainty, (k,) each."""
        side, h = self.side(j), float(self._h[j])
        if side == 0.0:
            slope = (self.at(j, 1.0) - self.at(j, -1.0)) / (2.0 * h)
            return slope, off_by(slope, (self.at(j, 1.0) - self._centre) / h)
        near, far = self.at(j, side), self.at(j, 2.0 * side)
        slope = side * (4.0 * near - 3.0 * self._centre - far) / (2.0 * h)
        return slope, off_by(slope, side * (near - self._centre) / h)

    def better_slope(self, j: int) -> tuple[Array, Array]:
        """The slope of fourth order and its uncertainty, (k,) each."""
        slope, h = self.slope(j)[0], float(self._h[j])
        wide = (self.at(j, 2.0) - self.at(j, -2.0)) / (4.0 * h)
        better = (4.0 * slope - wide) / 3.0
        return better, off_by(better, slope)

    def noise(self, j: int) -> Array:
        """The deviation of the measures (k,) from smooth functions of a number, by a fourth difference, in which
        nothing else remains."""
        parts: Mapping[float, float] = {-2.0: 1.0, -1.0: -4.0, 0.0: 6.0, 1.0: -4.0, 2.0: 1.0}
        return np.abs(sum(part * self.at(j, shift) for shift, part in parts.items())) / FOURTH


def off_by(better: Array, rough: Array) -> Array:
    """The error of the better one of two formulas: relatively, about the square of their difference."""
    apart = np.abs(better - rough)
    return np.asarray(apart**2 / np.maximum(np.abs(better), apart + 1e-300))


def _values(work: DifferenceWork, j: int, values: tuple[float, ...] | str) -> Array:
    """The measures (k,) of a run. Raises InputError where it failed."""
    if isinstance(values, str):
        what = "the scene's own run" if j < 0 else f"a run with another '{column_of(work.paths[j])}'"
        raise InputError(Problem(f"{what} fails: {values}", Place("--to"), LEAVE_OUT))
    return np.array(values, dtype=float)


def _run(
    work: DifferenceWork, item: tuple[int, float], steps: FollowedSteps | None = None
) -> tuple[tuple[float, ...] | str, bool]:
    """The measures of a run with another value of one number, or the reason of its failure; and whether it could not
    follow the steps."""
    j, value = item
    steps = steps or (work.steps.of_another() if work.steps.are_recorded else None)
    try:
        scene = work.scene if j < 0 else work.scene.with_({work.paths[j]: value})
        samples, _ = measured_run(Mechanism.of(scene), work.settings, work.measures, steps)
    except InputError as error:
        return error.problems[0].message, False
    except SimulationError as error:
        return str(error), False
    return samples.values(work.settings.duration), steps is not None and steps.left
