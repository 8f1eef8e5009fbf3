"""The files of a design: the best scene, with the comments of the original scene, and tables."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from mbproj.base.arrays import Array
from mbproj.base.errors import InputError, Problem
from mbproj.results.design_file import FILE, Drawn, Matched
from mbproj.results.output_files import DESIGN_DRAWN, DESIGNED, check_replaceable, csv, make_folder, write_text
from mbproj.results.table_files import write_csv
from mbproj.results.views import Table
from mbproj.scene.changes import Changes, text_with_changes
from mbproj.scene.ranges import column_of, with_unit
from mbproj.scene.scene import SceneText, read_scene_text
from mbproj.studies.design.run import FoundDesign
from mbproj.studies.design.spec import DesignSpec, Goal
from mbproj.studies.design.target import PATH, TIME
from mbproj.studies.measure.setting import shortest

# --- The data of a design's figures -----------------------------------------------------------------------------------


def data_to_draw(design: FoundDesign) -> Drawn:
    """The data to draw: for matches the run beside the data, for several goals their front; and the traces of the
    searches."""
    names = tuple(column_of(path) for path in design.spec.paths)
    if design.searches[0].goals.size:
        front = np.stack([signs(design) * each.goals for each in design.searches])
        goals = tuple(_axis_label(goal) for goal in design.spec.goals)
        return Drawn(f"{design.engine}, {design.runs} runs", goals[0], names, goals=goals, front=front)
    return Drawn(
        remark=f"{design.engine}, {len(design.searches)} starts, {design.runs} runs",
        value="rms of the residuals" if design.spec.targets else _axis_label(design.spec.goals[0]),
        names=names,
        matches=tuple(_matched(design)),
        traces=tuple(_trace(design, each.trace) for each in design.searches),
        correlation=None if design.knowledge is None else design.knowledge.correlation,
    )


def signs(design: FoundDesign) -> Array:
    """The signs, (g,), by which goals to be minimised become measured values."""
    return np.array([goal.sign for goal in design.spec.goals])


def _axis_label(goal: Goal) -> str:
    """The label of an axis."""
    return with_unit(goal.measure.name, goal.measure.unit)


def _trace(design: FoundDesign, trace: Array) -> Array:
    """The numbers of runs and the values to draw, (n, 2): the rms of residuals, or the measured goal."""
    runs, values = trace[:, 0], trace[:, 1]
    if design.spec.targets:
        return np.stack([runs, np.sqrt(2.0 * values / len(design.trial.residuals))], axis=1)
    return np.stack([runs, design.spec.goals[0].sign * values], axis=1)


def _matched(design: FoundDesign) -> Iterator[Matched]:
    for target, off in design.deviations:
        yield Matched(
            name=target.name,
            abscissa=None if target.over == PATH else target.abscissa,
            along="time (s)" if target.over == TIME else target.over,
            unit=target.unit,
            components=tuple(each.component for each in target.measures),
            given=target.values,
            reached=target.values + off,
        )


# --- The files of a design --------------------------------------------------------------------------------------------


OTHER = "choose another folder with -o"
#: The relative difference of numbers after writing and reading: the last digit at most.
SAME = 1e-15
FIRST = ("start", "value")


class DesignFolder:
    """The folder at `path`, with `best.yaml`, `starts.csv` and `design.json`. Raises InputError, before the work
    begins, where these files cannot be written."""

    def __init__(self, path: Path, force: bool) -> None:
        self.path, self._force = make_folder(path, OTHER), force
        self._scene, self._table = self.path / "best.yaml", self.path / "starts.csv"
        self._drawn = self.path / FILE
        check_replaceable(self._drawn, DESIGN_DRAWN, force=force, hint=OTHER)
        check_replaceable(self._scene, DESIGNED, force=force, hint=OTHER)
        check_replaceable(self._table, csv(FIRST), force=force, hint=OTHER)

    def write(self, design: FoundDesign) -> list[Path]:
        """Writes all files, and returns their paths."""
        table = starts_table(design)
        return [
            write_text(self._scene, best_scene(design), DESIGNED, force=self._force, hint=OTHER),
            write_csv(self._table, table.headings, table.rows, force=self._force, hint=OTHER),
            write_text(self._drawn, data_to_draw(design).text(), DESIGN_DRAWN, force=self._force, hint=OTHER),
        ]


def best_scene(design: FoundDesign) -> str:
    """The scene's text with the design's numbers in place of the original ones. Raises InputError where a number cannot
    be written."""
    spec = design.spec
    text = f"# Found by mbproj with '{spec.path.name}', in place of numbers of '{_name(spec)}'.\n"
    message, hint = "a number cannot be written into the scene's text", "vary parameters, which have a line each"
    failed = Problem(message, spec.place("vary"), hint)
    try:
        text += text_with_changes(spec.scene.text, _changes(design))
        read = SceneText(text, "best.yaml", spec.scene.path)
        read_scene_text(text, "best.yaml")
        numbers = read.numbers(spec.paths)
    except (ValueError, InputError) as error:
        raise InputError(failed) from error
    if not np.allclose(numbers, design.x, rtol=SAME, atol=0.0):
        raise InputError(failed)
    return text


def _name(spec: DesignSpec) -> str:
    return spec.scene.path.name if spec.scene.path is not None else "a scene"


def _changes(design: FoundDesign) -> Changes:
    changes: dict[str, Any] = {}
    for path, value, unit in zip(design.spec.paths, design.x.tolist(), design.spec.units, strict=True):
        keys = path.split(".") if "." in path else ["parameters", path]
        inside = changes
        for key in keys[:-1]:
            inside = inside.setdefault(key, {})
        inside[keys[-1]] = f"{shortest(value)} {unit}".strip()
    return changes


def starts_table(design: FoundDesign) -> Table:
    """A table with a row for each search, the best first: value, violation of the constraints, runs, and final numbers.
    With several goals a row is a design of the front, with its goals."""
    spec = design.spec
    names = [with_unit(column_of(path), unit) for path, unit in zip(spec.paths, spec.units, strict=True)]
    goals = spec.goals if design.searches[0].goals.size else ()
    signs = np.array([goal.sign for goal in goals])
    wanted = [with_unit(goal.measure.name, goal.measure.unit) for goal in goals]
    headings = (*FIRST, *wanted, "broken", "runs", *names, "cause")
    rows = tuple(
        (number, each.value, *(signs * each.goals).tolist(), each.broken, each.runs, *each.end.tolist(), each.cause)
        for number, each in enumerate(design.searches, 1)
    )
    return Table(headings, rows)
