"""How much a number of a scene changes a measure: derivatives by differences of runs, each with what it may be off by.
They are of fourth order where two runs are not enough."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mbproj.analysis.expectations import measured
from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, MbprojError, Place, Problem
from mbproj.integrate import simulate
from mbproj.results.views.table import Table
from mbproj.scene.ranges.family import column_of, units_of
from mbproj.scene.read import SceneText
from mbproj.scene.records import Expectation, Scene, Settings
from mbproj.scene.settings import settings_to_run
from mbproj.scene.text.suggestions import choose_from
from mbproj.studies.design.derivative import CENTRAL, step_of
from mbproj.studies.measure.measured_samples import MeasuredSamples
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.parallel.hand_out import Where, in_parallel

#: Runs with error control are made to this tolerance: what they are uncertain by is divided by the step.
TOLERANCE = 1e-12
#: Runs beside the scene's own, in steps. The pair is enough where its slope is certain to this part of itself;
#: elsewhere there are two more, for a formula of fourth order.
PAIR, CERTAIN, FARTHER = (-1.0, 1.0), 1e-7, (-2.0, 2.0)


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """∂(measure)/∂(number) at the scene's numbers x (d,): `values` (k,) of the measures, `slopes` (k, d) in SI units,
    each with its `uncertainty` (k, d), from two formulas of different order. There were `runs` in all."""

    measures: tuple[Expectation, ...]
    paths: tuple[str, ...]
    units: tuple[str, ...]
    x: Array
    values: Array
    slopes: Array
    uncertainty: Array
    runs: int

    @property
    def elasticity(self) -> Array:
        """By how many percent a measure changes where a number changes by one, (k, d); NaN of a measure that is 0."""
        size = np.where(self.values == 0.0, np.nan, self.values)
        return np.asarray(self.slopes * self.x / size[:, None])

    @property
    def table(self) -> Table:
        """A row for each measure and number, those of a measure by their elasticity, the largest first."""
        rows = []
        for k, measure in enumerate(self.measures):
            order = np.argsort(-np.nan_to_num(np.abs(self.elasticity[k]), nan=-1.0), kind="stable")
            for j in order.tolist():
                unit = _per(measure.unit, self.units[j])
                numbers = (self.values[k], self.slopes[k, j], self.uncertainty[k, j], self.elasticity[k, j])
                rows.append((measure.name, column_of(self.paths[j]), *map(float, numbers), unit))
        return Table(("measure", "number", "value", "slope", "uncertainty", "elasticity", "unit"), tuple(rows))


def _per(unit: str, divisor: str) -> str:
    """The unit of a quotient."""
    below = f"({divisor})" if "/" in divisor or "*" in divisor else divisor
    return f"{unit or '1'}/{below}" if divisor else unit


@dataclass(frozen=True)
class _Work:
    scene: Scene
    settings: Settings
    paths: tuple[str, ...]
    measures: tuple[Expectation, ...]


def sensitivities(scene: Scene, of: Sequence[str], to: Sequence[str], where: Where = None) -> Sensitivities:
    """Of what the scene expects, `of` these names, to numbers by path or parameters by name; all where none is named,
    but for diagnostics.
    Raises InputError for a name that is not there, a number that cannot be told, or a run beside the scene's own that
    fails."""
    text = SceneText(scene.text, str(scene.path or "scene"), scene.path)
    paths = tuple(to) or tuple(scene.parameters)
    if not paths:
        raise InputError(Problem("the scene has no parameters", Place("--to"), "name numbers by their paths"))
    measures = _measures(scene, of)
    x = _numbers(text, scene, paths)
    settings = _tight(settings_to_run(scene))
    size = Mechanism.of(scene).system.length
    units = tuple(units_of(dict.fromkeys(paths), text).values())
    scale = np.array([abs(value) or (size if unit == "m" else 1.0) for value, unit in zip(x, units, strict=True)])
    work = _Work(scene, settings, paths, measures)

    steps = step_of(settings, CENTRAL) * scale

    def beside(numbers: Sequence[int], shifts: Sequence[float]) -> list[tuple[int, float]]:
        return [(j, float(x[j] + shift * steps[j])) for j in numbers for shift in shifts]

    everything = range(len(paths))
    own, *pairs = _all(work, [(-1, 0.0), *beside(everything, PAIR)], where)
    near = np.array(pairs).reshape(len(paths), len(PAIR), -1)
    noise = step_of(settings, 1.0) * np.abs(own)[:, None] / steps
    slopes = (near[:, 1] - near[:, 0]).T / (2.0 * steps)
    uncertainty = _off_by(slopes, (near[:, 1] - own).T / steps) + noise
    # A measure that a number hardly moves has no slope to be certain of, but for round-off.
    enough = np.maximum(CERTAIN * np.abs(slopes), 2.0 * noise)
    again = [j for j in everything if not np.all(uncertainty[:, j] <= enough[:, j])]
    if again:
        far = _all(work, beside(again, FARTHER), where).reshape(len(again), len(FARTHER), -1)
        wide = (far[:, 1] - far[:, 0]).T / (4.0 * steps[again])
        better = (4.0 * slopes[:, again] - wide) / 3.0
        uncertainty[:, again] = _off_by(better, slopes[:, again]) + noise[:, again]
        slopes[:, again] = better
    runs = 1 + len(PAIR) * len(paths) + len(FARTHER) * len(again)
    return Sensitivities(measures, paths, units, x, own, slopes, uncertainty, runs)


def _off_by(better: Array, rough: Array) -> Array:
    """What the better one of two formulas is off by: about the square of what they differ by, in parts of the value."""
    apart = np.abs(better - rough)
    return np.asarray(apart**2 / np.maximum(np.abs(better), apart + 1e-300))


def _all(work: _Work, items: Sequence[tuple[int, float]], where: Where) -> Array:
    """The measures (n, k) of all runs. Raises InputError where one fails."""
    found: list[list[float] | str] = [""] * len(items)
    for number, values in in_parallel(_run, work, items, where):
        found[number] = values
    for (j, _), values in zip(items, found, strict=True):
        if isinstance(values, str):
            what = "the scene's own run" if j < 0 else f"a run with another '{column_of(work.paths[j])}'"
            raise InputError(Problem(f"{what} fails: {values}", Place("--to"), "leave this number out"))
    return np.array(found, dtype=float)


def _tight(settings: Settings) -> Settings:
    return settings if settings.tolerance is None else replace(settings, tolerance=min(settings.tolerance, TOLERANCE))


def _measures(scene: Scene, of: Sequence[str]) -> tuple[Expectation, ...]:
    known = {each.name: each for each in scene.expectations}
    if not known:
        hint = "add what is to be measured to the scene's 'expect' block"
        raise InputError(Problem("the scene expects nothing", Place("--of"), hint))
    for name in of:
        if name not in known:
            raise InputError(Problem(f"no expectation is called '{name}'", Place("--of"), choose_from(name, known)))
    physical = [each for each in known.values() if each.of != "diagnostic"]  # the others are round-off, or a tolerance
    chosen = [known[name] for name in of] if of else physical or list(known.values())
    scalar = [each for each in chosen if each.value is None or len(each.value) == 1]
    if not scalar or (of and len(scalar) < len(chosen)):
        hint = "give it a component: x, y, z or norm"
        raise InputError(Problem("an expectation of several components is no measure", Place("--of"), hint))
    return tuple(scalar)


def _numbers(text: SceneText, scene: Scene, paths: Sequence[str]) -> Array:
    x = np.array(text.numbers(paths, scene.overrides))
    for path, value in zip(paths, x, strict=True):
        if not np.isfinite(value) or path.startswith("simulation."):
            names = [*scene.parameters]
            message = f"'{path}' is no number of the mechanism by itself"
            raise InputError(Problem(message, Place("--to"), choose_from(path, names, "parameters are")))
    return x


def _run(work: _Work, item: tuple[int, float]) -> list[float] | str:
    """The measures of a run with another value of one number, or why there are none."""
    j, value = item
    try:
        scene = work.scene if j < 0 else work.scene.with_({work.paths[j]: value})
        mechanism = Mechanism.of(scene)
        samples = MeasuredSamples(mechanism, work.measures)
        simulate(mechanism.system, mechanism.state, work.settings, samples, accounts=False)
    except MbprojError as error:
        return str(error)
    found = [measured(each, samples, work.settings.duration) for each in work.measures]
    return [float("nan") if each is None else float(each.values[0]) for each in found]
