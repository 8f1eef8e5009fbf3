"""The common part of commands that run many simulations: cells of tables, the run, files, the report."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from mbproj import outputs
from mbproj.cli.report.progress import telling
from mbproj.cli.report.text import json_text
from mbproj.cli.study_options import where_of
from mbproj.outputs import check_replaceable, make_folder
from mbproj.outputs.written_table import check_table, write_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from mbproj.results.views.table import Tabled

Found = TypeVar("Found")
OTHER_FOLDER = "choose another folder with -o"


def number(value: float, form: str = ".1e") -> str:
    """A number in a table; a dash for NaN."""
    return "-" if value != value else format(value, form)


def milliseconds(seconds: float) -> str:
    """A time in ms with three digits; a dash where it is infinite or NaN."""
    value = 1e3 * seconds
    return "-" if not seconds < float("inf") else f"{value:.3g}" if value < 1000.0 else f"{value:.0f}"


class Study:
    """A study with its files: the table DIR/<stem>.csv, the figure DIR/<stem>.<ending>, and the table for a paper.
    `options` are a command's options, of which those of `study_options.study` are removed. `first` are the first
    columns of the table. Raises InputError before the work begins where a file cannot be written, or the place of the
    work is not there."""

    def __init__(self, options: dict[str, Any], stem: str, first: tuple[str, str]) -> None:
        self._effort = {"processes": where_of(options), "fresh": options.pop("fresh")}
        if "repeat" in options:
            self._effort["repetitions"] = options.pop("repeat")
        self.stem = make_folder(options.pop("output"), OTHER_FOLDER) / stem
        self.force: bool = options.pop("force")
        ending = options.pop("ending")
        self._figure, self._table = Path(f"{self.stem}.{ending}"), Path(f"{self.stem}.csv")
        self._for_paper: Path | None = options.pop("table_file")
        self._as_json: bool = options.pop("as_json")
        check_replaceable(self._table, outputs.csv(first), force=self.force, hint=OTHER_FOLDER)
        check_replaceable(self._figure, outputs.picture(ending), force=self.force, hint=OTHER_FOLDER)
        check_table(self._for_paper, first, force=self.force)

    def result(self, function: Callable[..., Found], *what: Any, **given: Any) -> Found:
        """What `function` finds of `what`. It has its own defaults for options that are None; progress is shown."""
        chosen = {name: value for name, value in given.items() if value is not None}
        with telling(hidden=False) as tell:
            return function(*what, **chosen, **self._effort, tell=tell)

    def hand_over(
        self,
        found: Tabled,
        page: Figure,
        text: Callable[[], str],
        numbers: Callable[[], dict[str, Any]],
        notes: Sequence[str] = (),
        beside: Sequence[Path] = (),
    ) -> None:
        """Write table and figure, and print `text` and the names of all files, `beside` included. With --json, print
        one object instead: `numbers`, notes, files."""
        from mbproj.figures.save import save

        headings, rows = found.table.headings, found.table.rows
        table = outputs.write_csv(self._table, headings, rows, force=self.force, hint=OTHER_FOLDER)
        written = [table, *beside, save(page, self._figure, force=self.force)]
        if self._for_paper is not None:
            written.append(write_table(self._for_paper, headings, rows, force=self.force))
        if self._as_json:
            click.echo(json_text({**numbers(), "notes": notes, "files": written}))
            return
        click.echo(text())
        for note in notes:
            click.echo(f"note: {note}", err=True)
        for path in written:
            click.echo(path)
