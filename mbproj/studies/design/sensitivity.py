"""The sensitivities of a scene's measures to its numbers, as a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mbproj.base.arrays import Array, Integers
from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem, SimulationError, choose_from
from mbproj.base.settings import Settings
from mbproj.results.analysis.expectations import components, measured, series
from mbproj.results.report_schema.studies import SENSITIVITY
from mbproj.results.views import Table
from mbproj.scene.ranges import column_of, units_of
from mbproj.scene.records import Expectation, Passage
from mbproj.scene.sampling import output_every, output_interval, whole_steps
from mbproj.scene.scene import Scene, SceneText
from mbproj.scene.settings import settings_to_run
from mbproj.studies.design.neighbours import FORMULAS, SIDES, WIDE, Followed, Formula, Slope, VariedNumber
from mbproj.studies.design.slopes import (
    CERTAIN,
    FOLLOWED,
    GRAIN,
    LEAVE_OUT,
    DifferenceSlopes,
    DifferenceWork,
    differences,
    off_by,
    tight,
)
from mbproj.studies.design.target import AXES
from mbproj.studies.measure.solve import MeasuredSamples, Mechanism
from mbproj.studies.parallel.hand_out import Where

# --- Slopes of measures by numbers of a scene -------------------------------------------------------------------------
# By dual numbers along its own run where the kernel can, else by differences of runs. Their uncertainty includes the
# error of the run's steps.


#: The shift of a neighbour relative to the number: the truncation of formulas is then as small as round-off.
STEP = 1e-5
#: Coarser runs show the error of steps. With error control: the factors of their tolerance, and the least factors of
#: their error. With fixed steps: the least factor of the error with steps twice as long.
LOOSER, WORSE_BY_TWO = ((1e4, 1e3), (1e2, 30.0)), 4.0
#: One coarser run is enough where the relative uncertainty of slopes is at most this.
ENOUGH = 1e-3
#: Measures among samples, which depend on the times of samples.
OF_SAMPLES = ("largest", "maximum", "minimum", "range")


def slopes_of(work: DifferenceWork, x: Array, scale: Array, where: Where) -> DifferenceSlopes:
    """Return the slopes at the numbers x (d,) of sizes `scale` (d,). Where dual numbers give no slope for a measure or
    a number, differences of runs do. Raises InputError or SimulationError where the scene's own run fails."""
    first = tight(work, FOLLOWED)
    centre, followed = _scene_run(first)
    seen = [k for k, each in enumerate(work.measures) if not followed.unseen(each)]
    why = np.array([[followed.why or followed.unseen(each)] * len(x) for each in work.measures], dtype=object)
    slopes, off = np.full((2, *why.shape), np.nan)
    runs = 1
    if seen and not followed.why:
        first = replace(first, measures=tuple(work.measures[k] for k in seen))
        for j, (each, uncertain) in enumerate(_by_duals(first, followed, centre[seen], x, scale)):
            why[seen, j] = each.why
            if not each.why:
                slopes[seen, j], off[seen, j] = each.slopes, uncertain
        if np.isfinite(slopes).any():
            runs += _add_discretisation(first, followed, x, scale, slopes, off, seen)
    failed, left = [""] * len(x), np.flatnonzero((why != "").any(axis=0))
    if len(left):
        part = replace(work, paths=tuple(work.paths[j] for j in left))
        others = _by_differences(part, x[left], scale[left], where)
        missing = why[:, left] != ""
        slopes[:, left] = np.where(missing, others.slopes, slopes[:, left])
        off[:, left] = np.where(missing, others.uncertainty, off[:, left])
        all_of_them = bool((why != "").all())
        runs += others.runs - 1 if all_of_them else others.runs
        centre = others.values if all_of_them else centre
        for j, cause in zip(left.tolist(), others.failed, strict=True):
            failed[j] = cause
    return DifferenceSlopes(centre, slopes, off, runs, tuple(failed), tuple(map(tuple, why)))


