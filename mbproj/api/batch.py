"""`mbproj.batch`: run many scenes and check their expectations, in one call."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from mbproj.api.arguments import Quantity, amount, by_arguments
from mbproj.dataclass import dataclass
from mbproj.errors import ExitCode, InputError, Place, Problem
from mbproj.results.views.table import Table, Tabled
from mbproj.studies.batch import SceneResult, Task, exit_code, run_batch, scene_paths, tasks
from mbproj.studies.parallel.client import Cluster, workplace
from mbproj.studies.parallel.progress import Tell, silent


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
    given = [paths] if isinstance(paths, (str, Path)) else list(paths)
    with by_arguments():
        seconds = amount(timeout, "timeout", "s", above=0.0)
        scenes = scene_paths(map(Path, given))
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
