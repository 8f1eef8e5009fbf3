"""Slopes of measures by numbers of a scene: by dual numbers along its own run where the kernel can, else by differences
of runs. What they may be off by counts the error of the run's steps, too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mbproj.analysis.expectations import components, measured
from mbproj.analysis.observed import series
from mbproj.arrays import Array
from mbproj.errors import InputError, MbprojError, Place, Problem, SimulationError
from mbproj.scene.records import Expectation, Passage, Scene, Settings
from mbproj.scene.sampling import output_every, output_interval, whole_steps
from mbproj.studies.design.slopes.derivative import GRAIN
from mbproj.studies.design.slopes.differences import CERTAIN, FOLLOWED, Slopes, Work, differences, off_by, tight
from mbproj.studies.design.slopes.neighbours import FORMULAS, SIDES, WIDE, Followed, Formula, Number, Slope
from mbproj.studies.measure.measured_samples import MeasuredSamples
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.parallel.hand_out import Where

#: Neighbours are so far away, in parts of a number: what formulas cut off is then as small as round-off.
STEP = 1e-5
#: Beside a run with error control a coarser one has a tolerance so many times as large, and errors more than so many
#: times; beside one with fixed steps they are twice as long, and errors more than so many times.
LOOSER, WORSE, WORSE_BY_TWO = 1e4, 1e3, 4.0
#: What is largest or smallest among samples changes with these.
OF_SAMPLES = ("largest", "maximum", "minimum", "range")


def slopes_of(work: Work, x: Array, scale: Array, where: Where) -> Slopes:
    """At the numbers x (d,) of sizes `scale` (d,). Raises InputError where the scene's own run fails, or where one by a
    difference does."""
    first = tight(work, FOLLOWED)
    own, followed = _own_run(first)
    unknown = Slope.unknown(followed.why), np.zeros(0)
    found = [unknown] * len(x) if followed.why else _by_duals(first, followed, own, x, scale)
    runs = 1
    slopes, off = np.full((2, len(own), len(x)), np.nan)
    for j, (each, uncertain) in enumerate(found):
        if not each.why:
            slopes[:, j], off[:, j] = each.slopes, uncertain
    left = np.flatnonzero([bool(each.why) for each, _ in found])
    if len(left) < len(x):
        runs += _add_discretisation(first, followed, x, scale, slopes, off)
    if len(left):
        part = replace(work, paths=tuple(work.paths[j] for j in left))
        others = _by_differences(part, x[left], scale[left], where)
        slopes[:, left], off[:, left] = others.slopes, others.uncertainty
        runs += others.runs if len(left) < len(x) else others.runs - 1
        own = others.values if len(left) == len(x) else own
    return Slopes(own, slopes, off, runs, tuple(each.why for each, _ in found))


def _by_differences(work: Work, x: Array, scale: Array, where: Where) -> Slopes:
    """By differences of runs; where steps are fixed, once more with others, for their error."""
    found = differences(work, x, scale, where)
    if work.settings.tolerance is not None or work.settings.step is None:
        return found
    for settings, divisor in beside(work.settings, work.measures):
        try:
            other = differences(replace(work, settings=settings), x, scale, where)
        except InputError:
            continue
        off = found.uncertainty + np.abs(other.slopes - found.slopes) / divisor
        return replace(found, uncertainty=off, runs=found.runs + other.runs)
    return found


def _own_run(work: Work) -> tuple[Array, Followed]:
    """The measures (k,) of the scene's own run, and that run. Raises InputError where it fails."""
    try:
        followed = Followed(Mechanism.of(work.scene), work.settings, work.measures)
        samples = followed.run()
        followed.rows = _rows(work, samples)
        return _values(work, samples), followed
    except MbprojError as error:
        problem = Problem(f"the scene's own run fails: {error}", Place("--to"), "leave this number out")
        raise InputError(problem) from None


def _values(work: Work, samples: MeasuredSamples) -> Array:
    found = [measured(each, samples, work.settings.duration) for each in work.measures]
    return np.array([np.nan if each is None else each.values[0] for each in found], dtype=float)


