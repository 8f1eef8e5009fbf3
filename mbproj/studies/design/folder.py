"""The files of a design: the best scene, with the comments of the original scene, and tables."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from mbproj.errors import InputError, Problem
from mbproj.output_files import DESIGN_DRAWN, DESIGNED, check_replaceable, csv, make_folder, write_csv, write_text
from mbproj.results.design_file import FILE
from mbproj.results.views.table import Table
from mbproj.scene.ranges.family import column_of, with_unit
from mbproj.scene.read import SceneText, read_scene_text
from mbproj.scene.text.rewrite import Changes, with_changes
from mbproj.studies.design.figure_data import data_to_draw
from mbproj.studies.design.run import FoundDesign
from mbproj.studies.design.spec import DesignSpec
from mbproj.studies.measure.setting import shortest

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
        text += with_changes(spec.scene.text, _changes(design))
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
