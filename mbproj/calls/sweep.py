"""`mbproj.sweep`: the command of this name in one call, whose table is an object."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import final

from mbproj.calls.given import by_arguments
from mbproj.dataclass import dataclass
from mbproj.outputs import check_replaceable
from mbproj.results.views.table import Table
from mbproj.studies.sweep import arrays, summary
from mbproj.studies.sweep.folder import OTHER, Folder
from mbproj.studies.sweep.run import Progress, run_sweep
from mbproj.studies.sweep.spec import read_spec


@final
@dataclass(frozen=True)
class SweepTable(Table):
    """A row a case, with the headings of summary.csv. `progress` says how many were computed, known from before, and
    have failed; `folder` is where they are kept."""

    progress: Progress
    folder: Path

    __repr__ = Table.__repr__


def sweep(
    spec: str | Path,
    *,
    output: str | Path | None = None,
    jobs: int | None = None,
    timeout: float | None = None,
    most_failures: int | None = None,
    retry_failed: bool = False,
    fresh: bool = False,
    force: bool = False,
    progress: Callable[[Progress], None] = lambda progress: None,
) -> SweepTable:
    """Runs what is missing of the sweep that the file `spec` describes, as `mbproj sweep` does, and gives its table.

    `output` is the folder, by default that of the command; its summary.csv and summary.h5 are written too. A case may
    take `timeout` s; `jobs` processes work. `force` replaces a table that was changed by hand. Raises InputError where
    the file is wrong. A case that fails is a row.
    """
    path = Path(spec)
    with by_arguments():
        what = read_spec(path)
        folder = Folder(path.with_name(f"{path.stem}-sweep") if output is None else Path(output), what, fresh)
        with folder.store:
            for file, kind in ((folder.table, summary.KIND), (folder.arrays, arrays.KIND)):  # before the work
                check_replaceable(file, kind, force=force, hint=OTHER)
            reached = run_sweep(
                what,
                folder,
                jobs,
                timeout=timeout,
                most_failures=most_failures,
                retry_failed=retry_failed,
                tell=progress,
            )
            summary.write_table(what, folder, force)
            arrays.write_arrays(what, folder, force)
            rows = tuple(map(tuple, summary.cells(what, folder)))
    return SweepTable(tuple(summary.headings(what)), rows, reached, folder.path)