def _by_differences(work: DifferenceWork, x: Array, scale: Array, where: Where) -> DifferenceSlopes:
    """Return slopes by differences of runs. With fixed steps they are computed again with other steps, for the
    error."""
    slopes = differences(work, x, scale, where)
    if work.settings.tolerance is not None or work.settings.step is None:
        return slopes
    for settings, divisor in beside(work.settings, work.measures):
        try:
            other = differences(replace(work, settings=settings), x, scale, where)
        except InputError:
            continue
        off = slopes.uncertainty + np.abs(other.slopes - slopes.slopes) / divisor
        return replace(slopes, uncertainty=off, runs=slopes.runs + other.runs)
    return slopes


def _scene_run(work: DifferenceWork) -> tuple[Array, Followed]:
    """The measures (k,) of the scene's own run, and the run. Raises InputError or SimulationError where it fails."""
    followed = Followed(Mechanism.of(work.scene), work.settings, work.measures)
    samples = followed.run()
    followed.rows = _rows(work, samples)
    return np.array(samples.values(work.settings.duration)), followed


def _rows(work: DifferenceWork, samples: MeasuredSamples) -> Integers | None:
    """The ascending numbers of the samples that the measures depend on, with the first and the last; None where a
    measure depends on all."""
    time = samples["time"]
    rows = {0, len(time) - 1}
    for each in work.measures:
        value = measured(each, samples, work.settings.duration)
        if value is None or isinstance(each.at, Passage):
            return None
        rows.add(int(np.searchsorted(time, value.time)))
        if each.at == "range":
            rows.add(int(np.argmin(components(each, series(each, samples))[:, 0])))
    return np.array(sorted(rows))


def _by_duals(
    work: DifferenceWork, followed: Followed, centre: Array, x: Array, scale: Array, *, rough_ones: bool = False
) -> list[tuple[Slope, Array]]:
    """Return the slopes along the run by each number, and their uncertainty without the error of steps. Where the
    relative uncertainty exceeds CERTAIN, a formula of higher order is taken, unless `rough_ones` are enough."""

    def number(j: int) -> VariedNumber:
        path, at = work.paths[j], float(x[j])
        return VariedNumber(path, lambda away: work.scene.with_({path: at + away}), STEP * float(scale[j]))

    def measure(_: Scene, samples: MeasuredSamples) -> Array:
        return np.array(samples.values(work.settings.duration, work.measures))

    def by(numbers: list[int], formulas: Sequence[Formula]) -> list[Slope]:
        return followed.slopes([number(j) for j in numbers], measure, formulas)

    slopes = by([*range(len(x))], FORMULAS)
    off = [_uncertainty(each, centre) if not each.why else np.zeros(0) for each in slopes]

    def uncertain(j: int) -> bool:
        slope = slopes[j]
        return not slope.why and bool(np.any(off[j] > CERTAIN * np.abs(slope.slopes) + 10.0 * _grain(slope, centre)))

    rough = [j for j in range(len(x)) if not rough_ones and uncertain(j)]
    for j, better in zip(rough, by(rough, (WIDE,)), strict=True):
        if not better.why:
            slopes[j], off[j] = better, _uncertainty(better, centre)
    rough = [j for j in rough if uncertain(j)]
    # the effect of errors in the slopes of the model's numbers
    for j, side in zip(rough, by(rough, SIDES), strict=True):
        if not side.why:
            less = off_by(slopes[j].slopes, side.slopes)
            off[j] = np.minimum(off[j], _uncertainty(replace(slopes[j], cut=0.0), centre) + less)
    return list(zip(slopes, off, strict=True))


def _grain(slope: Slope, centre: Array) -> Array:
    """The error of a slope by round-off of the measures (k,)."""
    return np.asarray(GRAIN * np.abs(centre) / slope.step)


def _uncertainty(slope: Slope, centre: Array) -> Array:
    """The uncertainty of a slope, (k,), without the error of steps."""
    return off_by(slope.slopes, slope.rough(centre)) + slope.cut * np.abs(slope.slopes) + _grain(slope, centre)


