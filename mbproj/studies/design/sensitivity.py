"""How much a number of a scene changes a measure: derivatives by differences of runs of fourth order, each with what it
may be off by."""

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
from mbproj.studies.design.derivative import step_of
from mbproj.studies.measure.measured_samples import MeasuredSamples
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.parallel.hand_out import Where, in_parallel

#: Runs with error control are made to this tolerance: what they are uncertain by is divided by the step.
TOLERANCE = 1e-12
#: A formula of fourth order is best at this power of what a run is exact to.
FOURTH_ORDER = 1.0 / 5.0
#: The runs beside the scene's own, in steps, and their weights in the derivative of fourth and of second order.
BESIDE = (-2.0, -1.0, 1.0, 2.0)
FOURTH = np.array([1.0, -8.0, 8.0, -1.0]) / 12.0
SECOND = np.array([0.0, -1.0, 1.0, 0.0]) / 2.0


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """∂(measure)/∂(number) at the scene's numbers x (d,): `values` (k,) of the measures, `slopes` (k, d) in SI units,
    each with its `uncertainty` (k, d): the difference to the formula of second order, of which it is far the better."""

    measures: tuple[Expectation, ...]
    paths: tuple[str, ...]
    units: tuple[str, ...]
    x: Array
    values: Array
    slopes: Array
    uncertainty: Array

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
    x: tuple[float, ...]
    steps: tuple[float, ...]
    measures: tuple[Expectation, ...]


def sensitivities(scene: Scene, of: Sequence[str], to: Sequence[str], where: Where = None) -> Sensitivities:
    """Of what the scene expects, `of` these names, to numbers by path or parameters by name; all where none is named.
    Raises InputError for a name that is not there, a number that cannot be told, or a run beside the scene's own that
    fails."""
    text = SceneText(scene.text, str(scene.path or "scene"), scene.path)
    paths = tuple(to) or tuple(scene.parameters)
    if not paths:
        raise InputError(Problem("the scene has no parameters", Place("--to"), "name numbers by their paths"))
    measures = _measures(scene, of)
    x = _numbers(text, scene, paths)
    settings = _tight(settings_to_run(scene))
    h = step_of(settings, FOURTH_ORDER)
    size = Mechanism.of(scene).system.length
    units = tuple(units_of(dict.fromkeys(paths), text).values())
    steps = [h * (abs(value) or (size if unit == "m" else 1.0)) for value, unit in zip(x, units, strict=True)]
    work = _Work(scene, settings, paths, tuple(x.tolist()), tuple(steps), measures)
    items = [(-1, 0.0), *((j, shift) for j in range(len(paths)) for shift in BESIDE)]
    found: list[list[float] | str] = [""] * len(items)
    for number, values in in_parallel(_run, work, items, where):
        found[number] = values
    for (j, _), values in zip(items, found, strict=True):
        if isinstance(values, str):
            what = "the scene's own run" if j < 0 else f"a run with another '{column_of(paths[j])}'"
            raise InputError(Problem(f"{what} fails: {values}", Place("--to"), "leave this number out"))
    own, beside = np.array(found[0], dtype=float), np.array(found[1:], dtype=float).reshape(len(paths), len(BESIDE), -1)
    slopes, rough = (np.einsum("s,dsk->kd", weights, beside) / np.array(steps) for weights in (FOURTH, SECOND))
    # Of two formulas the better one is off by about the square of what they differ by, in parts of the value.
    apart, noise = np.abs(slopes - rough), step_of(settings, 1.0) * np.abs(own)[:, None] / np.array(steps)
    uncertainty = apart**2 / np.maximum(np.abs(slopes), apart + 1e-300) + noise
    return Sensitivities(measures, paths, units, x, own, slopes, uncertainty)


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
    chosen = [known[name] for name in of] if of else list(known.values())
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
    """The measures of a run with one number shifted by so many steps, or why there are none."""
    j, shift = item
    try:
        scene = work.scene if j < 0 else work.scene.with_({work.paths[j]: work.x[j] + shift * work.steps[j]})
        mechanism = Mechanism.of(scene)
        samples = MeasuredSamples(mechanism, work.measures)
        simulate(mechanism.system, mechanism.state, work.settings, samples)
    except MbprojError as error:
        return str(error)
    found = [measured(each, samples, work.settings.duration) for each in work.measures]
    return [float("nan") if each is None else float(each.values[0]) for each in found]
