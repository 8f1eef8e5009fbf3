"""`mbproj.sweep`: the command of this name in one call, whose table is an object."""

from __future__ import annotations

from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import Any, final

import numpy as np
import numpy.typing as npt

from mbproj.calls.given import by_arguments
from mbproj.dataclass import dataclass
from mbproj.outputs import check_replaceable
from mbproj.results.views.frames import needed
from mbproj.scene.text.suggestions import choose_from
from mbproj.studies.sweep import arrays, summary
from mbproj.studies.sweep.folder import OTHER, Folder
from mbproj.studies.sweep.run import Progress, run_sweep
from mbproj.studies.sweep.spec import read_spec

#: Rows that a notebook shows.
SHOWN = 20


@final
@dataclass(frozen=True)
class SweepTable:
    """A row a case: `headings` as in summary.csv, `rows` with None where a case has no number. `progress` says how many
    were computed, known from before, and have failed; `folder` is where they are kept."""

    headings: tuple[str, ...]
    rows: tuple[tuple[Any, ...], ...]
    progress: Progress
    folder: Path

    def __getitem__(self, heading: str) -> npt.NDArray[Any]:
        """The column with this heading, its unit left out or not; NaN where a case has no number. Raises KeyError with
        the nearest."""
        known = {name.partition(" (")[0]: k for k, name in enumerate(self.headings)}
        known.update({name: k for k, name in enumerate(self.headings)})
        if heading not in known:
            raise KeyError(f"the table has no column '{heading}'; {choose_from(heading, known)}")
        values = [row[known[heading]] for row in self.rows]
        is_text = any(isinstance(value, str) for value in values)
        return np.array(values, dtype=object) if is_text else np.array(values, dtype=float)

    def to_pandas(self) -> Any:
        """A DataFrame. Raises ImportError where pandas is not installed."""
        return needed("pandas").DataFrame(list(self.rows), columns=list(self.headings))

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{escape(name)}</th>" for name in self.headings)
        body = "".join(f"<tr>{''.join(map(_cell, row))}</tr>" for row in self.rows[:SHOWN])
        more = f"<caption>the first {SHOWN} of {len(self.rows)} cases</caption>" if len(self.rows) > SHOWN else ""
        return f"<table>{more}<tr>{head}</tr>{body}</table>"


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


def _cell(value: object) -> str:
    shown = "" if value is None else f"{value:g}" if isinstance(value, float) else escape(str(value))
    return f"<td>{shown}</td>"