def _add_discretisation(
    work: DifferenceWork, followed: Followed, x: Array, scale: Array, slopes: Array, off: Array, seen: list[int]
) -> int:
    """Add the error of steps, estimated by coarser runs or a finer one, to the uncertainty of the measures `seen`.
    Return the number of these runs."""
    trace = followed.trace
    if trace is None or trace.settings.kinematic is True:
        return 0
    tried, worst = 0, np.full((len(seen), len(x)), np.inf)
    for settings, divisor in beside(work.settings, work.measures):
        tried += 1
        other = replace(work, settings=settings)
        try:
            again = followed.again(settings)
            samples = again.run()
            again.rows = _rows(other, samples)
            values = np.array(samples.values(settings.duration, other.measures))
            others = _by_duals(other, again, values, x, scale, rough_ones=True)
        except (InputError, SimulationError):
            continue
        for j, (each, _) in enumerate(others):
            if not each.why:
                worst[:, j] = np.fmin(worst[:, j], np.abs(each.slopes - slopes[seen, j]) / divisor)
        if not np.any(worst > ENOUGH * np.abs(slopes[seen]) + off[seen]):
            break
    off[seen] += np.where(np.isfinite(worst), worst, 0.0)
    return tried


def beside(settings: Settings, measures: tuple[Expectation, ...]) -> list[tuple[Settings, float]]:
    """Settings of runs that show the error of steps, each with the divisor of the difference to it."""
    if settings.step is None:
        assert settings.tolerance is not None
        return [(replace(settings, tolerance=settings.tolerance * looser), worse) for looser, worse in LOOSER]
    finer = replace(settings, step=0.5 * settings.step, output_step=output_interval(settings))
    coarser = replace(settings, step=2.0 * settings.step, output_step=None)
    same = settings.output_step is not None and output_every(settings) % 2 == 0
    if same:
        coarser = replace(coarser, output_step=settings.output_step)
    if whole_steps(settings) % 2 or not (same or all(each.at not in OF_SAMPLES for each in measures)):
        return [(finer, 0.75)]
    return [(coarser, WORSE_BY_TWO), (finer, 0.75)]


# --- The sensitivities of a scene's measures to its numbers, as a table -----------------------------------------------


#: Words for the methods that find slopes, and for numbers without slopes: any other value of them makes the run fail.
DUALS, DIFFERENCES, LEFT_OUT = "dual numbers", "differences", "left out"
#: A measure is 0 up to round-off where its bound `below` is at most this, in SI units, and its value is below this part
#: of the bound.
BOUND, PART = 1e-6, 1e-3


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """∂(measure)/∂(number) at the scene's numbers x (d,): `values` (k,) of the measures, `slopes` (k, d) in SI units,
    each with its `uncertainty` (k, d), from two formulas of different order and runs with different steps. `runs`: the
    number of runs. `why` (k, d): the reason why a slope is not from dual numbers; empty where it is. `failed` (d,): the
    reason why runs with another value of a number fail, which makes its slopes NaN; empty for all others."""

    measures: tuple[Expectation, ...]
    paths: tuple[str, ...]
    units: tuple[str, ...]
    x: Array
    values: Array
    slopes: Array
    uncertainty: Array
    runs: int
    why: tuple[tuple[str, ...], ...]
    failed: tuple[str, ...]

    @property
    def elasticity(self) -> Array:
        """The change of a measure in percent by a change of a number by 1 %, (k, d). It is NaN for a measure that is 0,
        exactly or up to round-off."""
        nothing = [_is_nothing(*each) for each in zip(self.measures, self.values, strict=True)]
        size = np.where(nothing, np.nan, self.values)
        return np.asarray(self.slopes * self.x / size[:, None])

    @property
    def table(self) -> Table:
        """A table with a row for each measure and number; the rows of a measure are ordered by elasticity, the largest
        first."""
        rows = []
        for k, measure in enumerate(self.measures):
            order = np.argsort(-np.nan_to_num(np.abs(self.elasticity[k]), nan=-1.0), kind="stable")
            for j in order.tolist():
                unit = _per(measure.unit, self.units[j])
                numbers = (self.values[k], self.slopes[k, j], self.uncertainty[k, j], self.elasticity[k, j])
                how = (DIFFERENCES, self.why[k][j]) if self.why[k][j] else (DUALS, "")
                how = (LEFT_OUT, self.failed[j]) if self.failed[j] else how
                rows.append((measure.name, column_of(self.paths[j]), *map(float, numbers), unit, *how))
        return Table(tuple(fact.key for fact in SENSITIVITY[0].fields), tuple(rows))


