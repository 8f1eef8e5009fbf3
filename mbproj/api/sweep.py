"""`mbproj.sweep`, `sensitivity`, `fit` and `optimise`: the commands of these names, in one call each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, final

from mbproj.api.arguments import Given, by_arguments, names_of, scene_of
from mbproj.api.studies import Names
from mbproj.dataclass import dataclass
from mbproj.errors import InputError, Problem
from mbproj.results.views.table import Table
from mbproj.studies.design.run import FoundDesign, find_design
from mbproj.studies.design.sensitivity import Sensitivities, sensitivities
from mbproj.studies.design.spec import DesignSpec
from mbproj.studies.design.spec import read_spec as read_design
from mbproj.studies.parallel.client import Cluster, workplace
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.studies.sweep import summary
from mbproj.studies.sweep.folder import Folder
from mbproj.studies.sweep.run import Progress, run_sweep
from mbproj.studies.sweep.spec import read_spec

_NOTHING: Mapping[str, object] = {}


@final
@dataclass(frozen=True)
class SweepTable(Table):
    """A table with a row for each case, with the headings of summary.csv. `progress` counts the cases that were
    computed, known from before, and failed; `folder` is where they are stored."""

    progress: Progress
    folder: Path

    __repr__ = Table.__repr__


def sweep(
    spec: str | Path,
    *,
    output: str | Path | None = None,
    jobs: int | Cluster | None = None,
    scheduler: str | None = None,
    scheduler_file: Path | None = None,
    timeout: float | None = None,
    most_failures: int | None = None,
    retry_failed: bool = False,
    fresh: bool = False,
    force: bool = False,
    progress: Callable[[Progress], None] = lambda progress: None,
) -> SweepTable:
    """Runs the missing cases of the sweep that the file `spec` describes, as `mbproj sweep` does, and returns its
    table.

    `output` is the folder, by default that of the command; its summary.csv and summary.h5 are written too. A case may
    take `timeout` s. The work is done by `jobs` processes, or by the Dask cluster whose `scheduler` is named. `force`
    replaces a table that was changed by hand. Raises InputError where the file is wrong. A case that fails is a row.
    """
    path = Path(spec)
    with by_arguments():
        what = read_spec(path)
        folder = Folder(path.with_name(f"{path.stem}-sweep") if output is None else Path(output), what, fresh)
        with folder.store:
            summary.check_summary(folder, force)  # before the work begins
            reached = run_sweep(
                what,
                folder,
                workplace(jobs, scheduler, scheduler_file),
                timeout=timeout,
                most_failures=most_failures,
                retry_failed=retry_failed,
                tell=progress,
            )
            summary.write_summary(what, folder, force)
            rows = tuple(map(tuple, summary.cells(what, summary.entries(what, folder))))
    return SweepTable(tuple(summary.headings(what)), rows, reached, folder.path)


def fit(
    spec: str | Path,
    *,
    engine: str | None = None,
    fresh: bool = False,
    jobs: int | Cluster | None = None,
    scheduler: str | None = None,
    scheduler_file: Path | None = None,
    progress: Tell = silent,
) -> FoundDesign:
    """Finds the numbers of a scene that match measurements best, as the file `spec` asks, with their uncertainty.
    Finished starts are not searched again, unless `fresh`. Nothing is written: `best_scene` has the text. Raises
    InputError where the file, its scene or its measurements are wrong, or no design runs."""
    return _find(spec, True, (jobs, scheduler, scheduler_file), engine=engine, fresh=fresh, tell=progress)


def optimise(
    spec: str | Path,
    *,
    engine: str | None = None,
    fresh: bool = False,
    jobs: int | Cluster | None = None,
    scheduler: str | None = None,
    scheduler_file: Path | None = None,
    progress: Tell = silent,
) -> FoundDesign:
    """Finds the numbers of a scene that make a measure smallest or largest under constraints. All else is as in
    `fit`."""
    return _find(spec, False, (jobs, scheduler, scheduler_file), engine=engine, fresh=fresh, tell=progress)


def _find(spec: str | Path, fits: bool, where: tuple[Any, ...], **options: Any) -> FoundDesign:
    with by_arguments():
        return find_design(spec_of(Path(spec), fits), workplace(*where), **options)


def spec_of(path: Path, fits: bool) -> DesignSpec:
    """The design that a file describes, for `fit` or for `optimise`. Raises InputError where it is for the other."""
    spec = read_design(path)
    if fits != bool(spec.targets):
        what, other = ("matches nothing", "optimise") if fits else ("has no goal", "fit")
        raise InputError(Problem(f"it {what}", spec.place(), f"use: mbproj {other} {path}"))
    return spec


def sensitivity(
    scene: Given,
    *,
    of: Names = (),
    to: Names = (),
    parameters: Mapping[str, object] = _NOTHING,
    jobs: int | Cluster | None = None,
    scheduler: str | None = None,
    scheduler_file: Path | None = None,
) -> Sensitivities:
    """The sensitivities of a scene's expectations `of` (by default all) to its numbers `to` (paths, or parameters by
    name); a table. Raises InputError for unknown names, and where a run with a changed number fails."""
    with by_arguments():
        where = workplace(jobs, scheduler, scheduler_file)
        return sensitivities(scene_of(scene, parameters, {}), names_of(of), names_of(to), where)