def _rows(work: Work, samples: MeasuredSamples) -> Array | None:
    """The samples that the measures look at, ascending, with the first and the last; None where some look at all."""
    time = samples["time"]
    rows = {0, len(time) - 1}
    for each in work.measures:
        found = measured(each, samples, work.settings.duration)
        if found is None or isinstance(each.at, Passage):
            return None
        rows.add(int(np.searchsorted(time, found.time)))
        if each.at == "range":
            rows.add(int(np.argmin(components(each, series(each, samples))[:, 0])))
    return np.array(sorted(rows))


def _by_duals(
    work: Work, followed: Followed, own: Array, x: Array, scale: Array, *, rough_ones: bool = False
) -> list[tuple[Slope, Array]]:
    """Along the run, by each number, and what that may be off by beside the error of steps. Where a formula is not
    certain to CERTAIN, by one of higher order, unless `rough_ones` will do."""

    def number(j: int) -> Number:
        path, at = work.paths[j], float(x[j])
        return Number(path, lambda away: work.scene.with_({path: at + away}), STEP * float(scale[j]))

    def measure(_: Scene, samples: MeasuredSamples) -> Array:
        return _values(work, samples)

    def by(numbers: list[int], formulas: Sequence[Formula]) -> list[Slope]:
        return followed.slopes([number(j) for j in numbers], measure, formulas)

    found = by([*range(len(x))], FORMULAS)
    off = [_off(each, own) if not each.why else np.zeros(0) for each in found]

    def uncertain(j: int) -> bool:
        slope = found[j]
        return not slope.why and bool(np.any(off[j] > CERTAIN * np.abs(slope.slopes) + 10.0 * _grain(slope, own)))

    rough = [j for j in range(len(x)) if not rough_ones and uncertain(j)]
    for j, better in zip(rough, by(rough, (WIDE,)), strict=True):
        if not better.why:
            found[j], off[j] = better, _off(better, own)
    rough = [j for j in rough if uncertain(j)]
    for j, side in zip(rough, by(rough, SIDES), strict=True):  # what the slopes of the model's numbers make of them
        if not side.why:
            less = off_by(found[j].slopes, side.slopes)
            off[j] = np.minimum(off[j], _off(replace(found[j], cut=0.0), own) + less)
    return list(zip(found, off, strict=True))


def _grain(slope: Slope, own: Array) -> Array:
    """What round-off of measures (k,) makes of a slope."""
    return np.asarray(GRAIN * np.abs(own) / slope.step)


def _off(slope: Slope, own: Array) -> Array:
    """What the formula of a slope may be off by, (k,), beside the error of steps."""
    return off_by(slope.slopes, slope.rough(own)) + slope.cut * np.abs(slope.slopes) + _grain(slope, own)


def _add_discretisation(work: Work, followed: Followed, x: Array, scale: Array, slopes: Array, off: Array) -> int:
    """Adds to what slopes may be off by what a coarser run, or a finer one, says of the error of steps. How many runs
    there were."""
    trace = followed.trace
    if trace is None or trace.settings.kinematic is True:
        return 0
    tried = 0
    for settings, divisor in beside(work.settings, work.measures):
        tried += 1
        other = replace(work, settings=settings)
        try:
            again = followed.again(settings)
            samples = again.run()
            again.rows = _rows(other, samples)
            found = _by_duals(other, again, _values(other, samples), x, scale, rough_ones=True)
        except (InputError, SimulationError):
            continue
        for j, (each, _) in enumerate(found):
            if not each.why:
                off[:, j] += np.abs(each.slopes - slopes[:, j]) / divisor
        break
    return tried


def beside(settings: Settings, measures: tuple[Expectation, ...]) -> list[tuple[Settings, float]]:
    """Settings of runs that show the error of steps, and what the difference to them is divided by."""
    if settings.step is None:
        assert settings.tolerance is not None
        return [(replace(settings, tolerance=settings.tolerance * LOOSER), WORSE)]
    finer = replace(settings, step=0.5 * settings.step, output_step=output_interval(settings))
    coarser = replace(settings, step=2.0 * settings.step, output_step=None)
    same = settings.output_step is not None and output_every(settings) % 2 == 0
    if same:
        coarser = replace(coarser, output_step=settings.output_step)
    if whole_steps(settings) % 2 or not (same or all(each.at not in OF_SAMPLES for each in measures)):
        return [(finer, 0.75)]
    return [(coarser, WORSE_BY_TWO), (finer, 0.75)]
