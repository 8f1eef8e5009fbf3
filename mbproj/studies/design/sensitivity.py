"""How much numbers of a scene change its measures, as a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem, choose_from
from mbproj.results.views.table import Table
from mbproj.scene.ranges.family import column_of, units_of
from mbproj.scene.read import SceneText
from mbproj.scene.records import Expectation, Scene
from mbproj.scene.settings import settings_to_run
from mbproj.studies.design.matches import AXES
from mbproj.studies.design.slopes.differences import LEAVE_OUT, DifferenceWork
from mbproj.studies.design.slopes.of_measures import slopes_of
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.parallel.hand_out import Where

#: How slopes are found, and what is said of numbers that nobody named and that no run beside the scene's own has.
DUALS, DIFFERENCES, LEFT_OUT = "dual numbers", "differences", "left out"
#: What is to be below a bound of this size, in SI units, and is below this part of it, is 0 but for round-off.
BOUND, PART = 1e-6, 1e-3


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """∂(measure)/∂(number) at the scene's numbers x (d,): `values` (k,) of the measures, `slopes` (k, d) in SI units,
    each with its `uncertainty` (k, d), from two formulas of different order and runs with different steps. There were
    `runs` in all. Where dual numbers do not follow the scene's own run, or do not see the measure, `why` (k, d); empty
    where they do. Numbers that only the scene's own run has are left out: their slopes are NaN, and `failed` (d,) says
    why; it is empty for all others."""

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
        """By how many percent a measure changes where a number changes by one, (k, d); NaN of a measure that is 0, or
        that the scene says to be 0 but for round-off."""
        nothing = [_is_nothing(*each) for each in zip(self.measures, self.values, strict=True)]
        size = np.where(nothing, np.nan, self.values)
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
                how = (DIFFERENCES, self.why[k][j]) if self.why[k][j] else (DUALS, "")
                how = (LEFT_OUT, self.failed[j]) if self.failed[j] else how
                rows.append((measure.name, column_of(self.paths[j]), *map(float, numbers), unit, *how))
        names = ("measure", "number", "value", "slope", "uncertainty", "elasticity", "unit", "by", "because")
        return Table(names, tuple(rows))


def _is_nothing(measure: Expectation, value: float) -> bool:
    """Whether a measure is 0, as far as the scene itself can tell."""
    if measure.value == (0.0,):
        return abs(value) <= (measure.tolerance or 0.0)
    below = measure.below
    return value == 0.0 or (below is not None and below <= BOUND and abs(value) < PART * below)


def _per(unit: str, divisor: str) -> str:
    """The unit of a quotient."""
    below = f"({divisor})" if "/" in divisor or "*" in divisor else divisor
    return f"{unit or '1'}/{below}" if divisor else unit


def sensitivities(scene: Scene, of: Sequence[str], to: Sequence[str], where: Where = None) -> Sensitivities:
    """Of what the scene expects, `of` these names, to numbers by path or parameters by name; all where none is named,
    but for diagnostics. Of all parameters, those without a run beside the scene's own are left out. Raises InputError
    for a name that is not there, a number that cannot be told, or one by name that no other run has."""
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
    scalar = [part for each in chosen for part in _parts(each)]
    if not scalar or (of and any(not _parts(each) for each in chosen)):
        hint = "give it a component: x, y, z or norm"
        raise InputError(Problem("an expectation of several components is no measure", Place("--of"), hint))
    return tuple(scalar)


def _is_error(each: Expectation) -> bool:
    """Whether it is round-off, or a tolerance."""
    return each.of == "diagnostic" or each.quantity.startswith("violation")


def _parts(each: Expectation) -> list[Expectation]:
    """An expectation of a number; of three numbers its components; none of a turn, whose four are not independent."""
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
