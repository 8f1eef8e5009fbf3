"""The sensitivities of a scene's measures to its numbers, as a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mbproj.arrays import Array
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Place, Problem, choose_from
from mbproj.report_schema.designs import SENSITIVITY
from mbproj.results.views.table import Table
from mbproj.scene.ranges.family import column_of, units_of
from mbproj.scene.read import Scene, SceneText
from mbproj.scene.records import Expectation
from mbproj.scene.settings import settings_to_run
from mbproj.studies.design.matches import AXES
from mbproj.studies.design.slopes.differences import LEAVE_OUT, DifferenceWork
from mbproj.studies.design.slopes.of_measures import slopes_of
from mbproj.studies.measure.mechanism import Mechanism
from mbproj.studies.parallel.hand_out import Where

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
        return Table(tuple(fact.key for fact in SENSITIVITY), tuple(rows))


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
