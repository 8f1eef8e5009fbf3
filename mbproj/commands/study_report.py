"""`StudyReport`: the common part of all commands that run many simulations: their files and their report."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from mbproj.commands.figure_options import check_picture
from mbproj.commands.report.progress import telling
from mbproj.commands.report.text import json_text
from mbproj.results.output_files import JUNIT, FileKind, check_replaceable, csv, make_folder, picture, write_text
from mbproj.results.table_files import check_table, write_csv, write_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.results.views import Table
    from mbproj.studies.parallel.progress import Tell


Result = TypeVar("Result")
OTHER_FOLDER = "choose another folder with -o"
OTHER_REPORT = "choose another file with --junit"


class StudyReport:
    """The files and the report of a study.

    `options` are a command's options, of which those of `study_options` are removed. `first` are the first headings of
    the table. With a `stem`, the table is DIR/<stem>.csv and the figure is DIR/<stem>.<ending>. Otherwise --plot names
    the figure. Raises InputError before the work begins where a file cannot be written."""

    def __init__(self, options: dict[str, Any], first: Sequence[str], stem: str = "") -> None:
        def take(name: str) -> Any:
            return options.pop(name, None)

        self.force, self.quiet, self._as_json = map(take, ("force", "quiet", "as_json"))
        self._for_paper, self._figure, self._junit = map(take, ("table_file", "picture_path", "xml"))
        check_picture(self._figure, force=self.force)
        self._table: Path | None = None
        if stem:
            self.stem, ending = make_folder(take("output"), OTHER_FOLDER) / stem, take("ending")
            self._table, self._figure = Path(f"{self.stem}.csv"), Path(f"{self.stem}.{ending}")
            self.check(self._table, csv(first))
            self.check(self._figure, picture(ending))
        check_table(self._for_paper, first, force=self.force)

    @property
    def writes_table(self) -> bool:
        """Whether --write-table asks for the table."""
        return self._for_paper is not None

    @property
    def shows_table(self) -> bool:
        """Whether the report is a table for people, which neither --json nor --quiet replaces."""
        return not (self._as_json or self.quiet)

    def check(self, path: Path, kind: FileKind) -> None:
        """Raise InputError where a file of the study's folder must not be replaced."""
        check_replaceable(path, kind, force=self.force, hint=OTHER_FOLDER)

    def write_junit(self, text: Callable[[], str]) -> None:
        """Write the report for a pipeline, if --junit names one. An empty one, written before the work begins, shows
        whether it can be."""
        if self._junit is not None:
            write_text(self._junit, text(), JUNIT, force=self.force, hint=OTHER_REPORT)

    def telling(self, hidden: bool = False) -> AbstractContextManager[Tell]:
        """Show the progress while the block runs, unless it is `hidden`, or --quiet is given."""
        return telling(hidden=hidden or self.quiet)

    def hand_over(
        self,
        table: Table,
        text: str,
        numbers: Mapping[str, Any],
        draw: Callable[[], Figure | str] | None = None,
        notes: Sequence[str] = (),
        beside: Sequence[Path] = (),
        left: str = "",
    ) -> None:
        """Write the table and the figure, and print the report: `text`, notes, the names of files. With --json, print
        one object instead: `numbers`, notes, files.

        `left` is the part of the text that --quiet leaves. `draw` returns the figure, or the reason why there is none.
        `beside` are files of the study's folder that are already written. The names of files that options give go to
        stderr."""
        folder: list[Path] = []
        named: list[Path] = []
        said = list(notes)
        if self._table is not None:
            written = write_csv(self._table, table.headings, table.rows, force=self.force, hint=OTHER_FOLDER)
            folder.append(written)
        folder += beside
        if self._figure is not None and draw is not None:
            page = draw()
            if isinstance(page, str):
                said.append(page)
            else:
                from mbproj.show.figures.style import save

                (named if self._table is None else folder).append(save(page, self._figure, force=self.force))
        if self._for_paper is not None:
            named.append(write_table(self._for_paper, table.headings, table.rows, force=self.force))
        if self._as_json:
            click.echo(json_text({**numbers, "notes": said, "files": [*folder, *named]}))
        else:
            for line in [left] if self.quiet else [text, *folder]:
                click.echo(line, nl=bool(line))
            for note in said:
                click.echo(f"note: {note}", err=True)
        for path in named if not self.quiet else []:
            click.echo(path, err=True)
