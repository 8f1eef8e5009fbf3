"""The studies as functions: `mbproj.compare`, `recommend`, `tradeoff`, `threshold`, `stability`, `verify`.

Each takes the arguments of the command of its name, and a scene in any form. Each result is also a table.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, TypeAlias, final

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import ExitCode, InputError, Place, Problem
from mbproj.commands.python.arguments import (
    Quantity,
    SceneLike,
    amount,
    by_arguments,
    names_of,
    scene_of,
)
from mbproj.results.views import Table, Tabled
from mbproj.studies.batch import SceneResult, Task, exit_code, run_batch, scene_paths, tasks
from mbproj.studies.design.run import FoundDesign, find_design
from mbproj.studies.design.sensitivity import Sensitivities, sensitivities
from mbproj.studies.design.spec import DesignSpec
from mbproj.studies.design.spec import read_spec as read_design
from mbproj.studies.parallel.cluster import Cluster, workplace
from mbproj.studies.parallel.progress import Tell, silent
from mbproj.studies.sweep import summary
from mbproj.studies.sweep.folder import Folder
from mbproj.studies.sweep.run import Progress, run_sweep
from mbproj.studies.sweep.spec import read_spec

if TYPE_CHECKING:
    pass


_NOTHING: Mapping[str, object] = {}
Names: TypeAlias = "str | Sequence[str]"
Numbers: TypeAlias = "Sequence[Quantity] | Quantity | None"


# --- `mbproj.sweep`, `sensitivity`, `fit` and `optimise` --------------------------------------------------------------
# The commands of these names, in one call each.


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
    scene: SceneLike,
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


# --- `mbproj.batch` ---------------------------------------------------------------------------------------------------
# Run many scenes and check their expectations, in one call.


@dataclass(frozen=True)
class Batch(Tabled):
    """The results of many scenes, in their order."""

    results: tuple[SceneResult, ...]

    @property
    def holds(self) -> bool:
        """Whether all scenes ran and meet all their expectations."""
        return exit_code(self.results) == ExitCode.DONE

    @property
    def table(self) -> Table:
        """A table with a row for each scene."""
        return Table.of(map(_row, self.results), "scene", "result")

    @property
    def line(self) -> str:
        """A line that counts the scenes by their result."""
        words = [result.word for result in self.results]
        return ", ".join(f"{words.count(word)} {word}" for word in dict.fromkeys(words))

    __repr__ = Tabled.__repr__


def batch(
    paths: str | Path | Sequence[str | Path],
    *,
    timeout: Quantity = 300.0,
    keep: str | Path | None = None,
    fresh: bool = False,
    resume: bool = False,
    jobs: int | Cluster | None = None,
    scheduler: str | None = None,
    scheduler_file: Path | None = None,
    progress: Tell = silent,
) -> Batch:
    """Runs the scenes at `paths` (files, folders or patterns such as "**/*.yaml") and checks their expectations.

    A scene may take `timeout` s. `keep` is the folder for results files, which are removed otherwise. Complete results
    there, of the same scene and by the same code, are not computed again, unless `fresh`. Raises InputError where there
    are no scenes, or a batch is to `resume` without `keep`. A scene that fails is a row of the result.
    """
    patterns = [paths] if isinstance(paths, (str, Path)) else list(paths)
    with by_arguments():
        seconds = amount(timeout, "timeout", "s", above=0.0)
        scenes = scene_paths(map(Path, patterns))
        where = workplace(jobs, scheduler, scheduler_file)
        results: dict[int, SceneResult] = {}

        def record(number: int, result: SceneResult) -> None:
            results[number] = result
            progress("scenes", len(results), len(scenes))

        with handed_out(scenes, None if keep is None else Path(keep), fresh=fresh, resume=resume) as work:
            run_batch(work, where, seconds, record)
    return Batch(tuple(results[number] for number in sorted(results)))


@contextmanager
def handed_out(scenes: Sequence[Path], keep: Path | None, *, fresh: bool, resume: bool) -> Iterator[list[Task]]:
    """Yield a task for each scene. Results are in the folder `keep`, from which the batch resumes unless it is `fresh`.
    Without `keep` they are in a temporary folder, which is removed when the block ends; then `resume` raises
    InputError."""
    if resume and keep is None:
        raise InputError(
            Problem("there is nothing to resume from", Place("--resume"), "add --keep, as at the first time")
        )
    if keep is not None:
        yield tasks(scenes, keep, True, not fresh)
        return
    with TemporaryDirectory(prefix="mbproj-batch-", ignore_cleanup_errors=True) as directory:
        yield tasks(scenes, Path(directory), keep=False)


def _row(result: SceneResult) -> dict[str, object]:
    worst = result.worst
    return {
        "scene": str(result.scene),
        "result": result.word,
        "expectations": len(result.outcomes),
        "hold": sum(outcome.holds for outcome in result.outcomes),
        "seconds": result.seconds,
        "formulation": result.formulation or "",
        "nearest to its limit": "" if worst is None else worst.expectation.name,
        "error": None if worst is None else worst.error,
        "allowed": None if worst is None else worst.expectation.tolerance,
        "message": result.message.partition("\n")[0],
    }