def _is_nothing(measure: Expectation, value: float) -> bool:
    """Whether a measure is 0 up to round-off or the scene's own tolerance for it."""
    if measure.value == (0.0,):
        return abs(value) <= (measure.tolerance or 0.0)
    below = measure.below
    return value == 0.0 or (below is not None and below <= BOUND and abs(value) < PART * below)


def _per(unit: str, divisor: str) -> str:
    """The unit of a quotient of two quantities."""
    below = f"({divisor})" if "/" in divisor or "*" in divisor else divisor
    return f"{unit or '1'}/{below}" if divisor else unit


def sensitivities(scene: Scene, of: Sequence[str], to: Sequence[str], where: Where = None) -> Sensitivities:
    """Return the sensitivities of the expectations named in `of` to the numbers, by path or parameter name, in `to`. By
    default `of` is all expectations but diagnostics, and `to` all parameters, without those that cannot vary. Raises
    InputError for an unknown name, a path without a number, or a named number that cannot vary."""
    text = SceneText(scene.text, str(scene.path or "scene"), scene.path)
    paths = tuple(to) or tuple(scene.parameters)
    if not paths:
        raise InputError(Problem("the scene has no parameters", Place("--to"), "name numbers by their paths"))
    measures = _measures(scene, of)
    x = _numbers(text, scene, paths)
    size = Mechanism.of(scene).system.length
    units = tuple(units_of(dict.fromkeys(paths), text).values())
    scale = np.array([abs(value) or (size if unit == "m" else 1.0) for value, unit in zip(x, units, strict=True)])
    slopes = slopes_of(
        DifferenceWork(scene, settings_to_run(scene, by_options=False), paths, measures), x, scale, where
    )
    fails = [j for j, cause in enumerate(slopes.failed) if cause]
    if fails and (to or len(fails) == len(paths)):
        message = f"a run with another '{column_of(paths[fails[0]])}' fails: {slopes.failed[fails[0]]}"
        raise InputError(Problem(message, Place("--to"), LEAVE_OUT))
    results = (slopes.values, slopes.slopes, slopes.uncertainty, slopes.runs, slopes.why, slopes.failed)
    return Sensitivities(measures, paths, units, x, *results)


def _measures(scene: Scene, of: Sequence[str]) -> tuple[Expectation, ...]:
    known = {each.name: each for each in scene.expectations}
    if not known:
        hint = "add what is to be measured to the scene's 'expect' block"
        raise InputError(Problem("the scene expects nothing", Place("--of"), hint))
    for name in of:
        if name not in known:
            raise InputError(Problem(f"no expectation is called '{name}'", Place("--of"), choose_from(name, known)))
    physical = [each for each in known.values() if not _is_error(each)]
    chosen = [known[name] for name in of] if of else physical or list(known.values())
    scalar = [part for each in chosen for part in _scalars(each)]
    if not scalar or (of and any(not _scalars(each) for each in chosen)):
        hint = "give it a component: x, y, z or norm"
        raise InputError(Problem("an expectation of several components is no measure", Place("--of"), hint))
    return tuple(scalar)


def _is_error(each: Expectation) -> bool:
    """Whether an expectation is about an error, as a diagnostic or a violation."""
    return each.of == "diagnostic" or each.quantity.startswith("violation")


def _scalars(each: Expectation) -> list[Expectation]:
    """Split an expectation into scalars: itself, or its three components. An orientation has none, because its four
    numbers are not independent."""
    count = 1 if each.value is None else len(each.value)
    if count == 1:
        return [each]
    axes = AXES if count == len(AXES) else ()
    return [replace(each, name=f"{each.name}.{axis}", component=axis, value=None, below=np.inf) for axis in axes]


def _numbers(text: SceneText, scene: Scene, paths: Sequence[str]) -> Array:
    x = np.array(text.numbers(paths, scene.overrides))
    for path, value in zip(paths, x, strict=True):
        if not np.isfinite(value) or path.startswith("simulation."):
            names = [*scene.parameters]
            message = f"'{path}' is no number of the mechanism by itself"
            raise InputError(Problem(message, Place("--to"), choose_from(path, names, "parameters are")))
    return x
