"""Slopes of measures by numbers of a scene: by dual numbers along its own run where the kernel can, else by differences
of runs. Their uncertainty includes the error of the run's steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mbproj.analysis.expectations import components, measured
from mbproj.analysis.observed import series
from mbproj.arrays import Array, Integers
from mbproj.errors import InputError, SimulationError
from mbproj.scene.read import Scene
from mbproj.scene.records import Expectation, Passage, Settings
from mbproj.scene.sampling import output_every, output_interval, whole_steps
from mbproj.studies.design.slopes.derivative import GRAIN
from mbproj.studies.design.slopes.differences import (
    CERTAIN,
    FOLLOWED,
    DifferenceSlopes,
    DifferenceWork,
    differences,
    off_by,
    tight,
)
from mbproj.studies.design.slopes.neighbours import FORMULAS, SIDES, WIDE, Followed, Formula, Slope, VariedNumber
from mbproj.studies.measure.measured_samples import MeasuredSamples
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.parallel.hand_out import Where

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
    own, followed = _own_run(first)
    seen = [k for k, each in enumerate(work.measures) if not followed.unseen(each)]
    why = np.array([[followed.why or followed.unseen(each)] * len(x) for each in work.measures], dtype=object)
    slopes, off = np.full((2, *why.shape), np.nan)
    runs = 1
    if seen and not followed.why:
        first = replace(first, measures=tuple(work.measures[k] for k in seen))
        for j, (each, uncertain) in enumerate(_by_duals(first, followed, own[seen], x, scale)):
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
        own = others.values if all_of_them else own
        for j, cause in zip(left.tolist(), others.failed, strict=True):
            failed[j] = cause
    return DifferenceSlopes(own, slopes, off, runs, tuple(failed), tuple(map(tuple, why)))


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


def _own_run(work: DifferenceWork) -> tuple[Array, Followed]:
    """The measures (k,) of the scene's own run, and the run. Raises InputError or SimulationError where it fails."""
    followed = Followed(Mechanism.of(work.scene), work.settings, work.measures)
    samples = followed.run()
    followed.rows = _rows(work, samples)
    return _values(work, samples), followed


def _values(work: DifferenceWork, samples: MeasuredSamples) -> Array:
    values = [measured(each, samples, work.settings.duration) for each in work.measures]
    return np.array([np.nan if each is None else each.values[0] for each in values], dtype=float)


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
    work: DifferenceWork, followed: Followed, own: Array, x: Array, scale: Array, *, rough_ones: bool = False
) -> list[tuple[Slope, Array]]:
    """Return the slopes along the run by each number, and their uncertainty without the error of steps. Where the
    relative uncertainty exceeds CERTAIN, a formula of higher order is taken, unless `rough_ones` are enough."""

    def number(j: int) -> VariedNumber:
        path, at = work.paths[j], float(x[j])
        return VariedNumber(path, lambda away: work.scene.with_({path: at + away}), STEP * float(scale[j]))

    def measure(_: Scene, samples: MeasuredSamples) -> Array:
        return _values(work, samples)

    def by(numbers: list[int], formulas: Sequence[Formula]) -> list[Slope]:
        return followed.slopes([number(j) for j in numbers], measure, formulas)

    slopes = by([*range(len(x))], FORMULAS)
    off = [_uncertainty(each, own) if not each.why else np.zeros(0) for each in slopes]

    def uncertain(j: int) -> bool:
        slope = slopes[j]
        return not slope.why and bool(np.any(off[j] > CERTAIN * np.abs(slope.slopes) + 10.0 * _grain(slope, own)))

    rough = [j for j in range(len(x)) if not rough_ones and uncertain(j)]
    for j, better in zip(rough, by(rough, (WIDE,)), strict=True):
        if not better.why:
            slopes[j], off[j] = better, _uncertainty(better, own)
    rough = [j for j in rough if uncertain(j)]
    # the effect of errors in the slopes of the model's numbers
    for j, side in zip(rough, by(rough, SIDES), strict=True):
        if not side.why:
            less = off_by(slopes[j].slopes, side.slopes)
            off[j] = np.minimum(off[j], _uncertainty(replace(slopes[j], cut=0.0), own) + less)
    return list(zip(slopes, off, strict=True))


def _grain(slope: Slope, own: Array) -> Array:
    """The error of a slope by round-off of the measures (k,)."""
    return np.asarray(GRAIN * np.abs(own) / slope.step)


def _uncertainty(slope: Slope, own: Array) -> Array:
    """The uncertainty of a slope, (k,), without the error of steps."""
    return off_by(slope.slopes, slope.rough(own)) + slope.cut * np.abs(slope.slopes) + _grain(slope, own)


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
            others = _by_duals(other, again, _values(other, samples), x, scale, rough_ones=True)
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
